/* Plots that are not of bodies: the rut profile, times of steps, and the page cache. */
#include <math.h>

#include "html_plot.h"
#include "html_report.h"

#define EDGES_MOST 4096

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
			html_legend_begin(report);
			for (size_t i = 0; i < report->count; i++)
				if (report->ruts[i].count > 0)
					html_legend_line(report, &(struct html_line){.colour = i}, report->runs[i].folder, "");
			html_legend_end(report);
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
	TRY_MEM(room, "the times of steps");
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
			html_legend_begin(report);
			for (size_t i = 0; i < count; i++)
				html_legend_line(report, &lines[i], report->runs[lines[i].colour].folder, "");
			html_legend_end(report);
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
		html_legend_begin(report);
		for (size_t i = 0, at = 0; i < report->count; i++)
			for (size_t k = 0; k < HTML_POLICIES && report->caches[i].count > 0; k++)
				html_legend_line(report, &lines[at++], report->runs[i].folder, names[k]);
		html_legend_end(report);
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
