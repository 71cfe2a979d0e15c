/* What furrow view draws over its picture, on the CPU: the line of figures, the legend of a layer, the keys. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "view.h"

#define MARGIN 8    /* pixels, times the scale */
#define LINE 15     /* pixels: a line's height, times the scale */
#define LARGE 1400u /* a picture wider than this has its letters twice as large */

static const struct chart_colour white = {255, 255, 255, 255}, black = {0, 0, 0, 200}, shadow = {0, 0, 0, 150};

/* "car 1.20 m/s  slip 0.05  sinkage 12 mm" */
static void vehicle_text(const struct drive_followed *followed, char text[128])
{
	char slip[32] = "";
	if (isfinite(followed->slip))
		snprintf(slip, sizeof slip, "  slip %.2f", followed->slip);
	snprintf(text, 128, "  %.40s %.2f m/s%s  sinkage %.1f mm", followed->name, followed->speed, slip, 1e3 * followed->sinkage);
}

void view_figures_text(const struct viewer *viewer, const struct drive_figures *figures, const struct drive_followed *followed, char *text, size_t size)
{
	char pace[24], vehicle[128] = "", rate[32] = "";
	if (followed != NULL && followed->vehicle)
		vehicle_text(followed, vehicle);
	if (isfinite(viewer->rate) && !viewer->paused && !figures->over)
		snprintf(rate, sizeof rate, " (%.2f real)", viewer->rate);
	if (viewer->pace == VIEW_PACE_MOST)
		snprintf(pace, sizeof pace, "free");
	else
		snprintf(pace, sizeof pace, "x%g", ldexp(1, viewer->pace));
	snprintf(text, size,
		 "%.0f fps  %.1f ms  step %lld/%lld  %.2f s  %s%s%s  %.2f ms/step  slots %u/%u  hits %llu  misses %llu  dirty %zu  "
		 "queue %zu  %llu tri  eye %.1f %.1f %.1f",
		 figures->fps, figures->frame_ms, (long long)figures->step, (long long)figures->steps, figures->time,
		 figures->over    ? "over"
		 : viewer->paused ? "paused"
				  : pace,
		 rate, vehicle,
		 figures->step_ms, figures->slots_used, figures->slots, (unsigned long long)figures->hits,
		 (unsigned long long)figures->misses, figures->dirty, figures->queued, (unsigned long long)figures->triangles,
		 viewer->eye.eye[0], viewer->eye.eye[1], viewer->eye.eye[2]);
}

/* What is drawn on, and with. */
struct over {
	struct chart_pen *pen;
	struct chart_pixels pixels;
	int scale;
};

/* On a dark band, so that it can be read over snow. (x, y): the lower left corner of the letters. */
static enum status write_line(const struct over *over, int x, int y, const char *text)
{
	const int pad = 2 * over->scale, high = LINE * over->scale;
	chart_box(&over->pixels, x - 2 * pad, y - pad, x + chart_pen_width(over->pen, high, text) + 2 * pad, y + high + pad,
		  shadow);
	return chart_pen_write(over->pen, &over->pixels, x, y, high, text, white);
}

/* Ends `line` where figures part, or at its end, so that it is not longer than `most` pixels if that can be. Returns its length. */
static size_t fit(const struct over *over, char *line, int most)
{
	size_t end = strlen(line);
	while (chart_pen_width(over->pen, LINE * over->scale, line) > most) {
		size_t shorter = end;
		while (shorter > 0 && !(line[shorter - 1] == ' ' && line[shorter] == ' '))
			shorter--;
		if (shorter < 2)
			break;
		end = shorter - 1;
		line[end] = '\0';
	}
	return end;
}

/* In as many lines as the picture's width asks for, parted where figures are. *low: where the last one is. */
static enum status draw_figures(const struct over *over, const char *text, int *low)
{
	char line[512];
	const int scale = over->scale, most = (int)over->pixels.width - 2 * MARGIN * scale;
	while (*text != '\0') {
		snprintf(line, sizeof line, "%s", text);
		text += fit(over, line, most);
		*low -= scale * (LINE + 6);
		TRY(write_line(over, MARGIN * scale, *low - 2 * scale, line));
		while (*text == ' ')
			text++;
	}
	return STATUS_OK;
}

/* Parts a line of the help at its first two spaces: the key, and *what it does. */
static void part_help(const char *line, char key[32], const char **what)
{
	const char *end = strstr(line, "  ");
	snprintf(key, 32, "%.*s", end != NULL ? (int)(end - line) : 0, line);
	*what = end != NULL ? end : line;
	while (**what == ' ')
		++*what;
}

/* Two columns on one dark band. */
static enum status draw_help(const struct over *over, int top)
{
	const int scale = over->scale, line = LINE * scale, apart = line + 4 * scale, x = MARGIN * scale;
	int keys = 0, texts = 0, lines = 0;
	const char *what;
	char key[32];
	for (; view_help((size_t)lines) != NULL; lines++) {
		part_help(view_help((size_t)lines), key, &what);
		keys = (int)fmax(keys, chart_pen_width(over->pen, line, key));
		texts = (int)fmax(texts, chart_pen_width(over->pen, line, what));
	}
	const int second = x + keys + 14 * scale;
	int y = top - line;
	chart_box(&over->pixels, x - 4 * scale, y - lines * apart - 4 * scale, second + texts + 6 * scale, y, shadow);
	for (int i = 0; i < lines; i++) {
		part_help(view_help((size_t)i), key, &what);
		y -= apart;
		TRY(chart_pen_write(over->pen, &over->pixels, x, y, line, key, white));
		TRY(chart_pen_write(over->pen, &over->pixels, second, y, line, what, white));
	}
	return STATUS_OK;
}

/* A bar of the layer's colours, with what its ends and its middle are below it. */
static enum status draw_legend(const struct over *over, const struct render_layer *layer)
{
	static const char *const units[RENDER_LAYERS] = {
		[RENDER_OFFSETS] = "m", [RENDER_DISTURBANCE] = "", [RENDER_HEIGHTS] = "m", [RENDER_SLOPES] = "degrees"};
	const int scale = over->scale, width = 240 * scale, height = 10 * scale, line = LINE * scale;
	const int x = (MARGIN + 12) * scale, y = MARGIN * scale + line + 4 * scale;
	char text[64];
	if (units[layer->kind] == NULL || (int)over->pixels.width < width + 2 * x)
		return STATUS_OK;
	chart_box(&over->pixels, x - 12 * scale, y - line - 6 * scale, x + width + 12 * scale, y + height + 4 * scale, shadow);
	chart_box(&over->pixels, x - 1, y - 1, x + width + 1, y + height + 1, black);
	for (int i = 0; i < width; i++)
		chart_box(&over->pixels, x + i, y, x + i + 1, y + height, render_layer_colour(layer->kind, (i + 0.5) / width));
	for (int i = 0; i < 3; i++) {
		snprintf(text, sizeof text, i == 2 ? "%.4g %s" : "%.4g", layer->low + (layer->high - layer->low) * i / 2,
			 units[layer->kind]);
		const int wide = chart_pen_width(over->pen, line, text), at = x + width * i / 2 -
									      (i == 0   ? 0
									       : i == 1 ? wide / 2
											: wide);
		TRY(chart_pen_write(over->pen, &over->pixels, at, y - line - 2 * scale, line, text, white));
	}
	return STATUS_OK;
}

enum status view_draw_over(const struct viewer *viewer, const struct drive_figures *figures, const struct drive_followed *followed, uint8_t *pixels,
			   uint32_t width, uint32_t height, int *top)
{
	const struct over over = {viewer->pen, {pixels, width, height}, width > LARGE ? 2 : 1};
	char text[500];
	*top = (int)height;
	if (viewer->pen == NULL)
		return STATUS_OK;
	if (viewer->line) {
		view_figures_text(viewer, figures, followed, text, sizeof text - 96);
		if (viewer->told[0] != '\0')
			snprintf(text + strlen(text), sizeof text - strlen(text), "  %s", viewer->told);
		TRY(draw_figures(&over, text, top));
	}
	if (viewer->layer != RENDER_NATURAL && viewer->line)
		TRY(draw_legend(&over, &figures->layer));
	return viewer->help ? draw_help(&over, *top) : STATUS_OK;
}
