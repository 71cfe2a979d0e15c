/*
 * The plots of a report. With one drive, each object has a colour. With several drives, each drive has a colour and each object a
 * dash. Where nothing can be drawn, a sentence stands in place of the plot.
 */
#include <math.h>
#include <string.h>

#include "html_plot.h"
#include "html_report.h"
#include "svg.h"

#define EDGES_MOST 4096

enum { LINES = HTML_RUNS * HTML_COLOURS };

static size_t bodies_most(const struct html_report *report)
{
	return report->count > 1 ? HTML_DASHES : HTML_COLOURS;
}

static struct html_line line_of(const struct html_report *report, size_t run, size_t body)
{
	return (struct html_line){.colour = report->count > 1 ? run : body, .dash = report->count > 1 ? body : 0};
}

/* --- the legend --- */

static void legend_begin(const struct html_report *report)
{
	fputs("<ul class=\"legend\">\n", report->file);
}

static void legend_line(const struct html_report *report, const struct html_line *line, const char *folder, const char *name)
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

static void legend_end(const struct html_report *report)
{
	fputs("</ul>\n", report->file);
}

/* --- curves of bodies --- */

/* Curves of objects.csv, curves of vehicles.csv, or ways. */
enum kind { OBJECTS, VEHICLES, WAYS };

static const struct html_bodies *bodies_of(const struct html_run *run, enum kind kind)
{
	return kind == VEHICLES ? &run->vehicles : kind == OBJECTS ? &run->objects : html_ways(run);
}

static size_t drawn(const struct html_report *report, const struct html_bodies *bodies)
{
	return bodies->count < bodies_most(report) ? bodies->count : bodies_most(report);
}

static void legend(const struct html_report *report, enum kind kind)
{
	legend_begin(report);
	for (size_t i = 0; i < report->count; i++) {
		const struct html_bodies *bodies = bodies_of(&report->runs[i], kind);
		for (size_t k = 0; k < drawn(report, bodies); k++) {
			const struct html_line line = line_of(report, i, k);
			legend_line(report, &line, report->runs[i].folder, bodies->list[k].name);
		}
	}
	legend_end(report);
	for (size_t i = 0; i < report->count; i++) {
		const struct html_bodies *bodies = bodies_of(&report->runs[i], kind);
		char text[200];
		if (bodies->count <= drawn(report, bodies))
			continue;
		snprintf(text, sizeof text, "The plots show the first %zu of %zu %s", drawn(report, bodies), bodies->count, kind == VEHICLES ? "vehicles" : "objects");
		html_sentence(report, &report->runs[i], text);
	}
}

/* Makes the lines of one value; with HTML_VALUES, the ways in plan. Skips lines without points. Returns their number. */
static size_t take_lines(const struct html_report *report, enum kind kind, int value, bool over_time, struct html_line *lines)
{
	size_t count = 0;
	for (size_t i = 0; i < report->count; i++) {
		const struct html_bodies *bodies = bodies_of(&report->runs[i], kind);
		for (size_t k = 0; k < drawn(report, bodies); k++) {
			const struct html_body *body = &bodies->list[k];
			struct html_line line = line_of(report, i, k);
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
		for (size_t k = 0; k < drawn(report, bodies); k++)
			known += isfinite(bodies->list[k].values[HTML_ENERGY][0]) ? 1 : 0;
		if (known == drawn(report, bodies))
			continue;
		snprintf(text, sizeof text, "No energy for %zu of these objects: the rows do not tell how far the wheels of vehicles, or belts, turned%s", drawn(report, bodies) - known,
			 report->runs[i].vehicles.there ? "; see the work of the vehicle below" : "");
		html_sentence(report, &report->runs[i], text);
	}
}

static void write_bodies(const struct html_report *report)
{
	static const struct value values[] = {
		{HTML_SINKAGE, "sinkage", ", mm", 0, 0, false, "No sinkage: objects.csv has none"},
		{HTML_SLIP, "slip", "", -1, 1, true, "No slip: it is 0 in all rows"},
		{HTML_DRAWBAR, "drawbar pull", ", N", 0, 0, false, "No drawbar pull: nothing moved"},
		{HTML_ENERGY, "energy into the soil", ", kJ", 0, 0, false, NULL},
	};
	html_section(report, "curves", "Sinkage, slip, drawbar pull, energy");
	if (!any_there(report, OBJECTS)) {
		html_sentence(report, NULL, "No curves: there are no rows of objects.csv; set output.forces in the scene, if its model computes forces (scm)");
	} else {
		legend(report, OBJECTS);
		fputs("<div class=\"plots\">\n", report->file);
		for (size_t i = 0; i < sizeof values / sizeof *values; i++)
			write_value(report, OBJECTS, &values[i]);
		tell_energy(report);
		tell_missing(report, OBJECTS, "No rows of objects.csv");
		fputs("</div>\n<p class=\"small\">The way is that of the object's centre, in plan. Drawbar pull is the soil's force on the object along the way. Slip beyond -1 and 1 "
		      "is drawn at -1 and 1. Energy is the work against the soil's force and, for a wheel, against the soil's moment.</p>\n",
		      report->file);
	}
	html_section_end(report);
}

static void write_vehicles(const struct html_report *report)
{
	static const struct value values[] = {
		{HTML_SPEED, "speed", ", m/s", 0, 0, false, "No speed: vehicles.csv has none"},
		{HTML_WORK, "work of the actuators", ", kJ", 0, 0, false, "No work: vehicles.csv has none"},
		{HTML_KINETIC, "kinetic energy", ", kJ", 0, 0, false, "No kinetic energy: vehicles.csv has none"},
	};
	bool told = false;
	for (size_t i = 0; i < report->count; i++)
		told = told || cJSON_GetArraySize(html_at(&report->runs[i], "vehicles")) > 0;
	if (!told)
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
	}
	html_section_end(report);
}

/* --- ways --- */

static void write_ways(const struct html_report *report)
{
	struct html_line lines[LINES + HTML_RUNS];
	double ends[HTML_RUNS][2][2];
	size_t count = take_lines(report, WAYS, HTML_VALUES, false, lines);
	html_section(report, "ways", "Ways, seen from above");
	if (count == 0) {
		html_sentence(report, NULL, any_there(report, WAYS) ? "No ways: nothing moved"
									: "No ways: run.json has none, and there are no rows of objects.csv or vehicles.csv");
	} else {
		bool profiles = false;
		for (size_t i = 0; i < report->count; i++) {
			const struct html_rut *rut = &report->ruts[i];
			if (rut->count == 0)
				continue;
			for (int k = 0; k < 2; k++) {
				const double half = k == 0 ? -rut->half : rut->half;
				ends[i][0][k] = rut->middle[0] + half * rut->left[0];
				ends[i][1][k] = rut->middle[1] + half * rut->left[1];
			}
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

/* --- the rut --- */

enum status html_curves_rut(const struct html_report *report)
{
	struct html_line lines[HTML_RUNS];
	size_t count = 0;
	html_section(report, "rut", "Rut profile");
	for (size_t i = 0; i < report->count; i++) {
		const struct html_rut *rut = &report->ruts[i];
		if (rut->count > 0)
			lines[count++] = (struct html_line){.colour = i, .count = rut->count, .x = rut->across, .y = rut->change};
		else
			html_sentence(report, &report->runs[i], rut->why);
	}
	if (count > 0) {
		const struct html_plot plot = {.title = "The ground across the way", .across = "across the way, m (left is positive)", .up = "change of height, mm", .lines = lines,
					       .count = count, .zero = true, .upright = (double)NAN};
		if (report->count > 1) {
			legend_begin(report);
			for (size_t i = 0; i < report->count; i++)
				if (report->ruts[i].count > 0)
					legend_line(report, &(struct html_line){.colour = i}, report->runs[i].folder, "");
			legend_end(report);
		}
		fputs("<div class=\"plots wide\">\n", report->file);
		html_plot_write(&plot, report->file);
		fputs("</div>\n", report->file);
		for (size_t i = 0; i < report->count; i++) {
			const struct html_rut *rut = &report->ruts[i];
			char text[400];
			if (rut->count == 0)
				continue;
			snprintf(text, sizeof text,
				 "At the middle of the way of %.80s (%.3f m east, %.3f m north): %.1f mm deep, rims %.1f mm high; %.4g m2 below the old ground, %.4g m2 above it",
				 rut->body, rut->middle[0], rut->middle[1], -rut->deepest, rut->highest, rut->below, rut->above);
			html_sentence(report, &report->runs[i], text);
		}
	}
	html_section_end(report);
	return STATUS_OK;
}

/* --- times of steps --- */

/* Reads the histogram of a run. `shares`: percent of the steps. Returns the number of edges; 0: there is no valid histogram. */
static size_t take_histogram(const struct html_run *run, double *edges, double *shares)
{
	const cJSON *lists[2] = {html_at(run, "step_ms.histogram.edges"), html_at(run, "step_ms.histogram.counts")};
	const int count = cJSON_GetArraySize(lists[1]);
	const cJSON *item;
	double sum = 0;
	int i = 0;
	if (!cJSON_IsArray(lists[0]) || !cJSON_IsArray(lists[1]) || count < 1 || count >= EDGES_MOST || cJSON_GetArraySize(lists[0]) != count + 1)
		return 0;
	cJSON_ArrayForEach(item, lists[0]) {
		if (!cJSON_IsNumber(item) || !(item->valuedouble > (i > 0 ? edges[i - 1] : 0)) || !isfinite(item->valuedouble))
			return 0;
		edges[i++] = item->valuedouble;
	}
	i = 0;
	cJSON_ArrayForEach(item, lists[1]) {
		if (!cJSON_IsNumber(item) || !(item->valuedouble >= 0) || !isfinite(item->valuedouble))
			return 0;
		sum += shares[i++] = item->valuedouble;
	}
	for (i = 0; i < count; i++)
		shares[i] *= sum > 0 ? 100 / sum : 0;
	shares[count] = 0;
	return sum > 0 ? (size_t)count + 1 : 0;
}

static void steps_table(const struct html_report *report)
{
	static const char *const paths[] = {"step_ms.p50", "step_ms.p95", "step_ms.p99", "step_ms.max"};
	static const char *const names[] = {"median, ms", "95th percentile, ms", "99th percentile, ms", "slowest, ms"};
	html_table(report, "");
	for (size_t k = 0; k < sizeof paths / sizeof *paths; k++) {
		fprintf(report->file, "<tr><th scope=\"row\">%s</th>", names[k]);
		for (size_t i = 0; i < report->count; i++) {
			const double value = html_number(&report->runs[i], paths[k]);
			if (isfinite(value))
				fprintf(report->file, "<td class=\"number\"><data value=\"%.17g\">%.4g</data></td>", value, value);
			else
				fputs("<td class=\"none\">&#8211;</td>", report->file);
		}
		fputs("</tr>\n", report->file);
	}
	html_table_end(report);
}

enum status html_curves_steps(const struct html_report *report)
{
	struct html_line lines[HTML_RUNS];
	double *room = mem_alloc((size_t)2 * HTML_RUNS * EDGES_MOST, sizeof *room);
	size_t count = 0;
	if (room == NULL)
		return fail_memory("the times of steps");
	html_section(report, "steps", "Step times");
	steps_table(report);
	for (size_t i = 0; i < report->count; i++) {
		double *edges = room + 2 * i * EDGES_MOST, *shares = edges + EDGES_MOST;
		const size_t edge_count = take_histogram(&report->runs[i], edges, shares);
		if (edge_count > 0)
			lines[count++] = (struct html_line){.colour = i, .count = edge_count, .x = edges, .y = shares, .steps = true};
		else
			html_sentence(report, &report->runs[i], "No histogram: run.json has none; no step was made, or an older furrow made it");
	}
	if (count > 0) {
		const struct html_plot plot = {
			.title = "Step times", .across = "step time, ms", .up = "steps, %", .lines = lines, .count = count, .zero = true, .logarithmic = true,
			.upright = report->count == 1 ? html_number(&report->runs[0], "step_ms.p50") : (double)NAN, .told = "median",
		};
		if (report->count > 1) {
			legend_begin(report);
			for (size_t i = 0; i < count; i++)
				legend_line(report, &lines[i], report->runs[lines[i].colour].folder, "");
			legend_end(report);
		}
		fputs("<div class=\"plots wide\">\n", report->file);
		html_plot_write(&plot, report->file);
		fputs("</div>\n<p class=\"small\">Four bars for each doubling of the time.</p>\n", report->file);
	}
	html_section_end(report);
	mem_free(room);
	return STATUS_OK;
}

/* --- the page cache --- */

enum status html_curves_cache(const struct html_report *report)
{
	static const char *const names[HTML_POLICIES] = {"LRU", "optimum"};
	struct html_line lines[HTML_RUNS * HTML_POLICIES];
	size_t count = 0;
	html_section(report, "cache", "Page cache: misses over slots");
	for (size_t i = 0; i < report->count; i++) {
		const struct html_cache *cache = &report->caches[i];
		for (size_t k = 0; k < HTML_POLICIES && cache->count > 0; k++)
			lines[count++] = (struct html_line){
				.colour = report->count > 1 ? i : k, .dash = report->count > 1 ? k : 0, .count = cache->count, .x = cache->slots, .y = cache->misses[k], .dots = true};
		if (cache->count == 0)
			html_sentence(report, &report->runs[i], cache->why);
	}
	if (count > 0) {
		const struct html_plot plot = {
			.title = "Misses over slots", .across = "slots", .up = "misses", .lines = lines, .count = count, .zero = true, .logarithmic = true,
			.upright = report->count == 1 ? html_number(&report->runs[0], "cache.slots") : (double)NAN, .told = "slots of this drive",
		};
		legend_begin(report);
		for (size_t i = 0, at = 0; i < report->count; i++)
			for (size_t k = 0; k < HTML_POLICIES && report->caches[i].count > 0; k++)
				legend_line(report, &lines[at++], report->runs[i].folder, names[k]);
		legend_end(report);
		fputs("<div class=\"plots wide\">\n", report->file);
		html_plot_write(&plot, report->file);
		fputs("</div>\n", report->file);
		for (size_t i = 0; i < report->count; i++) {
			char text[200];
			if (report->caches[i].count == 0)
				continue;
			snprintf(text, sizeof text, "%llu accesses to %llu tiles, simulated as furrow cache-sim does: each cache starts empty and does not prefetch",
				 (unsigned long long)report->caches[i].accesses, (unsigned long long)report->caches[i].tiles);
			html_sentence(report, &report->runs[i], text);
		}
	}
	html_section_end(report);
	return STATUS_OK;
}
