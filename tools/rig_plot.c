/*
 * Four plots over slip: sinkage, drawbar pull, torque, efficiency. A colour and a mark a soil, a dash a load, a black dot a measured trial.
 * Of an object without a slip the plots are over its load. Colours: Okabe's and Ito's, which every eye tells apart. No two of 42
 * soils have both the same colour and the same mark.
 */
#include "rig_plot.h"

#include <math.h>
#include <string.h>

#include "svg.h"

enum { WIDTH = 1190, LEFT = 70, TOP = 60, ACROSS = 390, DOWN = 270, GAP_X = 80, GAP_Y = 80, LEGEND = 960, LABEL = 22 };

static const char *const colours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};
static const char *const dashes[] = {"none", "7 4", "2 3", "10 3 2 3"};
/* Marks: a point of SVG's path each, about 6 wide, and its count differs from that of colours. */
static const char *const marks[] = {"m-3 0a3 3 0 1 0 6 0a3 3 0 1 0 -6 0z", "m-2.8 -2.8h5.6v5.6h-5.6z",       "m0 -3.8l3.6 6.3h-7.2z", "m0 -4l4 4l-4 4l-4 -4z",
				    "m0 3.8l3.6 -6.3h-7.2z",               "m-2.4 -3.6l6.3 3.6l-6.3 3.6z", "m2.4 -3.6l-6.3 3.6l6.3 3.6z"};
static const char *const titles[RIG_FIGURES] = {"sinkage, mm", "drawbar pull, N", "torque, N m", "efficiency"};
#define COUNT(list) (sizeof list / sizeof *list)

/* One plot: where it is, and what its axes show. */
struct panel {
	int figure;
	double x, y;                   /* of its upper left corner */
	double low[2], high[2], step[2];
};

static bool has_slip(const struct rig_table *table)
{
	return table->found.wheel || table->found.belt;
}

static const char *title_of(const struct rig_table *table, int figure)
{
	return figure == 2 && table->found.belt ? "pull of the belt, N" : titles[figure];
}

static double across(const struct rig_table *table, const struct rig_row *row)
{
	return has_slip(table) ? row->slip : table->params->loads[row->load];
}

static void widen(double value, double *low, double *high)
{
	if (!isfinite(value))
		return;
	*low = fmin(*low, value);
	*high = fmax(*high, value);
}

static bool axes(const struct rig_table *table, struct panel *panel)
{
	double *low = panel->low, *high = panel->high;
	low[0] = low[1] = INFINITY;
	high[0] = high[1] = -INFINITY;
	for (size_t i = 0; i < table->count; i++) {
		const double value = rig_figure(&table->rows[i], panel->figure);
		widen(value, &low[1], &high[1]);
		widen(across(table, &table->rows[i]), &low[0], &high[0]);
	}
	const bool any = high[1] >= low[1];
	for (size_t i = 0; i < table->measured_count && has_slip(table); i++) {
		const double slip = table->measured[i].slip;
		if (slip < low[0] || slip > high[0])
			continue;
		widen(rig_measured_figure(&table->measured[i], panel->figure), &low[1], &high[1]);
	}
	low[1] = fmin(low[1], 0);
	for (int k = 0; k < 2; k++)
		svg_axis(&low[k], &high[k], &panel->step[k]);
	return any;
}

static double place_x(const struct panel *panel, double value)
{
	return panel->x + ACROSS * (value - panel->low[0]) / (panel->high[0] - panel->low[0]);
}

static double place_y(const struct panel *panel, double value)
{
	return panel->y + DOWN * (panel->high[1] - value) / (panel->high[1] - panel->low[1]);
}

static void write_axes(const struct rig_table *table, const struct panel *panel, FILE *file)
{
	for (int k = 0; k < 2; k++) {
		const int steps = (int)lround((panel->high[k] - panel->low[k]) / panel->step[k]);
		for (int i = 0; i <= steps; i++) {
			const double value = panel->low[k] + i * panel->step[k], shown = fabs(value) < panel->step[k] * 1e-6 ? 0 : value;
			const double x = k == 0 ? place_x(panel, value) : panel->x, y = k == 0 ? panel->y : place_y(panel, value);
			fprintf(file, "<path class=\"%s\" d=\"M%.1f %.1f%s%d\"/>", shown == 0 ? "zero" : "line", x, y, k == 0 ? "v" : "h", k == 0 ? DOWN : ACROSS);
			if (k == 0)
				fprintf(file, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%g</text>\n", x, panel->y + DOWN + 18, shown);
			else
				fprintf(file, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%g</text>\n", x - 7, y + 4, shown);
		}
	}
	fprintf(file, "<text class=\"name\" x=\"%.1f\" y=\"%.1f\">%s</text><text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%s</text>\n", panel->x,
		panel->y - 9, title_of(table, panel->figure), panel->x + ACROSS / 2.0, panel->y + DOWN + 36, has_slip(table) ? "slip" : "load, N");
}

static void write_mark(double x, double y, size_t soil, bool filled, FILE *file)
{
	const char *colour = colours[soil % COUNT(colours)];
	fprintf(file, "<path class=\"mark\" stroke=\"%s\" fill=\"%s\" d=\"M%.1f %.1f%s\"/>\n", colour, filled ? colour : "none", x, y, marks[soil % COUNT(marks)]);
}

static void write_curve(const struct rig_table *table, const struct panel *panel, size_t soil, size_t load, FILE *file)
{
	const char *colour = colours[soil % COUNT(colours)];
	double before = -INFINITY;
	bool down = false;
	fprintf(file, "<path fill=\"none\" stroke-width=\"2\" stroke=\"%s\" stroke-dasharray=\"%s\" d=\"", colour, dashes[load % COUNT(dashes)]);
	for (size_t n = 0; n < table->count; n++) { /* in order of slip, whatever the order of the rows */
		const struct rig_row *next = NULL;
		for (const struct rig_row *row = table->rows; row < table->rows + table->count; row++)
			if (row->soil == soil && (row->load == load || !has_slip(table)) && across(table, row) > before &&
			    (next == NULL || across(table, row) < across(table, next)))
				next = row;
		if (next == NULL)
			break;
		before = across(table, next);
		const double value = rig_figure(next, panel->figure);
		if (isfinite(value))
			fprintf(file, "%c%.1f %.1f", down ? 'L' : 'M', place_x(panel, before), place_y(panel, value));
		down = isfinite(value);
	}
	fputs("\"/>\n", file);
	for (const struct rig_row *row = table->rows; row < table->rows + table->count; row++)
		if (row->soil == soil && row->load == load && isfinite(rig_figure(row, panel->figure)) && isfinite(across(table, row)))
			write_mark(place_x(panel, across(table, row)), place_y(panel, rig_figure(row, panel->figure)), soil, row->state == RIG_STEADY, file);
}

static void write_panel(const struct rig_table *table, const struct panel *panel, FILE *file)
{
	write_axes(table, panel, file);
	for (size_t soil = 0; soil < table->params->soil_count; soil++)
		for (size_t load = 0; load < table->params->load_count; load++)
			write_curve(table, panel, soil, load, file);
	for (size_t i = 0; i < table->measured_count && has_slip(table); i++) {
		const struct rig_measured *m = &table->measured[i];
		const double value = rig_measured_figure(m, panel->figure);
		if (isfinite(value) && m->slip >= panel->low[0] && m->slip <= panel->high[0])
			fprintf(file, "<circle class=\"measured\" cx=\"%.1f\" cy=\"%.1f\" r=\"3.2\"/>\n", place_x(panel, m->slip), place_y(panel, value));
	}
}

static double legend_line(double y, const char *colour, const char *dash, FILE *file)
{
	fprintf(file, "<path stroke=\"%s\" stroke-width=\"2\" stroke-dasharray=\"%s\" d=\"M%d %.1fh34\"/><text x=\"%d\" y=\"%.1f\">", colour, dash, LEGEND,
		y - 4, LEGEND + 42, y);
	return y + 20;
}

static void write_legend(const struct rig_table *table, FILE *file)
{
	double y = TOP + 12;
	for (size_t i = 0; i < table->params->soil_count; i++) {
		y = legend_line(y, colours[i % COUNT(colours)], "none", file);
		const char *soil = table->soils[i];
		char label[LABEL + 1];
		snprintf(label, sizeof label, "%s", soil);
		svg_text(label, file);
		fputs(strlen(soil) > LABEL ? "…</text>\n" : "</text>\n", file);
		write_mark(LEGEND + 17, y - 24, i, true, file);
	}
	for (size_t i = 0; i < table->params->load_count && has_slip(table); i++) {
		y = legend_line(y, "#888", dashes[i % COUNT(dashes)], file);
		fprintf(file, "%g N</text>\n", table->params->loads[i]);
	}
	if (table->measured_count > 0 && has_slip(table)) {
		fprintf(file, "<circle class=\"measured\" cx=\"%d\" cy=\"%.1f\" r=\"3.2\"/><text x=\"%d\" y=\"%.1f\">measured</text>\n", LEGEND + 17, y - 4,
			LEGEND + 42, y);
		y += 20;
	}
	fprintf(file, "<circle cx=\"%d\" cy=\"%.1f\" r=\"3\" stroke=\"#888\" fill=\"none\"/><text x=\"%d\" y=\"%.1f\">not steady</text>\n", LEGEND + 17, y - 4,
		LEGEND + 42, y);
}

void rig_plot_write(const struct rig_table *table, FILE *file)
{
	struct panel panels[RIG_FIGURES];
	int count = 0;
	for (int i = 0; i < RIG_FIGURES; i++) {
		struct panel *panel = &panels[count];
		*panel = (struct panel){.figure = i, .x = LEFT + count % 2 * (ACROSS + GAP_X), .y = TOP + count / 2 * (DOWN + GAP_Y)};
		count += axes(table, panel);
	}
	const int height = TOP + (count + 1) / 2 * (DOWN + GAP_Y);
	fprintf(file, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" viewBox=\"0 0 %d %d\">\n<style>\n"
		      "text { font: 13px sans-serif; fill: #222 } .title { font-size: 15px } .name { font-weight: bold }\n"
		      ".back { fill: #fff } .line { stroke: #ddd } .zero { stroke: #888 } .measured { fill: #222 }\n"
		      "@media (prefers-color-scheme: dark) {\n  text { fill: #ddd } .back { fill: #111 } .line { stroke: #333 } .measured { fill: #ddd }\n}\n"
		      "</style>\n<rect class=\"back\" width=\"100%%\" height=\"100%%\"/>\n<text class=\"title\" x=\"%d\" y=\"24\">",
		WIDTH, height, WIDTH, height, LEFT);
	svg_text(table->params->shape, file);
	fprintf(file, "; posts of %g mm</text>\n", table->found.spacing * 1e3);
	for (int i = 0; i < count; i++)
		write_panel(table, &panels[i], file);
	write_legend(table, file);
	fputs("</svg>\n", file);
}
