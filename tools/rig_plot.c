/*
 * Plots over slip: sinkage, drawbar pull, torque, efficiency; at slip angles the side force, at a depth the force against the way. A colour and a mark
 * for each soil and slip angle, a dash a load or a depth, a dot a measured trial. Of an object without a slip the plots are over its angle if it has
 * several, else over its load or depth. Colours: Okabe's and Ito's, which every eye tells apart. No two of 42 have both the same colour and the same mark.
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
static const char *const titles[RIG_FIGURES] = {"sinkage, mm", "drawbar pull, N", "side force, N", "torque, N m", "efficiency", "force against the way, N"};
#define COUNT(list) (sizeof list / sizeof *list)

/* One plot: where it is, and what its axes show. */
struct panel {
	int figure;
	double x, y;                   /* of its upper left corner */
	double low[2], high[2], step[2];
};

/* --- what is drawn over what --- */

enum over { OVER_SLIP, OVER_ANGLE, OVER_LOAD };

static enum over over_of(const struct rig_table *table)
{
	return rig_has_slip(table) ? OVER_SLIP : table->params->angle_count > 1 ? OVER_ANGLE : OVER_LOAD;
}

static const char *const names[] = {[OVER_SLIP] = "slip", [OVER_ANGLE] = "angle from its way, degrees"};
static const char *name_of(const struct rig_table *table)
{
	const enum over over = over_of(table);
	for (size_t i = 0; i < table->params->slip_count && over == OVER_SLIP; i++)
		if (table->params->slips[i] < -1)
			return "slip; below 0: turn x radius / way - 1";
	return over != OVER_LOAD ? names[over] : table->params->depth_count > 0 ? "depth, mm" : "load, N";
}

/* Returns a slip as it is drawn: if some wheel turns by less than half of its way, those that are braked from 0 to -1, which is a locked one. */
static double drawn_slip(const struct rig_table *table, double slip)
{
	return slip < 0 && name_of(table) != names[OVER_SLIP] ? slip / (1 - slip) : slip;
}

static bool is_shown(const struct rig_table *table, int figure)
{
	const bool slips = rig_has_slip(table), force = !slips || table->params->depth_count > 0, turned = rig_is_turned(table->params);
	const bool shown[RIG_FIGURES] = {table->params->depth_count == 0, !force || turned, turned, slips, slips && !force, force};
	return shown[figure];
}

static const char *title_of(const struct rig_table *table, int figure)
{
	return figure == 3 && table->found.belt ? "pull of the belt, N" : titles[figure];
}

static double across(const struct rig_table *table, const struct rig_row *row)
{
	switch (over_of(table)) {
	case OVER_SLIP: return drawn_slip(table, row->slip);
	case OVER_ANGLE: return rig_angle(table->params, row->angle);
	case OVER_LOAD: break;
	}
	return table->params->depth_count > 0 ? table->params->depths[row->load] * 1e3 : table->params->loads[row->load];
}

/* A curve: its colour is of a soil and an angle, its dash of a load. */
static size_t angles_of(const struct rig_table *table)
{
	return over_of(table) == OVER_ANGLE || table->params->angle_count == 0 ? 1 : table->params->angle_count;
}

static size_t dashes_of(const struct rig_table *table)
{
	return over_of(table) == OVER_LOAD ? 1 : table->params->load_count + table->params->depth_count;
}

static size_t colour_of(const struct rig_table *table, const struct rig_row *row)
{
	return row->soil * angles_of(table) + (over_of(table) == OVER_ANGLE ? 0 : row->angle);
}

static size_t dash_of(const struct rig_table *table, const struct rig_row *row)
{
	return over_of(table) == OVER_LOAD ? 0 : row->load;
}

/* --- plots --- */

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
	for (size_t i = 0; i < table->measured_count && rig_has_slip(table); i++) {
		const double slip = drawn_slip(table, table->measured[i].slip);
		if (slip < low[0] || slip > high[0])
			continue;
		widen(rig_measured_figure(&table->measured[i], panel->figure), &low[1], &high[1]);
	}
	low[1] = fmin(low[1], 0);
	for (int k = 0; k < 2; k++)
		svg_axis(&low[k], &high[k], &panel->step[k]);
	return any && is_shown(table, panel->figure);
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
		panel->y - 9, title_of(table, panel->figure), panel->x + ACROSS / 2.0, panel->y + DOWN + 36, name_of(table));
}

static void write_mark(double x, double y, size_t number, bool filled, FILE *file)
{
	const char *colour = colours[number % COUNT(colours)];
	fprintf(file, "<path class=\"mark\" stroke=\"%s\" fill=\"%s\" d=\"M%.1f %.1f%s\"/>\n", colour, filled ? colour : "none", x, y, marks[number % COUNT(marks)]);
}

static void write_curve(const struct rig_table *table, const struct panel *panel, size_t number, size_t dash, FILE *file)
{
	const char *colour = colours[number % COUNT(colours)];
	const struct rig_row *const end = table->rows + table->count;
	double before = -INFINITY;
	bool down = false;
	fprintf(file, "<path fill=\"none\" stroke-width=\"2\" stroke=\"%s\" stroke-dasharray=\"%s\" d=\"", colour, dashes[dash % COUNT(dashes)]);
	for (size_t n = 0; n < table->count; n++) { /* in order along the axis, whatever the order of the rows */
		const struct rig_row *next = NULL;
		for (const struct rig_row *row = table->rows; row < end; row++)
			if (colour_of(table, row) == number && dash_of(table, row) == dash && across(table, row) > before &&
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
	for (const struct rig_row *row = table->rows; row < end; row++)
		if (colour_of(table, row) == number && dash_of(table, row) == dash && isfinite(rig_figure(row, panel->figure)) && isfinite(across(table, row)))
			write_mark(place_x(panel, across(table, row)), place_y(panel, rig_figure(row, panel->figure)), number, row->state == RIG_STEADY, file);
}

/* A trial of an angle has its colour where there are several. */
static void write_measured(const struct rig_table *table, const struct panel *panel, FILE *file)
{
	const size_t angles = table->params->angle_count > 0 ? table->params->angle_count : 1;
	for (size_t i = 0; i < table->measured_count && rig_has_slip(table); i++) {
		const struct rig_measured *m = &table->measured[i];
		const double value = rig_measured_figure(m, panel->figure), slip = drawn_slip(table, m->slip);
		size_t angle = 0;
		while (angle < angles && !rig_same_angle(m->angle, rig_angle(table->params, angle)))
			angle++;
		if (!isfinite(value) || slip < panel->low[0] || slip > panel->high[0] || angle == angles)
			continue;
		fprintf(file, "<circle class=\"measured\" cx=\"%.1f\" cy=\"%.1f\" r=\"3.2\"", place_x(panel, slip), place_y(panel, value));
		if (angles > 1)
			fprintf(file, " style=\"fill:%s;stroke:#222\"", colours[angle % COUNT(colours)]);
		fputs("/>\n", file);
	}
}

static void write_panel(const struct rig_table *table, const struct panel *panel, FILE *file)
{
	write_axes(table, panel, file);
	for (size_t number = 0; number < table->params->soil_count * angles_of(table); number++)
		for (size_t dash = 0; dash < dashes_of(table); dash++)
			write_curve(table, panel, number, dash, file);
	write_measured(table, panel, file);
}

/* --- the legend --- */

static double legend_line(double y, const char *colour, const char *dash, FILE *file)
{
	fprintf(file, "<path stroke=\"%s\" stroke-width=\"2\" stroke-dasharray=\"%s\" d=\"M%d %.1fh34\"/><text x=\"%d\" y=\"%.1f\">", colour, dash, LEGEND,
		y - 4, LEGEND + 42, y);
	return y + 20;
}

static void write_legend(const struct rig_table *table, FILE *file)
{
	const struct rig_params *params = table->params;
	const size_t angles = angles_of(table);
	double y = TOP + 12;
	for (size_t i = 0; i < params->soil_count * angles; i++) {
		y = legend_line(y, colours[i % COUNT(colours)], "none", file);
		const char *soil = table->soils[i / angles];
		char label[LABEL + 1];
		snprintf(label, sizeof label, "%s", soil);
		svg_text(label, file);
		fputs(strlen(soil) > LABEL ? "…" : "", file);
		if (rig_is_turned(params) && over_of(table) != OVER_ANGLE)
			fprintf(file, ", %g°", rig_angle(params, i % angles));
		fputs("</text>\n", file);
		write_mark(LEGEND + 17, y - 24, i, true, file);
	}
	for (size_t i = 0; i < dashes_of(table) && over_of(table) != OVER_LOAD; i++) {
		y = legend_line(y, "#888", dashes[i % COUNT(dashes)], file);
		if (params->depth_count > 0)
			fprintf(file, "%g mm deep</text>\n", params->depths[i] * 1e3);
		else
			fprintf(file, "%g N</text>\n", params->loads[i]);
	}
	if (table->measured_count > 0 && rig_has_slip(table)) {
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
