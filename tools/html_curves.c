/*
 * The plots of a report. With one drive, each object has a colour. With several drives, each drive has a colour and each object a
 * dash. Where nothing can be drawn, a sentence stands in place of the plot.
 */
#include <math.h>

#include "html_plot.h"
#include "html_report.h"
#include "svg.h"

enum { LINES = HTML_RUNS * HTML_COLOURS };

size_t html_bodies_most(const struct html_report *report)
{
	return report->count > 1 ? HTML_DASHES : HTML_COLOURS;
}

struct html_line html_line_of(const struct html_report *report, size_t run, size_t body)
{
	return (struct html_line){.colour = report->count > 1 ? run : body, .dash = report->count > 1 ? body : 0};
}

/* --- the legend --- */

void html_legend_begin(const struct html_report *report)
{
	fputs("<ul class=\"legend\">\n", report->file);
}

void html_legend_line(const struct html_report *report, const struct html_line *line, const char *folder, const char *name)
{
	static const char *const dashes[HTML_DASHES] = {"", "7 4", "2 3", "10 3 2 3"};
	fprintf(report->file, "<li><svg class=\"key\" viewBox=\"0 0 34 10\"><path class=\"curve s%zu\" stroke-dasharray=\"%s\" d=\"M1 5h32\"/></svg> ",
		line->colour % HTML_COLOURS, dashes[line->dash % HTML_DASHES]);
	if (report->count > 1)
		svg_text(folder, report->file);
	if (report->count > 1 && name[0] != '\0')
		fputs(": ", report->file);
	svg_text(name, report->file);
	fputs("</li>\n", report->file);
}

void html_legend_end(const struct html_report *report)
{
	fputs("</ul>\n", report->file);
}

/* --- curves of bodies --- */

#define LEVEL 0.02 /* sine of a slope from which grade resistance is shown */

/* Curves of objects.csv, curves of vehicles.csv and of actuators in it, or ways. */
enum kind { OBJECTS, VEHICLES, ACTUATORS, WAYS };

static const struct html_bodies *bodies_of(const struct html_run *run, enum kind kind)
{
	return kind == VEHICLES ? &run->vehicles : kind == ACTUATORS ? &run->actuators : kind == OBJECTS ? &run->objects : html_ways(run);
}

size_t html_drawn(const struct html_report *report, const struct html_bodies *bodies)
{
	return bodies->count < html_bodies_most(report) ? bodies->count : html_bodies_most(report);
}

static void legend(const struct html_report *report, enum kind kind)
{
	html_legend_begin(report);
	for (size_t i = 0; i < report->count; i++) {
		const struct html_bodies *bodies = bodies_of(&report->runs[i], kind);
		for (size_t k = 0; k < html_drawn(report, bodies); k++) {
			const struct html_line line = html_line_of(report, i, k);
			html_legend_line(report, &line, report->runs[i].folder, bodies->list[k].name);
		}
	}
	html_legend_end(report);
	for (size_t i = 0; i < report->count; i++) {
		const struct html_bodies *bodies = bodies_of(&report->runs[i], kind);
		char text[200];
		if (bodies->count <= html_drawn(report, bodies))
			continue;
		snprintf(text, sizeof text, "The plots show the first %zu of %zu %s", html_drawn(report, bodies), bodies->count, kind == VEHICLES ? "vehicles" : kind == ACTUATORS ? "actuators" : "objects");
		html_sentence(report, &report->runs[i], text);
	}
}

/* Makes the lines of one value; with HTML_VALUES, the ways in plan. Skips lines without points. Returns their number. */
static size_t take_lines(const struct html_report *report, enum kind kind, int value, bool over_time, struct html_line *lines)
{
	size_t count = 0;
	for (size_t i = 0; i < report->count; i++) {
		const struct html_bodies *bodies = bodies_of(&report->runs[i], kind);
		for (size_t k = 0; k < html_drawn(report, bodies); k++) {
			const struct html_body *body = &bodies->list[k];
			struct html_line line = html_line_of(report, i, k);
			line.count = body->count;
			line.x = value == HTML_VALUES ? body->x : over_time ? body->time : body->way;
			line.y = value == HTML_VALUES ? body->y : body->values[value];
			if (html_line_any(&line) && (over_time || body->way[body->count - 1] > 0))
				lines[count++] = line;
		}
	}
	return count;
}

static bool all_zero(const struct html_line *lines, size_t count)
{
	for (size_t i = 0; i < count; i++)
		for (size_t k = 0; k < lines[i].count; k++)
			if (lines[i].y[k] != 0 && isfinite(lines[i].y[k]))
				return false;
	return true;
}

struct value {
	int value;
	const char *name, *unit; /* "sinkage", ", mm" */
	double low, high;        /* of the axis; equal: none */
	bool zero_is_none;       /* a value that is 0 in all rows is not drawn */
	const char *why;         /* it is not drawn; NULL: the caller tells */
};

/* Two plots: over the way and over time. */
static void write_value(const struct html_report *report, enum kind kind, const struct value *value)
{
	struct html_line lines[LINES];
	bool any = false;
	for (int over_time = 0; over_time < 2; over_time++) {
		char title[120], up[80];
		const size_t count = take_lines(report, kind, value->value, over_time != 0, lines);
		if (count == 0 || (value->zero_is_none && all_zero(lines, count)))
			continue;
		snprintf(title, sizeof title, "%s over %s", value->name, over_time ? "time" : "the way");
		snprintf(up, sizeof up, "%s%s", value->name, value->unit);
		const struct html_plot plot = {
			.title = title, .across = over_time ? "time, s" : "way, m", .up = up, .lines = lines, .count = count,
			.zero = true, .low = value->low, .high = value->high, .upright = (double)NAN,
		};
		html_plot_write(&plot, report->file);
		any = true;
	}
	if (!any && value->why != NULL)
		html_sentence(report, NULL, value->why);
}

static bool any_there(const struct html_report *report, enum kind kind)
{
	bool any = false;
	for (size_t i = 0; i < report->count; i++)
		any = any || bodies_of(&report->runs[i], kind)->there;
	return any;
}

/* Names the folders without rows. */
static void tell_missing(const struct html_report *report, enum kind kind, const char *text)
{
	for (size_t i = 0; i < report->count; i++)
		if (!bodies_of(&report->runs[i], kind)->there)
			html_sentence(report, &report->runs[i], text);
}

/* Says how many objects have no curve of energy. */
static void tell_energy(const struct html_report *report)
{
	for (size_t i = 0; i < report->count; i++) {
		const struct html_bodies *bodies = &report->runs[i].objects;
		size_t known = 0;
		char text[200];
		for (size_t k = 0; k < html_drawn(report, bodies); k++)
			known += isfinite(bodies->list[k].values[HTML_ENERGY][0]) ? 1 : 0;
		if (known == html_drawn(report, bodies))
			continue;
		snprintf(text, sizeof text, "No energy for %zu of these objects: the rows do not tell how far belts turn, nor wheels of vehicles that an older furrow drove",
			 html_drawn(report, bodies) - known);
		html_sentence(report, &report->runs[i], text);
	}
}

bool html_any_slope(const struct html_report *report)
{
	for (size_t i = 0; i < report->count; i++)
		for (size_t k = 0; k < html_drawn(report, &report->runs[i].objects); k++)
			if (report->runs[i].objects.list[k].steepest >= LEVEL)
				return true;
	return false;
}

static bool any_vehicle(const struct html_report *report)
{
	for (size_t i = 0; i < report->count; i++)
		if (cJSON_GetArraySize(html_members(&report->runs[i], "vehicles")) > 0)
			return true;
	return false;
}

static void write_bodies(const struct html_report *report)
{
	static const struct value values[] = {
		{HTML_SINKAGE, "sinkage", ", mm", 0, 0, false, "No sinkage: objects.csv has none"},
		{HTML_SLIP, "slip", ", share of 1", -1, 1, true, "No slip: it is 0 in all rows"},
		{HTML_TRACTION, "traction", ", N", 0, 0, false, NULL},
		{HTML_GRADE, "grade resistance", ", N", 0, 0, false, NULL},
		{HTML_DRAWBAR, "drawbar pull", ", N", 0, 0, false, "No drawbar pull: nothing moved"},
		{HTML_TORQUE, "torque", ", N m", 0, 0, false, NULL},
		{HTML_ENERGY, "energy into the soil", ", kJ", 0, 0, false, NULL},
		{HTML_LOSS, "energy into the soil for each metre", ", J/m", 0, 0, false, NULL},
	};
	html_section(report, "curves", "Sinkage, slip, drawbar pull, torque, energy");
	if (!any_there(report, OBJECTS)) {
		html_sentence(report, NULL, "No curves: there are no rows of objects.csv; set output.forces in the scene, if its model computes forces (scm)");
		html_section_end(report);
		return;
	}
	const bool slope = html_any_slope(report);
	legend(report, OBJECTS);
	fputs("<div class=\"plots\">\n", report->file);
	for (size_t i = 0; i < sizeof values / sizeof *values; i++)
		if (slope || (values[i].value != HTML_TRACTION && values[i].value != HTML_GRADE))
			write_value(report, OBJECTS, &values[i]);
	tell_energy(report);
	tell_missing(report, OBJECTS, "No rows of objects.csv");
	fputs("</div>\n<p class=\"small\">The way is that of the object's centre, seen from above. Slip beyond -1 and 1 is drawn at -1 and 1. Torque is what turns a wheel. Where curves lie on each other, "
	      "as those of the two wheels of an axle on level ground, the one that the legend names first is on top.</p>\n", report->file);
	fputs(slope ? "<p class=\"small\">Traction is the soil's force on the object along the ground, in the direction of the way. Grade resistance is the part of it that carries "
		      "the weight up the slope: the weight times the sine of the slope, below 0 downhill. Drawbar pull is traction less grade resistance. The weight is the "
		      "object's load; of an object without a load, such as a wheel of a vehicle, it is the soil's upward force.</p>\n"
		    : "<p class=\"small\">Drawbar pull is the soil's force on the object along the ground, in the direction of the way. These ways are level: less than 2 % of the "
		      "weight acts along them.</p>\n", report->file);
	if (any_vehicle(report))
		fputs("<p class=\"small\">A vehicle that drives itself at constant speed on level ground has a drawbar pull near 0, summed over its wheels. What its plot shows then is "
		      "noise.</p>\n", report->file);
	html_energy_objects(report);
	html_section_end(report);
}

static void write_actuators(const struct html_report *report)
{
	static const struct value force = {HTML_FORCE, "force of the actuators", ", N or N m", 0, 0, false, NULL};
	if (!any_there(report, ACTUATORS)) {
		html_sentence(report, NULL, "No forces of actuators: vehicles.csv has none");
		return;
	}
	legend(report, ACTUATORS);
	fputs("<div class=\"plots\">\n", report->file);
	write_value(report, ACTUATORS, &force);
	fputs("</div>\n<p class=\"small\">Force of an actuator before its gear: N m at a hinge, N at a slide or a site.</p>\n", report->file);
}

static void write_vehicles(const struct html_report *report)
{
	static const struct value values[] = {
		{HTML_SPEED, "speed", ", m/s", 0, 0, false, "No speed: vehicles.csv has none"},
		{HTML_WORK, "work of the actuators", ", kJ", 0, 0, false, "No work: vehicles.csv has none"},
		{HTML_SOIL, "energy into the soil", ", kJ", 0, 0, false, "No energy into the soil: objects.csv has no rows of these vehicles; set output.forces in the scene"},
		{HTML_KINETIC, "kinetic energy", ", kJ", 0, 0, false, "No kinetic energy: vehicles.csv has none"},
	};
	if (!any_vehicle(report))
		return;
	html_section(report, "vehicles", "Vehicles");
	if (!any_there(report, VEHICLES)) {
		html_sentence(report, NULL, "No curves of vehicles: there are no rows of vehicles.csv; set output.vehicles in the scene");
	} else {
		legend(report, VEHICLES);
		fputs("<div class=\"plots\">\n", report->file);
		for (size_t i = 0; i < sizeof values / sizeof *values; i++)
			write_value(report, VEHICLES, &values[i]);
		tell_missing(report, VEHICLES, "No rows of vehicles.csv");
		fputs("</div>\n", report->file);
		write_actuators(report);
		html_energy_vehicles(report);
	}
	html_section_end(report);
}

/* --- ways --- */

void html_legend_ways(const struct html_report *report)
{
	legend(report, WAYS);
}

bool html_profile(const struct html_report *report, size_t run, double ends[2][2])
{
	const struct html_rut *rut = &report->ruts[run];
	for (int k = 0; k < 2 && rut->count > 0; k++) {
		const double half = k == 0 ? -rut->half : rut->half;
		ends[0][k] = rut->middle[0] + half * rut->left[0];
		ends[1][k] = rut->middle[1] + half * rut->left[1];
	}
	return rut->count > 0;
}

/* All ways in one plot: for several drives, and for one drive without a map. */
static void write_ways(const struct html_report *report)
{
	struct html_line lines[LINES + HTML_RUNS];
	double ends[HTML_RUNS][2][2];
	size_t count = take_lines(report, WAYS, HTML_VALUES, false, lines);
	if (report->count == 1 && report->maps[0].ground.png != NULL)
		return;
	html_section(report, "ways", "Ways, seen from above");
	if (count == 0) {
		html_sentence(report, NULL, any_there(report, WAYS) ? "No ways: nothing moved"
									: "No ways: run.json has none, and there are no rows of objects.csv or vehicles.csv");
	} else {
		bool profiles = false;
		for (size_t i = 0; i < report->count; i++) {
			if (!html_profile(report, i, ends[i]))
				continue;
			lines[count++] = (struct html_line){.colour = report->count > 1 ? i : HTML_COLOURS - 1, .dash = 2, .count = 2, .x = ends[i][0], .y = ends[i][1], .dots = true};
			profiles = true;
		}
		const struct html_plot plot = {.title = "Ways, seen from above", .across = "east, m", .up = "north, m", .lines = lines, .count = count, .map = true,
					       .upright = (double)NAN};
		legend(report, WAYS);
		fputs("<div class=\"plots wide\">\n", report->file);
		html_plot_write(&plot, report->file);
		fputs("</div>\n", report->file);
		if (profiles)
			fputs("<p class=\"small\">A dotted line between two dots shows where the rut profile lies.</p>\n", report->file);
	}
	html_section_end(report);
}

enum status html_curves_write(const struct html_report *report)
{
	write_ways(report);
	write_bodies(report);
	write_vehicles(report);
	return STATUS_OK;
}
