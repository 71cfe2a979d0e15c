/*
 * A plot of a study: one parameter across, a result up, a colour for each value of a second
 * parameter.
 *
 * A pale dot is a run. The line joins the means of the runs with the same value across. A bar goes
 * from the lowest to the highest of them: what all other parameters make of it. A parameter with
 * many values is cut into parts of equal width, as a hypercube's are. Colours: Okabe's and Ito's,
 * which every eye tells apart.
 */
#include <math.h>
#include <string.h>

#include "scene/scene_error.h"
#include "study_groups.h"
#include "svg.h"

enum { WIDTH = 860, HEIGHT = 470, LEFT = 80, TOP = 46, ACROSS = 540, DOWN = 350, LEGEND = 646, LABEL = 26 };
#define SERIES_MOST 8 /* the same for the colours */
#define PARTS 8	      /* that an axis is cut into */
#define SERIES_PARTS 3
#define BESIDE 3.0 /* pixels between the bars of two series */

static const char *const colours[SERIES_MOST] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
						 "#e69f00", "#56b4e9", "#7a5c00", "#808080"};

struct dot {
	double x, y;
	size_t across, series;
};

struct plot {
	const struct study *study;
	const struct study_plot *plot;
	struct study_groups across, series;
	struct dot *dots;
	size_t count;
	double low[2], high[2], step[2]; /* of the axes; across: on its scale */
};

static void take_dots(struct plot *plot, const struct study_cell *cells)
{
	const struct study *study = plot->study;
	plot->low[1] = INFINITY;
	plot->high[1] = -INFINITY;
	for (size_t run = 0; run < study->run_count; run++) {
		struct dot dot = {.y = cells[run * study->result_count + plot->plot->y].number};
		double value;
		if (!isfinite(dot.y))
			continue;
		dot.across = study_groups_index(&plot->across, study_value(study, run, plot->plot->x), &dot.x);
		dot.x = study_groups_scale(&plot->across, dot.x);
		if (plot->plot->by != SIZE_MAX)
			dot.series = study_groups_index(&plot->series, study_value(study, run, plot->plot->by), &value);
		if (plot->across.text && plot->series.count > 1) /* beside each other */
			dot.x += ((double)dot.series / (double)(plot->series.count - 1) - 0.5) * 0.5;
		plot->low[1] = fmin(plot->low[1], dot.y);
		plot->high[1] = fmax(plot->high[1], dot.y);
		plot->dots[plot->count++] = dot;
	}
}

static void make_axes(struct plot *plot)
{
	const struct study_groups *across = &plot->across;
	svg_axis(&plot->low[1], &plot->high[1], &plot->step[1]);
	if (across->text) {
		plot->low[0] = -0.5;
		plot->high[0] = (double)across->count - 0.5;
		return;
	}
	plot->low[0] = study_groups_scale(across, across->low);
	plot->high[0] = study_groups_scale(across, across->high);
	if (!across->logarithmic)
		svg_axis(&plot->low[0], &plot->high[0], &plot->step[0]);
	const double edge = across->logarithmic ? fmax((plot->high[0] - plot->low[0]) * 0.04, 0.02) : 0;
	plot->low[0] -= edge;
	plot->high[0] += edge;
}

static double place_x(const struct plot *plot, double value)
{
	return LEFT + ACROSS * (value - plot->low[0]) / (plot->high[0] - plot->low[0]);
}

static double place_y(const struct plot *plot, double value)
{
	return TOP + DOWN * (plot->high[1] - value) / (plot->high[1] - plot->low[1]);
}

/* --- what is drawn --- */

static void write_short(const char *text, FILE *file)
{
	char label[LABEL + 1];
	snprintf(label, sizeof label, "%s", text);
	size_t length = strlen(label);
	if (strlen(text) > length) /* a cut within a character takes all of it */
		while (length > 0 && ((unsigned char)text[length] & 0xc0) == 0x80)
			label[--length] = '\0';
	svg_text(label, file);
	if (strlen(text) > length)
		fputs("…", file);
}

static void line_across(const struct plot *plot, double value, const char *label, FILE *file)
{
	const double x = place_x(plot, value);
	fprintf(file,
		"<path class=\"line\" d=\"M%.1f %dv%d\"/><text x=\"%.1f\" y=\"%d\" "
		"text-anchor=\"middle\">",
		x, TOP, DOWN, x, TOP + DOWN + 18);
	write_short(label, file);
	fputs("</text>\n", file);
}

static void write_across(const struct plot *plot, FILE *file)
{
	char label[40];
	if (plot->across.text) {
		for (size_t i = 0; i < plot->across.count; i++)
			line_across(plot, (double)i, plot->across.names[i], file);
	} else if (plot->across.logarithmic) {
		const double wide = plot->high[0] - plot->low[0];
		for (int power = (int)floor(plot->low[0]); power <= (int)ceil(plot->high[0]); power++)
			for (int i = 0; i < 9; i++) {
				const double value = (i + 1) * pow(10, power), at = log10(value);
				if (at < plot->low[0] || at > plot->high[0] || (i > 0 && wide > 3) ||
				    (i != 0 && i != 1 && i != 4 && wide > 0.7))
					continue;
				snprintf(label, sizeof label, "%g", value);
				line_across(plot, at, label, file);
			}
	} else {
		const int steps = (int)lround((plot->high[0] - plot->low[0]) / plot->step[0]);
		for (int i = 0; i <= steps; i++) {
			const double value = plot->low[0] + i * plot->step[0];
			snprintf(label, sizeof label, "%g", fabs(value) < plot->step[0] * 1e-6 ? 0 : value);
			line_across(plot, value, label, file);
		}
	}
	fprintf(file, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">", LEFT + ACROSS / 2, TOP + DOWN + 40);
	svg_text(plot->study->parameters[plot->plot->x].name, file);
	fputs("</text>\n", file);
}

static void write_up(const struct plot *plot, FILE *file)
{
	const int steps = (int)lround((plot->high[1] - plot->low[1]) / plot->step[1]);
	for (int i = 0; i <= steps; i++) {
		const double value = plot->low[1] + i * plot->step[1], shown = fabs(value) < plot->step[1] * 1e-6 ? 0 : value;
		fprintf(file,
			"<path class=\"%s\" d=\"M%d %.1fh%d\"/><text x=\"%d\" y=\"%.1f\" "
			"text-anchor=\"end\">%g</text>\n",
			shown == 0 ? "zero" : "line", LEFT, place_y(plot, value), ACROSS, LEFT - 7, place_y(plot, value) + 4,
			shown);
	}
	fprintf(file, "<text class=\"name\" x=\"%d\" y=\"%d\">", LEFT, TOP - 14);
	svg_text(plot->study->results[plot->plot->y].name, file);
	fputs("</text>\n", file);
}

/* Means and bars of a series: the line is in `line`, in the order of the axis. */
static void write_series(const struct plot *plot, size_t series, FILE *file)
{
	const char *colour = colours[series % SERIES_MOST];
	const double beside = plot->across.text ? 0 : ((double)series - (double)(plot->series.count - 1) / 2) * BESIDE;
	double before = -INFINITY;
	bool down = false;
	fprintf(file, "<g stroke=\"%s\" fill=\"%s\">\n", colour, colour);
	for (size_t i = 0; i < plot->count; i++)
		if (plot->dots[i].series == series)
			fprintf(file, "<circle class=\"run\" cx=\"%.1f\" cy=\"%.1f\" r=\"3\"/>\n",
				place_x(plot, plot->dots[i].x) + beside, place_y(plot, plot->dots[i].y));
	double x_before = 0, y_before = 0;
	for (;;) {
		double next = INFINITY, x = 0, sum = 0, low = INFINITY, high = -INFINITY, count = 0;
		for (size_t i = 0; i < plot->count; i++) /* the next group to the right */
			if (plot->dots[i].series == series && plot->across.values[plot->dots[i].across] > before)
				next = fmin(next, plot->across.values[plot->dots[i].across]);
		if (!isfinite(next))
			break;
		for (size_t i = 0; i < plot->count; i++) {
			const struct dot *dot = &plot->dots[i];
			if (dot->series != series || plot->across.values[dot->across] != next)
				continue;
			x += dot->x;
			sum += dot->y;
			low = fmin(low, dot->y);
			high = fmax(high, dot->y);
			count++;
		}
		before = next;
		x = place_x(plot, x / count) + beside;
		const double y = place_y(plot, sum / count);
		if (high > low)
			fprintf(file,
				"<path class=\"bar\" d=\"M%.1f %.1fV%.1fM%.1f %.1fh8M%.1f "
				"%.1fh8\"/>\n",
				x, place_y(plot, low), place_y(plot, high), x - 4, place_y(plot, low), x - 4, place_y(plot, high));
		if (down && !plot->across.text)
			fprintf(file, "<path class=\"mean\" d=\"M%.1f %.1fL%.1f %.1f\"/>\n", x_before, y_before, x, y);
		fprintf(file, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\"/>\n", x, y);
		down = true;
		x_before = x;
		y_before = y;
	}
	fputs("</g>\n", file);
}

static void write_legend(const struct plot *plot, FILE *file)
{
	if (plot->plot->by == SIZE_MAX)
		return;
	int y = TOP + 12;
	fprintf(file, "<text class=\"name\" x=\"%d\" y=\"%d\">", LEGEND, y);
	write_short(plot->study->parameters[plot->plot->by].name, file);
	fputs("</text>\n", file);
	for (size_t i = 0; i < plot->series.count; i++) {
		char label[60];
		y += 20;
		if (plot->series.cut)
			snprintf(label, sizeof label, "%.3g to %.3g", study_groups_edge(&plot->series, i),
				 study_groups_edge(&plot->series, i + 1));
		else
			snprintf(label, sizeof label, "%g", plot->series.values[i]);
		fprintf(file, "<circle cx=\"%d\" cy=\"%d\" r=\"4\" fill=\"%s\"/><text x=\"%d\" y=\"%d\">", LEGEND + 5, y - 4,
			colours[i % SERIES_MOST], LEGEND + 16, y);
		write_short(plot->series.text ? plot->series.names[i] : label, file);
		fputs("</text>\n", file);
	}
}

static void write_all(const struct plot *plot, FILE *file)
{
	fprintf(file,
		"<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" viewBox=\"0 "
		"0 %d %d\">\n<style>\n"
		"text { font: 13px sans-serif; fill: #222 } .name { font-weight: bold }\n"
		".back { fill: #fff } .line { stroke: #ddd } .zero { stroke: #888 }\n"
		".run { opacity: 0.35; stroke: none } .bar { stroke-width: 1.5; fill: none; "
		"opacity: 0.7 } .mean { stroke-width: 2; fill: none }\n"
		"@media (prefers-color-scheme: dark) {\n  text { fill: #ddd } .back { fill: #111 } "
		".line { stroke: #333 }\n}\n"
		"</style>\n<rect class=\"back\" width=\"100%%\" height=\"100%%\"/>\n",
		WIDTH, HEIGHT, WIDTH, HEIGHT);
	write_across(plot, file);
	write_up(plot, file);
	for (size_t i = 0; i < plot->series.count; i++)
		write_series(plot, i, file);
	write_legend(plot, file);
	fprintf(file,
		"<text x=\"%d\" y=\"%d\">dots: runs; line: means; bars: lowest to "
		"highest</text>\n</svg>\n",
		LEFT, HEIGHT - 12);
}

/* Finds the groups of both parameters. */
static enum status group(const struct study *study, const struct study_plot *wanted, const struct scene_node *node, struct plot *plot)
{
	const size_t parts = study->run_count < 8 ? 1 : study->run_count < 4 * PARTS ? study->run_count / 4 : PARTS;
	*plot = (struct plot){.study = study, .plot = wanted, .series = {.count = 1}};
	if (!study_groups_find(study, wanted->x, STUDY_GROUPS, parts, &plot->across))
		return scene_error(study->file, node, "has %s across, which has more than %d values that are no numbers; allowed: another parameter as x",
				   study->parameters[wanted->x].name, STUDY_GROUPS);
	if (wanted->by != SIZE_MAX && !study_groups_find(study, wanted->by, SERIES_MOST, SERIES_PARTS, &plot->series))
		return scene_error(study->file, node, "is by %s, which has more than %d values that are no numbers; allowed: another parameter as by, or none",
				   study->parameters[wanted->by].name, SERIES_MOST);
	return STATUS_OK;
}

enum status study_plot_check(const struct study *study, const struct study_plot *wanted, const struct scene_node *node)
{
	struct plot plot;
	return group(study, wanted, node, &plot);
}

enum status study_plot_write(const struct study *study, const struct study_plot *wanted, const struct study_cell *cells, FILE *file)
{
	struct plot plot;
	TRY(group(study, wanted, study->root, &plot));
	TRY(mem_zeroed(&plot.dots, study->run_count, sizeof *plot.dots, "a plot of the study"));
	take_dots(&plot, cells);
	make_axes(&plot);
	write_all(&plot, file);
	mem_free(plot.dots);
	return STATUS_OK;
}
