/*
 * Misses over slots: slots on a scale of powers of two, misses from 0 up, a line a policy, and dashed
 * the misses that no size avoids. S3-FIFO is not drawn where it keeps nothing: every access is a miss
 * there, and the others would lie on the floor. The colours (Okabe's and Ito's) tell apart for every eye on white and
 * on black; what lies behind them follows the viewer's scheme.
 */
#include "cache_plot.h"

#include <math.h>

#include "svg.h"

enum { WIDTH = 920, HEIGHT = 500, LEFT = 100, RIGHT = 180, TOP = 56, BOTTOM = 60 };

const char *const cache_policy_labels[SIM_POLICIES] = {"LRU", "CLOCK", "ARC", "S3-FIFO", "OPT"};
static const char *const colours[SIM_POLICIES] = {"#2a86c8", "#e69f00", "#009e73", "#cc79a7", "#d55e00"};
/* Drawn from the last to the first, so that curves which coincide lie upon one another like bands. */
static const double widths[SIM_POLICIES] = {1.4, 2.8, 4.2, 5.6, 1.8};

struct frame {
	double low, high; /* log2 of slots */
	double top;       /* misses */
	double step;      /* between lines */
};

static double x_of(const struct frame *frame, double slots)
{
	return LEFT + (WIDTH - LEFT - RIGHT) * (log2(slots) - frame->low) / (frame->high - frame->low);
}

static double y_of(const struct frame *frame, double misses)
{
	return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * misses / frame->top;
}

static size_t first_drawn(const struct cache_curves *curves, int policy)
{
	size_t i = 0;
	while (policy == SIM_S3FIFO && i < curves->count && curves->slots[i] < SIM_S3FIFO_SLOTS_MIN)
		i++;
	return i;
}

static struct frame frame_of(const struct cache_curves *curves)
{
	struct frame frame = {log2(curves->slots[0]), log2(curves->slots[curves->count - 1]), 1, 1};
	if (frame.high - frame.low < 1) {
		frame.low -= 0.5;
		frame.high += 0.5;
	}
	double most = (double)curves->accesses->tile_count;
	for (int policy = 0; policy < SIM_POLICIES; policy++)
		for (size_t i = first_drawn(curves, policy); curves->wanted[policy] && i < curves->count; i++)
			most = fmax(most, (double)curves->misses[policy][i]);
	/* About five lines, of 1, 2 or 5 times a power of ten. */
	frame.step = fmax(svg_step(fmax(most, 1) / 5), 1);
	frame.top = frame.step * ceil(fmax(most, 1) / frame.step);
	return frame;
}

static void write_head(const struct cache_curves *curves, FILE *file)
{
	fprintf(file,
		"<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" viewBox=\"0 0 %d %d\">\n"
		"<style>\n"
		"text { font: 13px sans-serif; fill: #222 }\n"
		".back { fill: #fff } .line { stroke: #ddd } .axis { stroke: #222 } .floor { stroke: #666 }\n"
		"@media (prefers-color-scheme: dark) {\n"
		"  text { fill: #ddd }\n"
		"  .back { fill: #161616 } .line { stroke: #333 } .axis { stroke: #ddd } .floor { stroke: #aaa }\n"
		"}\n"
		"</style>\n"
		"<rect class=\"back\" width=\"%d\" height=\"%d\"/>\n"
		"<text x=\"%d\" y=\"26\" style=\"font-size: 15px\">Misses by slots: ",
		WIDTH, HEIGHT, WIDTH, HEIGHT, WIDTH, HEIGHT, LEFT);
	svg_text(curves->title, file);
	fprintf(file, "</text>\n<text x=\"%d\" y=\"44\">%zu accesses to %u tiles</text>\n", LEFT,
		curves->accesses->count, curves->accesses->tile_count);
}

static void write_axes(const struct frame *frame, FILE *file)
{
	for (double misses = 0; misses <= frame->top; misses += frame->step) {
		double y = y_of(frame, misses);
		fprintf(file, "<line class=\"line\" x1=\"%d\" x2=\"%d\" y1=\"%.1f\" y2=\"%.1f\"/>\n", LEFT, WIDTH - RIGHT,
			y, y);
		fprintf(file, "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%.0f</text>\n", LEFT - 8, y + 4, misses);
	}
	double every = ceil((frame->high - frame->low) / 10); /* so that the numbers stay apart */
	for (double power = ceil(frame->low); power <= frame->high; power += every) {
		double x = x_of(frame, exp2(power));
		fprintf(file, "<line class=\"axis\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%d\" y2=\"%d\"/>\n", x, x, HEIGHT - BOTTOM,
			HEIGHT - BOTTOM + 5);
		fprintf(file, "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%.0f</text>\n", x, HEIGHT - BOTTOM + 20,
			exp2(power));
	}
	fprintf(file, "<line class=\"axis\" x1=\"%d\" x2=\"%d\" y1=\"%d\" y2=\"%d\"/>\n", LEFT, WIDTH - RIGHT,
		HEIGHT - BOTTOM, HEIGHT - BOTTOM);
	fprintf(file, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">slots</text>\n", (LEFT + WIDTH - RIGHT) / 2,
		HEIGHT - 16);
	fprintf(file, "<text transform=\"translate(20 %d) rotate(-90)\" text-anchor=\"middle\">misses</text>\n",
		(TOP + HEIGHT - BOTTOM) / 2);
}

static void write_curve(const struct cache_curves *curves, const struct frame *frame, int policy, FILE *file)
{
	fprintf(file, "<polyline fill=\"none\" stroke=\"%s\" stroke-width=\"%.1f\" points=\"", colours[policy],
		widths[policy]);
	for (size_t i = first_drawn(curves, policy); i < curves->count; i++)
		fprintf(file, "%.1f,%.1f ", x_of(frame, curves->slots[i]),
			y_of(frame, (double)curves->misses[policy][i]));
	fputs("\"/>\n", file);
	for (size_t i = first_drawn(curves, policy); i < curves->count; i++)
		fprintf(file, "<circle r=\"%.1f\" fill=\"%s\" cx=\"%.1f\" cy=\"%.1f\"/>\n", widths[policy] / 2 + 1, colours[policy],
			x_of(frame, curves->slots[i]), y_of(frame, (double)curves->misses[policy][i]));
}

void cache_plot_write(const struct cache_curves *curves, FILE *file)
{
	struct frame frame = frame_of(curves);
	int row = 0, x = WIDTH - RIGHT + 16;
	write_head(curves, file);
	write_axes(&frame, file);
	double floor_y = y_of(&frame, curves->accesses->tile_count);
	fprintf(file,
		"<line class=\"floor\" stroke-dasharray=\"5 4\" x1=\"%d\" x2=\"%d\" y1=\"%.1f\" y2=\"%.1f\"/>\n", LEFT,
		WIDTH - RIGHT, floor_y, floor_y);
	for (int policy = SIM_POLICIES; policy-- > 0;)
		if (curves->wanted[policy])
			write_curve(curves, &frame, policy, file);
	for (int policy = 0; policy < SIM_POLICIES; policy++) {
		if (!curves->wanted[policy])
			continue;
		char from[24];
		snprintf(from, sizeof from, " (from %d)", SIM_S3FIFO_SLOTS_MIN);
		int y = TOP + 12 + 22 * row++;
		fprintf(file,
			"<line stroke=\"%s\" stroke-width=\"%.1f\" x1=\"%d\" x2=\"%d\" y1=\"%d\" y2=\"%d\"/>\n"
			"<text x=\"%d\" y=\"%d\">%s%s</text>\n",
			colours[policy], widths[policy], x, x + 24, y, y, x + 32, y + 4, cache_policy_labels[policy],
			first_drawn(curves, policy) > 0 ? from : "");
	}
	int y = TOP + 12 + 22 * row;
	fprintf(file,
		"<line class=\"floor\" stroke-dasharray=\"5 4\" x1=\"%d\" x2=\"%d\" y1=\"%d\" y2=\"%d\"/>\n"
		"<text x=\"%d\" y=\"%d\">first access</text>\n</svg>\n",
		x, x + 24, y, y, x + 32, y + 4);
}
