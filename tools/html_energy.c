/* Where the energy of objects and vehicles went, from their first row to their last: a column for each of them. */
#include <math.h>

#include "html_report.h"
#include "svg.h"

/* One that is shown, and its drive. */
struct shown {
	const struct html_run *run;
	const struct html_body *body;
};

static size_t take(const struct html_report *report, bool vehicles, struct shown *list)
{
	size_t count = 0;
	for (size_t i = 0; i < report->count; i++) {
		const struct html_run *run = &report->runs[i];
		const struct html_bodies *bodies = vehicles ? &run->vehicles : &run->objects;
		for (size_t k = 0; k < html_drawn(report, bodies); k++)
			if (bodies->list[k].count > 1)
				list[count++] = (struct shown){run, &bodies->list[k]};
	}
	return count;
}

static void table_head(const struct html_report *report, const struct shown *list, size_t count, const char *corner)
{
	fprintf(report->file, "<div class=\"scroll\"><table><thead><tr><th scope=\"col\">%s</th>", corner);
	for (size_t i = 0; i < count; i++) {
		fputs("<th scope=\"col\">", report->file);
		if (report->count > 1) {
			svg_text(list[i].run->folder, report->file);
			fputs(": ", report->file);
		}
		svg_text(list[i].body->name, report->file);
		fputs("</th>", report->file);
	}
	fputs("</tr></thead><tbody>\n", report->file);
}

static double way_of(const struct html_body *body)
{
	return body->way[body->count - 1];
}

/* What a row has of one of them. NaN: not known. */
typedef double (*figure_fn)(const struct shown *shown);

static void table_row(const struct html_report *report, const struct shown *list, size_t count, const char *name, figure_fn figure)
{
	bool any = false;
	for (size_t i = 0; i < count; i++)
		any = any || isfinite(figure(&list[i]));
	if (!any)
		return;
	fprintf(report->file, "<tr><th scope=\"row\">%s</th>", name);
	for (size_t i = 0; i < count; i++) {
		const double value = figure(&list[i]);
		if (isfinite(value))
			fprintf(report->file, "<td class=\"number\"><data value=\"%.17g\">%.4g</data></td>", value, value);
		else
			fputs("<td class=\"none\">&#8211;</td>", report->file);
	}
	fputs("</tr>\n", report->file);
}

/* --- objects --- */

static double way(const struct shown *shown)
{
	return way_of(shown->body);
}

static double soil(const struct shown *shown)
{
	return shown->body->energy.soil;
}

static double soil_a_metre(const struct shown *shown)
{
	return way_of(shown->body) > 0 ? 1e3 * shown->body->energy.soil / way_of(shown->body) : (double)NAN;
}

static double turns(const struct shown *shown)
{
	return shown->body->energy.torque != 0 ? shown->body->energy.torque : (double)NAN;
}

static double by_slip(const struct shown *shown)
{
	return turns(shown) > 0 && way_of(shown->body) > 0 ? 1e3 * shown->body->energy.slip / way_of(shown->body) : (double)NAN;
}

static double by_sinking(const struct shown *shown)
{
	return soil_a_metre(shown) - (isfinite(by_slip(shown)) ? by_slip(shown) : 0);
}

static double climb(const struct shown *shown)
{
	return shown->body->energy.climb;
}

static double pull(const struct shown *shown)
{
	return shown->body->energy.push - shown->body->energy.climb;
}

/* Of a wheel that drives: the useful part of the torque's work. */
static double efficiency(const struct shown *shown)
{
	const struct html_energy *energy = &shown->body->energy;
	return energy->torque > 0 && energy->push > 0 ? energy->push / energy->torque : (double)NAN;
}

void html_energy_objects(const struct html_report *report)
{
	struct shown list[HTML_RUNS * HTML_COLOURS];
	const size_t count = take(report, false, list);
	if (count == 0)
		return;
	table_head(report, list, count, "from the first row to the last");
	table_row(report, list, count, "way, m", way);
	table_row(report, list, count, "work of the axle's torque, kJ", turns);
	table_row(report, list, count, "work of the drawbar pull, kJ", pull);
	table_row(report, list, count, "work that lifts the weight, kJ", climb);
	table_row(report, list, count, "energy into the soil, kJ", soil);
	table_row(report, list, count, "energy into the soil for each metre, J/m", soil_a_metre);
	table_row(report, list, count, "of that, by slip, J/m", by_slip);
	table_row(report, list, count, "of that, by sinking and pushing soil, J/m", by_sinking);
	table_row(report, list, count, "tractive efficiency, share of 1", efficiency);
	html_table_end(report);
	fputs("<p class=\"small\">Work of the torque = energy into the soil + work of the drawbar pull + work that lifts the weight. The table has the whole drive, with its run-up; the results have the last quarter. "
	      "The pull's work is below 0 where the object is pushed or towed. The part by slip is slip times the work of the torque. Tractive efficiency is the work of pull and lifting over that of the torque.</p>\n",
	      report->file);
}

/* --- vehicles --- */

static double gained(const struct shown *shown, int value)
{
	const double *values = shown->body->values[value];
	return values[shown->body->count - 1] - values[0];
}

static double work(const struct shown *shown)
{
	return gained(shown, HTML_WORK);
}

static double work_a_metre(const struct shown *shown)
{
	return way_of(shown->body) > 0 ? 1e3 * work(shown) / way_of(shown->body) : (double)NAN;
}

static double into_soil(const struct shown *shown)
{
	return gained(shown, HTML_SOIL);
}

static double kinetic(const struct shown *shown)
{
	return gained(shown, HTML_KINETIC);
}

static double lifted(const struct shown *shown)
{
	const cJSON *vehicle = cJSON_GetObjectItemCaseSensitive(html_members(shown->run, "vehicles"), shown->body->name);
	const cJSON *mass = cJSON_GetObjectItemCaseSensitive(vehicle, "mass"), *gravity = cJSON_GetObjectItemCaseSensitive(vehicle, "gravity");
	return cJSON_IsNumber(mass) && cJSON_IsNumber(gravity) ? mass->valuedouble * gravity->valuedouble * shown->body->rise / 1e3 : (double)NAN;
}

/* NaN: it has no brakes. */
static double braked(const struct shown *shown)
{
	const cJSON *vehicle = cJSON_GetObjectItemCaseSensitive(html_members(shown->run, "vehicles"), shown->body->name);
	const cJSON *loss = cJSON_GetObjectItemCaseSensitive(vehicle, "brake_loss");
	return cJSON_IsNumber(loss) ? loss->valuedouble / 1e3 : (double)NAN;
}

static double rest(const struct shown *shown)
{
	const double brakes = braked(shown);
	return work(shown) - into_soil(shown) - kinetic(shown) - lifted(shown) - (isnan(brakes) ? 0 : brakes);
}

void html_energy_vehicles(const struct html_report *report)
{
	struct shown list[HTML_RUNS * HTML_COLOURS];
	const size_t count = take(report, true, list);
	if (count == 0)
		return;
	table_head(report, list, count, "from the first row to the last");
	table_row(report, list, count, "way, m", way);
	table_row(report, list, count, "work of the actuators, kJ", work);
	table_row(report, list, count, "work of the actuators for each metre, J/m", work_a_metre);
	table_row(report, list, count, "into the soil, by all soil geoms, kJ", into_soil);
	table_row(report, list, count, "to lift its weight, kJ", lifted);
	table_row(report, list, count, "into motion, kJ", kinetic);
	bool any = false;
	for (size_t i = 0; i < count; i++)
		any = any || !isnan(braked(&list[i]));
	if (any)
		table_row(report, list, count, "into brakes, in the whole drive, kJ", braked);
	table_row(report, list, count, "the rest: dampers, springs and stops of its joints, kJ", rest);
	html_table_end(report);
	fputs("<p class=\"small\">The table has the whole drive, with its run-up; the results have the last quarter. The weight is lifted by as much as the origin of the vehicle's root body rises. The energy into the soil is that of the rows of objects.csv.</p>\n",
	      report->file);
}
