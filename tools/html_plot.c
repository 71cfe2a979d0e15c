/*
 * A plot has 520 x 320 units and no size of its own: the page stretches it. Of a line with more points than pixels it draws the least
 * and the largest value of each pixel across, so a page stays small whatever the drive's length.
 */
#include "html_plot.h"

#include <math.h>

#include "svg.h"

enum { WIDTH = 520, HEIGHT = 320, LEFT = 64, RIGHT = 12, TOP = 30, BOTTOM = 46, ACROSS = WIDTH - LEFT - RIGHT, DOWN = HEIGHT - TOP - BOTTOM };
enum { MAP_DOWN = 430 }; /* a map has more room */
enum { WAY_POINTS = 3000 };
#define NUMBER_MOST 1e30
#define NUMBER_LEAST 1e-30 /* of a logarithmic axis; a linear axis takes less for 0 */
#define NARROW 1e-6        /* of the numbers: a range that is narrower is widened */

/* Paper and light screens; dark screens. Colours of curves: Okabe's and Ito's, lighter on dark ground. */
const char html_style[] =
	":root{--ground:#fff;--text:#1c1c1c;--soft:#5a5a5a;--line:#ddd;--zero:#888;--head:#f3f3f1;"
	"--c0:#0072b2;--c1:#c24e00;--c2:#00805d;--c3:#b4548c;--c4:#946300;--c5:#6a3fb5;--c6:#111;--c7:#666}\n"
	"@media screen and (prefers-color-scheme:dark){:root{--ground:#141414;--text:#e4e4e4;--soft:#a6a6a6;--line:#333;--zero:#888;--head:#222;"
	"--c0:#56b4e9;--c1:#f0883e;--c2:#35c79a;--c3:#e39ac4;--c4:#e6b422;--c5:#b39df3;--c6:#f2f2f2;--c7:#aaa}}\n"
	"html{color-scheme:light dark}body{font:15px/1.45 system-ui,sans-serif;margin:0 auto;padding:1rem;max-width:75rem;background:var(--ground);color:var(--text)}\n"
	"h1{font-size:1.5rem;margin:.5rem 0;overflow-wrap:anywhere}h2{font-size:1.15rem;margin:2rem 0 .6rem;border-bottom:1px solid var(--line)}\n"
	".small,small,figcaption{font-size:.85rem;color:var(--soft)}p{margin:.5rem 0;overflow-wrap:anywhere}\n"
	".scroll{overflow-x:auto}table{border-collapse:collapse;font-size:.9rem}th,td{padding:.2rem .7rem;border-bottom:1px solid var(--line);text-align:left;vertical-align:top}\n"
	"td{overflow-wrap:anywhere;min-width:5rem}.place{min-width:11rem}thead th{background:var(--head)}tbody th{font-weight:normal;color:var(--soft);min-width:8rem}.number{font-variant-numeric:tabular-nums}.none{color:var(--soft)}\n"
	".plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,26rem),1fr));gap:1rem}.plots>p{grid-column:1/-1}.wide{grid-template-columns:minmax(0,44rem)}\n"
	"figure{margin:0}img{max-width:100%;height:auto;background:#fff}svg{width:100%;height:auto;display:block}svg text{font:12px system-ui,sans-serif;fill:var(--text)}svg .name{font-weight:600}.thumbs{display:flex;flex-wrap:wrap;gap:.5rem 1rem}.thumbs img{display:block}\n"
	".grid{stroke:var(--line);fill:none}.zero{stroke:var(--zero);fill:none}.mark{stroke:var(--soft);stroke-dasharray:5 4;fill:none}.halo{stroke:var(--ground);stroke-opacity:.75;stroke-width:4;fill:none;stroke-linejoin:round}.edge{stroke:var(--zero);fill:none}.begin{stroke:var(--ground);stroke-width:1.2}.map .grid,.map .zero{stroke:#000;stroke-opacity:.15}.ramp{max-width:22rem}.curve{fill:none;stroke-width:1.6;stroke-linejoin:round}.area{opacity:.16;stroke:none}\n"
	".s0{stroke:var(--c0)}.s1{stroke:var(--c1)}.s2{stroke:var(--c2)}.s3{stroke:var(--c3)}.s4{stroke:var(--c4)}.s5{stroke:var(--c5)}.s6{stroke:var(--c6)}.s7{stroke:var(--c7)}\n"
	".f0{fill:var(--c0)}.f1{fill:var(--c1)}.f2{fill:var(--c2)}.f3{fill:var(--c3)}.f4{fill:var(--c4)}.f5{fill:var(--c5)}.f6{fill:var(--c6)}.f7{fill:var(--c7)}\n"
	".legend{list-style:none;margin:.4rem 0;padding:0;display:flex;flex-wrap:wrap;gap:.1rem 1.2rem;font-size:.9rem}.key{display:inline-block;width:34px;height:10px}\n"
	".map .s7{stroke:#444}.map .f7{fill:#444}summary{cursor:pointer}\n"
	"@media print{body{max-width:none;padding:0;font-size:11px}.scroll{overflow:visible}table{font-size:.8rem}td,.place{min-width:0}th,td{padding:.15rem .4rem}tbody th{min-width:0}section{break-inside:auto}h2{break-after:avoid}svg,figure,tr,.legend{break-inside:avoid}.plots{grid-template-columns:1fr 1fr}.wide{grid-template-columns:minmax(0,26rem)}.legend,h2+p{break-after:avoid}"
	"*{print-color-adjust:exact;-webkit-print-color-adjust:exact}}\n";

static const char *const dashes[HTML_DASHES] = {"", "7 4", "2 3", "10 3 2 3"};

struct axes {
	const struct html_plot *plot;
	double low[2], high[2], step[2]; /* across: log10 of it, if it is logarithmic */
	double left, top, wide, tall;    /* of the area, pixels */
};

static double scale_x(const struct html_plot *plot, double x)
{
	return plot->logarithmic ? log10(x) : x;
}

/* Larger numbers are none that a drive has, and differences of them may overflow. NaN is none either. */
static bool is_number(double value)
{
	return fabs(value) < NUMBER_MOST;
}

static bool is_drawn(const struct html_plot *plot, const struct html_line *line, size_t i)
{
	return is_number(line->x[i]) && is_number(line->y[i]) && (!plot->logarithmic || line->x[i] > NUMBER_LEAST);
}

static bool has_upright(const struct html_plot *plot)
{
	return is_number(plot->upright) && (!plot->logarithmic || plot->upright > NUMBER_LEAST);
}

bool html_line_any(const struct html_line *line)
{
	for (size_t i = 0; i < line->count; i++)
		if (is_number(line->x[i]) && is_number(line->y[i]))
			return true;
	return false;
}

static void widen(double value, double *low, double *high)
{
	*low = fmin(*low, value);
	*high = fmax(*high, value);
}

/* Widens a range that is too narrow for the digits of its numbers. */
static void part(double *low, double *high)
{
	const double size = fmax(fabs(*low), fabs(*high));
	if (size < NUMBER_LEAST) {
		*low = *high = 0;
	} else if (*high - *low < NARROW * size) {
		*low -= NARROW * size;
		*high += NARROW * size;
	}
}

static double held(double value, double low, double high)
{
	return fmin(fmax(value, low), high);
}

/* One scale for both axes: the shorter side of the area shrinks. */
static void one_scale(struct axes *axes)
{
	const double wide = axes->high[0] - axes->low[0], tall = axes->high[1] - axes->low[1];
	const double scale = fmin(axes->wide / wide, axes->tall / tall);
	axes->left += (axes->wide - scale * wide) / 2;
	axes->wide = scale * wide;
	axes->tall = scale * tall;
}

static void find_axes(struct axes *axes)
{
	const struct html_plot *plot = axes->plot;
	double *low = axes->low, *high = axes->high;
	low[0] = low[1] = INFINITY;
	high[0] = high[1] = -INFINITY;
	for (size_t k = 0; k < plot->count; k++)
		for (size_t i = 0; i < plot->lines[k].count; i++)
			if (is_drawn(plot, &plot->lines[k], i)) {
				widen(scale_x(plot, plot->lines[k].x[i]), &low[0], &high[0]);
				widen(plot->lines[k].y[i], &low[1], &high[1]);
			}
	if (has_upright(plot))
		widen(scale_x(plot, plot->upright), &low[0], &high[0]);
	if (plot->low < plot->high) {
		low[1] = held(low[1], plot->low, plot->high);
		high[1] = held(high[1], plot->low, plot->high);
	}
	if (plot->zero)
		widen(0, &low[1], &high[1]);
	if (plot->map) { /* a square at least a metre wide, so that a straight way has an area */
		const double side = fmax(fmax(high[0] - low[0], high[1] - low[1]) * 0.25, 1);
		for (int k = 0; k < 2; k++) {
			const double more = fmax(side - (high[k] - low[k]), 0) / 2;
			low[k] -= more;
			high[k] += more;
		}
	}
	for (int k = plot->logarithmic ? 1 : 0; k < 2; k++)
		part(&low[k], &high[k]);
	if (plot->ground != NULL) {
		for (int k = 0; k < 2; k++) {
			low[k] = plot->ground->low[k];
			high[k] = plot->ground->high[k];
			axes->step[k] = svg_step((high[k] - low[k]) / 7);
		}
		one_scale(axes);
		return;
	}
	svg_axis(&low[1], &high[1], &axes->step[1]);
	if (!plot->logarithmic)
		svg_axis(&low[0], &high[0], &axes->step[0]);
	else if (high[0] - low[0] < 0.1)
		widen(low[0] + 0.1, &low[0], &high[0]);
	if (plot->map)
		one_scale(axes);
}

static double place_x(const struct axes *axes, double x)
{
	return axes->left + axes->wide * (scale_x(axes->plot, x) - axes->low[0]) / (axes->high[0] - axes->low[0]);
}

static double place_y(const struct axes *axes, double y)
{
	return axes->top + axes->tall * (axes->high[1] - held(y, axes->low[1], axes->high[1])) / (axes->high[1] - axes->low[1]);
}

/* --- axes --- */

static void tick(const struct axes *axes, int axis, double place, double value, FILE *file)
{
	const double bottom = axes->top + axes->tall;
	fprintf(file, "<path class=\"%s\" d=\"M%.1f %.1f%c%.1f\"/>", value == 0 ? "zero" : "grid", axis == 0 ? place : axes->left,
		axis == 0 ? axes->top : place, axis == 0 ? 'v' : 'h', axis == 0 ? axes->tall : axes->wide);
	if (axis == 0)
		fprintf(file, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%g</text>\n", place, bottom + 16, value);
	else
		fprintf(file, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%g</text>\n", axes->left - 6, place + 4, value);
}

static void logarithmic_ticks(const struct axes *axes, FILE *file)
{
	const double wide = axes->high[0] - axes->low[0], every = fmax(ceil(wide / 8), 1);
	for (double power = floor(axes->low[0]); power <= axes->high[0]; power += every)
		for (int i = 1; i < 10; i++) {
			const double at = power + log10(i);
			if (at < axes->low[0] - 1e-9 || at > axes->high[0] + 1e-9 || (i > 1 && wide > 3) || (i != 1 && i != 2 && i != 5 && wide > 0.8))
				continue;
			tick(axes, 0, axes->left + axes->wide * (at - axes->low[0]) / wide, i * pow(10, power), file);
		}
}

static void write_axes(const struct axes *axes, FILE *file)
{
	const struct html_plot *plot = axes->plot;
	for (int k = plot->logarithmic ? 1 : 0; k < 2; k++) {
		const double first = ceil(axes->low[k] / axes->step[k] - 1e-6) * axes->step[k];
		const int steps = (int)floor((axes->high[k] - first) / axes->step[k] + 1e-6);
		const double room = k == 0 ? axes->wide / (30.0 * steps) : axes->tall / (14.0 * steps);
		const int every = room < 0.5 ? 4 : room < 1 ? 2 : 1; /* numbers stay apart */
		for (int i = 0; i <= steps; i += every) {
			const double value = first + i * axes->step[k], shown = fabs(value) < axes->step[k] * 1e-6 ? 0 : value;
			tick(axes, k, k == 0 ? place_x(axes, value) : place_y(axes, value), shown, file);
		}
	}
	if (plot->logarithmic)
		logarithmic_ticks(axes, file);
	fprintf(file, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", axes->left + axes->wide / 2, axes->top + axes->tall + 34);
	svg_text(plot->across, file);
	fprintf(file, "</text><text class=\"name\" x=\"%.1f\" y=\"%d\">", fmin(axes->left, LEFT) - 6, TOP - 12);
	svg_text(plot->up, file);
	fputs("</text>\n", file);
}

/* --- lines --- */

static void point(const struct axes *axes, double x, double y, bool *down, FILE *file)
{
	fprintf(file, "%c%.1f %.1f", *down ? 'L' : 'M', place_x(axes, x), place_y(axes, y));
	*down = true;
}

/* Points of one pixel across: the least and the largest, in their order. `from` to `to`: indices; to is not in. */
static void pixel(const struct axes *axes, const struct html_line *line, size_t from, size_t to, bool *down, FILE *file)
{
	size_t least = from, most = from;
	for (size_t i = from; i < to; i++) {
		least = line->y[i] < line->y[least] ? i : least;
		most = line->y[i] > line->y[most] ? i : most;
	}
	const size_t first = least < most ? least : most, second = least < most ? most : least;
	point(axes, line->x[first], line->y[first], down, file);
	if (second != first)
		point(axes, line->x[second], line->y[second], down, file);
}

static void write_over(const struct axes *axes, const struct html_line *line, FILE *file)
{
	bool down = false;
	for (size_t i = 0, to; i < line->count; i = to) {
		to = i + 1;
		if (!is_drawn(axes->plot, line, i)) {
			down = false;
			continue;
		}
		const double column = floor(place_x(axes, line->x[i]));
		while (to < line->count && is_drawn(axes->plot, line, to) && floor(place_x(axes, line->x[to])) == column)
			to++;
		pixel(axes, line, i, to, &down, file);
	}
}

/* Points that are at least `apart` pixels from the last one. Without a file: counts them. */
static size_t write_way(const struct axes *axes, const struct html_line *line, double apart, FILE *file)
{
	size_t count = 0, last = 0;
	bool down = false;
	for (size_t i = 0; i < line->count; i++) {
		if (!is_drawn(axes->plot, line, i)) {
			down = false;
			count++; /* the line begins again */
			continue;
		}
		const double x = place_x(axes, line->x[i]), y = place_y(axes, line->y[i]);
		if (down && i + 1 < line->count && hypot(x - place_x(axes, line->x[last]), y - place_y(axes, line->y[last])) < apart)
			continue;
		if (file != NULL)
			point(axes, line->x[i], line->y[i], &down, file);
		down = true;
		last = i;
		count++;
	}
	return count;
}

static void write_steps(const struct axes *axes, const struct html_line *line, bool closed, FILE *file)
{
	bool down = false;
	if (closed)
		point(axes, line->x[0], 0, &down, file);
	for (size_t i = 0; i + 1 < line->count; i++) {
		point(axes, line->x[i], line->y[i], &down, file);
		point(axes, line->x[i + 1], line->y[i], &down, file);
	}
	if (closed)
		point(axes, line->x[line->count - 1], 0, &down, file);
}

static void write_shape(const struct axes *axes, const struct html_line *line, FILE *file)
{
	if (line->steps) {
		write_steps(axes, line, false, file);
	} else if (axes->plot->map) {
		double apart = 0.7;
		while (write_way(axes, line, apart, NULL) > WAY_POINTS && apart < WIDTH)
			apart *= 1.5;
		write_way(axes, line, apart, file);
	} else {
		write_over(axes, line, file);
	}
}

static void write_line(const struct axes *axes, const struct html_line *line, FILE *file)
{
	const int colour = (int)(line->colour % HTML_COLOURS);
	if (line->steps) {
		fprintf(file, "<path class=\"area f%d\" d=\"", colour);
		write_steps(axes, line, true, file);
		fputs("Z\"/>\n", file);
	}
	if (axes->plot->ground != NULL && !line->dots) { /* so that it is seen on any ground */
		fputs("<path class=\"halo\" d=\"", file);
		write_shape(axes, line, file);
		fputs("\"/>\n", file);
	}
	fprintf(file, "<path class=\"curve s%d\" stroke-dasharray=\"%s\" d=\"", colour, dashes[line->dash % HTML_DASHES]);
	write_shape(axes, line, file);
	fputs("\"/>\n", file);
	for (size_t i = 0; line->begins && i < line->count; i++)
		if (is_drawn(axes->plot, line, i)) {
			fprintf(file, "<circle class=\"f%d begin\" cx=\"%.1f\" cy=\"%.1f\" r=\"4\"/>\n", colour, place_x(axes, line->x[i]), place_y(axes, line->y[i]));
			break;
		}
	for (size_t i = 0; line->dots && i < line->count; i++)
		if (is_drawn(axes->plot, line, i))
			fprintf(file, "<circle class=\"f%d\" cx=\"%.1f\" cy=\"%.1f\" r=\"2.5\"/>", colour, place_x(axes, line->x[i]), place_y(axes, line->y[i]));
}

static void write_upright(const struct axes *axes, FILE *file)
{
	const struct html_plot *plot = axes->plot;
	if (!has_upright(plot))
		return;
	const double x = place_x(axes, plot->upright);
	const bool left = x > axes->left + axes->wide / 2;
	fprintf(file, "<path class=\"mark\" d=\"M%.1f %.1fv%.1f\"/><text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">", x, axes->top, axes->tall,
		x + (left ? -5 : 5), axes->top + 13, left ? "end" : "start");
	svg_text(plot->told, file);
	fputs("</text>\n", file);
}

void html_base64(const unsigned char *bytes, size_t length, FILE *file)
{
	static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
	for (size_t i = 0; i < length; i += 3) {
		const unsigned a = bytes[i], b = i + 1 < length ? bytes[i + 1] : 0, c = i + 2 < length ? bytes[i + 2] : 0;
		fputc(digits[a >> 2], file);
		fputc(digits[(a & 3) << 4 | b >> 4], file);
		fputc(i + 1 < length ? digits[(b & 15) << 2 | c >> 6] : '=', file);
		fputc(i + 2 < length ? digits[c & 63] : '=', file);
	}
}

static void write_ground(const struct axes *axes, FILE *file)
{
	const struct html_ground *ground = axes->plot->ground;
	if (ground == NULL)
		return;
	fprintf(file, "<image x=\"%.2f\" y=\"%.2f\" width=\"%.2f\" height=\"%.2f\" preserveAspectRatio=\"none\" href=\"data:image/png;base64,",
		axes->left, axes->top, axes->wide, axes->tall);
	html_base64(ground->png, ground->length, file);
	fprintf(file, "\"/><path class=\"edge\" d=\"M%.2f %.2fh%.2fv%.2fh%.2fz\"/>\n", axes->left, axes->top, axes->wide, axes->tall, -axes->wide);
}

void html_plot_write(const struct html_plot *plot, FILE *file)
{
	struct axes axes = {.plot = plot, .left = LEFT, .top = TOP, .wide = ACROSS, .tall = plot->map ? MAP_DOWN : DOWN};
	find_axes(&axes);
	fprintf(file, "<svg role=\"img\"%s viewBox=\"0 0 %d %.0f\"><title>", plot->ground != NULL ? " class=\"map\"" : "", WIDTH, TOP + axes.tall + BOTTOM);
	svg_text(plot->title, file);
	fputs("</title>\n", file);
	write_ground(&axes, file);
	write_axes(&axes, file);
	for (size_t i = plot->count; i-- > 0;) /* the first lies on top */
		write_line(&axes, &plot->lines[i], file);
	write_upright(&axes, file);
	fputs("</svg>\n", file);
}
