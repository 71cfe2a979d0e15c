/* The tables of a report: a row for each figure, a column for each folder. */
#include <math.h>
#include <string.h>

#include "html_report.h"
#include "scene/scene.h"
#include "svg.h"

#define NAMES_MOST 20000 /* settings, or objects, of a folder that a table shows */
#define NOTHING "<td class=\"none\">&#8211;</td>"

void html_table(const struct html_report *report, const char *corner)
{
	fprintf(report->file, "<div class=\"scroll\"><table><thead><tr><th scope=\"col\">%s</th>", corner);
	for (size_t i = 0; i < report->count; i++) {
		fputs("<th scope=\"col\">", report->file);
		svg_text(report->runs[i].folder, report->file);
		fputs("</th>", report->file);
	}
	fputs("</tr></thead><tbody>\n", report->file);
}

void html_table_end(const struct html_report *report)
{
	fputs("</tbody></table></div>\n", report->file);
}

void html_row_head(const struct html_report *report, const char *text)
{
	fputs("<tr><th scope=\"row\">", report->file);
	svg_text(text, report->file);
	fputs("</th>", report->file);
}

static void text_cell(const char *text, FILE *file)
{
	if (text == NULL) {
		fputs(NOTHING, file);
		return;
	}
	fputs("<td>", file);
	svg_text(text, file);
	fputs("</td>", file);
}

/* Shows five digits. */
void html_number_cell(double value, double unit, FILE *file)
{
	const double shown = value / unit;
	if (!isfinite(value)) {
		fputs(NOTHING, file);
		return;
	}
	fprintf(file, "<td class=\"number\"><data value=\"%.17g\">", value);
	fprintf(file, shown == floor(shown) && fabs(shown) < 1e15 ? "%.0f" : "%.5g", shown == 0 ? 0 : shown);
	fputs("</data></td>", file);
}

static void value_cell(const cJSON *value, double unit, FILE *file)
{
	if (cJSON_IsBool(value))
		text_cell(cJSON_IsTrue(value) ? "yes" : "no", file);
	else if (cJSON_IsNumber(value))
		html_number_cell(value->valuedouble, unit, file);
	else
		text_cell(cJSON_GetStringValue(value), file);
}

static bool is_told(const cJSON *value)
{
	return value != NULL && !cJSON_IsNull(value);
}

/* Writes a row, if any folder has the value. */
static void row(const struct html_report *report, const char *name, const char *path, double unit)
{
	bool any = false;
	for (size_t i = 0; i < report->count; i++)
		any = any || is_told(html_at(&report->runs[i], path));
	if (!any)
		return;
	html_row_head(report, name);
	for (size_t i = 0; i < report->count; i++)
		value_cell(html_at(&report->runs[i], path), unit, report->file);
	fputs("</tr>\n", report->file);
}

struct row {
	const char *name, *path;
	double unit;
};

static void rows(const struct html_report *report, const struct row *list, size_t count)
{
	for (size_t i = 0; i < count; i++)
		row(report, list[i].name, list[i].path, list[i].unit);
}
#define ROWS(report, list) rows(report, list, sizeof(list) / sizeof *(list))

/* --- what was run --- */

void html_tables_run(const struct html_report *report)
{
	static const struct row list[] = {
		{"ended", "ended", 1}, {"steps", "steps", 1}, {"simulated, s", "simulated", 1}, {"resumed from step", "resumed_from", 1},
		{"scene", "scene.file", 1}, {"hash of the scene", "scene.hash", 1}, {"store", "store.file", 1}, {"base store", "store.base", 1},
		{"hash of the base store", "store.base_hash", 1},
		{"spacing of posts, m", "spacing", 1}, {"working level", "working_level", 1}, {"furrow", "version", 1},
		{"sun of pictures: azimuth, degrees", "sun.azimuth", 1}, {"sun of pictures: height, degrees", "sun.height", 1},
		{"sun's azimuth at the end, degrees", "sun.azimuth_at_end", 1}, {"sun's height at the end, degrees", "sun.height_at_end", 1},
	};
	html_section(report, "run", "What was run");
	html_table(report, "");
	ROWS(report, list);
	html_table_end(report);
	for (size_t i = 0; i < report->count; i++)
		if (html_members(&report->runs[i], "scene.values") == NULL)
			html_sentence(report, &report->runs[i], "run.json has no settings of the scene: an older furrow made it");
	html_section_end(report);
}

/* --- settings --- */

#define BASE "" /* key of the terrain: the base store, or the store that was deformed itself */

static const char *base_path(const struct html_report *report, size_t run)
{
	const char *base = html_string(&report->runs[run], "store.base");
	return base != NULL ? base : html_string(&report->runs[run], "store.file");
}

/* Returns the hash of the terrain if each run has one, else the path of its store: another path may be a copy. */
static const char *base_of(const struct html_report *report, size_t run)
{
	for (size_t i = 0; i < report->count; i++)
		if (html_string(&report->runs[i], "store.base_hash") == NULL)
			return base_path(report, run);
	return html_string(&report->runs[run], "store.base_hash");
}

static const char *value_of(const struct html_report *report, size_t run, const char *key)
{
	return key[0] == '\0' ? base_of(report, run) : html_setting(&report->runs[run], key);
}

/* "hill.furrow (be33580def278a43)", or the path where no hash is known. */
static void base_cell(const struct html_report *report, size_t run)
{
	const char *path = base_path(report, run), *is = base_of(report, run), *slash = path != NULL ? strrchr(path, '/') : NULL;
	char text[300];
	if (is != NULL && is != path)
		snprintf(text, sizeof text, "%.250s (%.20s)", slash != NULL ? slash + 1 : path != NULL ? path : "", is);
	text_cell(is != NULL && is != path ? text : is, report->file);
}

static bool differs(const struct html_report *report, const char *key)
{
	const char *first = value_of(report, 0, key);
	for (size_t i = 1; i < report->count; i++) {
		const char *other = value_of(report, i, key);
		if ((first == NULL) != (other == NULL) || (first != NULL && strcmp(first, other) != 0))
			return true;
	}
	return false;
}

static void setting_row(const struct html_report *report, const char *key, bool first)
{
	if (first)
		html_table(report, "setting");
	html_row_head(report, key[0] == '\0' ? "base store" : key);
	for (size_t k = 0; k < report->count; k++)
		if (key[0] == '\0')
			base_cell(report, k);
		else
			text_cell(value_of(report, k, key), report->file);
	fputs("</tr>\n", report->file);
}

/* Writes a row for each setting, or for each that differs, also the terrain. Returns the number of rows. */
static size_t setting_rows(const struct html_report *report, bool only_different)
{
	size_t count = only_different && differs(report, BASE) ? 1 : 0;
	if (count > 0)
		setting_row(report, BASE, true);
	for (size_t i = 0; i < report->count; i++) {
		const cJSON *value;
		size_t seen = 0;
		cJSON_ArrayForEach(value, html_members(&report->runs[i], "scene.values")) {
			bool before = false;
			if (seen++ == NAMES_MOST)
				break;
			for (size_t k = 0; k < i; k++)
				before = before || value_of(report, k, value->string) != NULL;
			if (before || (only_different && !differs(report, value->string)))
				continue;
			setting_row(report, value->string, count++ == 0);
		}
	}
	if (count > 0)
		html_table_end(report);
	for (size_t i = 0; i < report->count; i++)
		if (cJSON_GetArraySize(html_members(&report->runs[i], "scene.values")) > NAMES_MOST)
			html_sentence(report, &report->runs[i], "The table shows the first 20000 settings");
	return count;
}

static bool one_hash(const struct html_report *report)
{
	const char *first = html_string(&report->runs[0], "scene.hash");
	for (size_t i = 1; i < report->count; i++) {
		const char *other = html_string(&report->runs[i], "scene.hash");
		if (first == NULL || other == NULL || strcmp(first, other) != 0)
			return false;
	}
	return true;
}

/* Writes of each drive that began on ruts of earlier ones how deep these were: then drives of the same scene differ. */
static void began_on(const struct html_report *report)
{
	for (size_t i = 0; i < report->count; i++) {
		const struct html_run *run = &report->runs[i];
		const double deepest = html_number(run, "store.began_on.deepest"), highest = html_number(run, "store.began_on.highest");
		char text[240], heaps[80] = "";
		if (!isfinite(deepest))
			continue;
		if (highest > 0)
			snprintf(heaps, sizeof heaps, " and heaps up to %.3g mm high", 1e3 * highest);
		snprintf(text, sizeof text, "The drive began on ground that earlier drives had left, with ruts up to %.3g mm deep%s", 1e3 * deepest, heaps);
		html_sentence(report, run, text);
	}
}

void html_tables_differences(const struct html_report *report)
{
	if (report->count < 2)
		return;
	html_section(report, "differences", "Settings that differ");
	if (setting_rows(report, true) == 0)
		fputs(one_hash(report) ? "<p>No setting differs.</p>\n"
				       : "<p>No setting differs, but the hashes of the scenes differ. Either a file that a scene names differs, or run.json has no settings.</p>\n",
		      report->file);
	began_on(report);
	html_section_end(report);
}

void html_tables_settings(const struct html_report *report)
{
	html_section(report, "settings", "All settings");
	fputs("<details><summary>Every setting of the scene, with those of --set</summary>\n", report->file);
	if (setting_rows(report, false) == 0)
		fputs("<p>run.json has no settings of the scene: an older furrow made it.</p>\n", report->file);
	fputs("</details>\n", report->file);
	html_section_end(report);
}

/* --- soils --- */

/* Returns true if the same soil, with the same numbers, comes earlier. */
static bool soil_before(const struct html_report *report, size_t run, size_t soil)
{
	for (size_t i = 0; i <= run; i++) {
		const cJSON *other;
		size_t k = 0;
		cJSON_ArrayForEach(other, html_at(&report->runs[i], "soils")) {
			if (i == run && k >= soil)
				break;
			if (cJSON_Compare(other, cJSON_GetArrayItem(html_at(&report->runs[run], "soils"), (int)soil), true))
				return true;
			k++;
		}
	}
	return false;
}

/* Calls `tell` for each soil that differs from all earlier ones. Returns their number. */
static size_t each_soil(const struct html_report *report, void (*tell)(const struct html_report *report, const cJSON *soil, const char *key), const char *key)
{
	size_t count = 0;
	for (size_t i = 0; i < report->count; i++) {
		const cJSON *soil;
		size_t k = 0;
		cJSON_ArrayForEach(soil, html_at(&report->runs[i], "soils")) {
			if (!soil_before(report, i, k++)) {
				tell(report, soil, key);
				count++;
			}
		}
	}
	return count;
}

static void soil_title(const struct html_report *report, const cJSON *soil, const char *key)
{
	const char *name = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(soil, "name"));
	fputs("<th scope=\"col\">", report->file);
	svg_text(name != NULL ? name : "unnamed", report->file);
	/* If not all folders have this soil, names those that have it. */
	size_t having = 0;
	for (size_t i = 0; i < report->count; i++) {
		const cJSON *other;
		cJSON_ArrayForEach(other, html_at(&report->runs[i], "soils")) {
			having += cJSON_Compare(other, soil, true) ? 1 : 0;
		}
	}
	for (size_t i = 0; i < report->count && having < report->count; i++) {
		const cJSON *other;
		cJSON_ArrayForEach(other, html_at(&report->runs[i], "soils")) {
			if (!cJSON_Compare(other, soil, true))
				continue;
			fputs("<br/><small>", report->file);
			svg_text(report->runs[i].folder, report->file);
			fputs("</small>", report->file);
		}
	}
	fputs("</th>", report->file);
}

static void soil_number(const struct html_report *report, const cJSON *soil, const char *key)
{
	const cJSON *value = cJSON_GetObjectItemCaseSensitive(soil, key);
	/* A soil that lies below is told by its name. */
	value_cell(cJSON_IsObject(value) ? cJSON_GetObjectItemCaseSensitive(value, "name") : value, 1, report->file);
}

/* Writes a row for each number of this soil that no earlier soil has. */
static void soil_keys(const struct html_report *report, const cJSON *soil, const char *unused)
{
	const cJSON *number;
	cJSON_ArrayForEach(number, soil) {
		char setting[160], label[200];
		struct scene_parameter parameter;
		bool before = false;
		if (number->string == NULL || strcmp(number->string, "name") == 0 || !is_told(number))
			continue;
		for (size_t i = 0; i < report->count && !before; i++) { /* in the order of the soils, until this one */
			const cJSON *other;
			bool here = false;
			cJSON_ArrayForEach(other, html_at(&report->runs[i], "soils")) {
				here = here || other == soil;
				before = before || (!here && is_told(cJSON_GetObjectItemCaseSensitive(other, number->string)));
			}
			if (here)
				break;
		}
		if (before)
			continue;
		snprintf(setting, sizeof setting, "soil.%.100s", number->string);
		const bool known = scene_parameter(setting, &parameter) && parameter.unit != NULL;
		snprintf(label, sizeof label, "%.100s%s%.60s", number->string, known ? ", " : "", known ? parameter.unit : "");
		html_row_head(report, label);
		each_soil(report, soil_number, number->string);
		fputs("</tr>\n", report->file);
	}
}

static void count_soil(const struct html_report *report, const cJSON *soil, const char *key)
{
}

void html_tables_soils(const struct html_report *report)
{
	html_section(report, "soils", "Soils");
	if (each_soil(report, count_soil, NULL) == 0) {
		fputs("<p>No soil: the drive's model uses none.</p>\n", report->file);
	} else {
		fputs("<div class=\"scroll\"><table><thead><tr><th scope=\"col\">number</th>", report->file);
		each_soil(report, soil_title, NULL);
		fputs("</tr></thead><tbody>\n", report->file);
		each_soil(report, soil_keys, NULL);
		html_table_end(report);
	}
	html_section_end(report);
}

/* --- results --- */

/* A table of all objects or vehicles: a row for each name and figure. */
static void named_rows(const struct html_report *report, const char *list, const struct row *figures, size_t count)
{
	for (size_t i = 0; i < report->count; i++) {
		const cJSON *named;
		size_t seen = 0;
		cJSON_ArrayForEach(named, html_members(&report->runs[i], list)) {
			bool before = false;
			if (seen++ == NAMES_MOST)
				break;
			for (size_t k = 0; k < i; k++)
				before = before || cJSON_GetObjectItemCaseSensitive(html_members(&report->runs[k], list), named->string) != NULL;
			for (size_t f = 0; f < count && !before; f++) {
				char label[200];
				bool any = false;
				for (size_t k = 0; k < report->count; k++)
					any = any || is_told(cJSON_GetObjectItemCaseSensitive(
							     cJSON_GetObjectItemCaseSensitive(html_members(&report->runs[k], list), named->string), figures[f].path));
				if (!any)
					continue;
				snprintf(label, sizeof label, "%.120s: %s", named->string, figures[f].name);
				html_row_head(report, label);
				for (size_t k = 0; k < report->count; k++)
					value_cell(cJSON_GetObjectItemCaseSensitive(
							   cJSON_GetObjectItemCaseSensitive(html_members(&report->runs[k], list), named->string), figures[f].path),
						   figures[f].unit, report->file);
				fputs("</tr>\n", report->file);
			}
		}
	}
}

void html_tables_results(const struct html_report *report)
{
	static const struct row objects[] = {{"distance, m", "distance", 1}, {"sinkage, mm", "sinkage", 1e-3}, {"load, N", "load", 1}, {"slip", "slip", 1},
					     {"path samples without ground", "skipped", 1}};
	static const struct row vehicles[] = {{"mass, kg", "mass", 1}, {"distance, m", "distance", 1}, {"work, J", "work", 1}, {"kinetic energy, J", "kinetic", 1},
					      {"settled after, s", "settled_after", 1}, {"arrived", "arrived", 1}, {"stuck since, s", "stuck_since", 1}};
	static const struct row run[] = {
		{"wall clock, s", "seconds", 1}, {"simulated time / wall clock", "rtf", 1}, {"start-up, s", "warm_up.seconds", 1},
		{"cache slots", "cache.slots", 1}, {"tiles touched", "cache.touched", 1}, {"hits", "cache.hits", 1}, {"misses", "cache.misses", 1},
		{"prefetched", "cache.prefetched", 1}, {"late", "cache.late", 1}, {"evictions", "cache.evictions", 1},
		{"written back", "cache.writebacks", 1}, {"stalls", "cache.stalls", 1}, {"time in stalls, ms", "cache.stall_ms", 1},
		{"peak memory, MB", "memory.rss_peak", 1e6}, {"GPU memory, MB", "memory.gpu_bytes", 1e6}, {"read, MB", "io.bytes_read", 1e6},
		{"written, MB", "io.bytes_written", 1e6}, {"commits", "io.commits", 1}, {"pictures", "view.images", 1}, {"ranks", "ranks.count", 1},
		{"tiles moved between ranks", "ranks.tiles_moved", 1}, {"moved between ranks, MB", "ranks.bytes_moved", 1e6},
		{"balance of ranks", "ranks.balance", 1}, {"GL renderer", "gl.renderer", 1}, {"GL vendor", "gl.vendor", 1},
		{"GL version", "gl.version", 1}, {"software GL", "gl.software", 1},
	};
	html_section(report, "results", "Results");
	html_means_write(report);
	html_table(report, "the whole drive");
	named_rows(report, "objects", objects, sizeof objects / sizeof *objects);
	named_rows(report, "vehicles", vehicles, sizeof vehicles / sizeof *vehicles);
	html_table_end(report);
	html_table(report, "the computation");
	ROWS(report, run);
	html_table_end(report);
	html_section_end(report);
}

/* A model that reads soils conserves volume. */
static bool has_soils(const struct html_run *run)
{
	return cJSON_GetArraySize(html_at(run, "soils")) > 0;
}

/* Returns what bodies of a run carry, fixed-point units; 0: none may carry soil. */
static double carried(const struct html_run *run)
{
	const double units = html_number(run, "volume.quanta.carried");
	return units > 0 ? units : 0;
}

static double in_flight(const struct html_run *run)
{
	const double units = html_number(run, "volume.quanta.in_flight");
	return units > 0 ? units : 0;
}

/* 0 to the unit where volume is conserved. A run of an older furrow has no added soil. */
static double balance(const struct html_run *run)
{
	const double added = html_number(run, "volume.quanta.added");
	return html_number(run, "volume.quanta.net") + html_number(run, "volume.quanta.compacted") + carried(run) + in_flight(run) - (isnan(added) ? 0 : added);
}

static bool throws(const struct html_report *report)
{
	bool any = false;
	for (size_t i = 0; i < report->count; i++)
		any = any || html_at(&report->runs[i], "thrown") != NULL;
	return any;
}

void html_tables_volume(const struct html_report *report)
{
	static const struct row list[] = {
		{"removed, m3", "volume.removed", 1}, {"raised, m3", "volume.raised", 1}, {"net (raised - removed), m3", "volume.net", 1},
		{"compacted, m3", "volume.compacted", 1}, {"added, m3", "volume.added", 1}, {"removed, fixed-point units", "volume.quanta.removed", 1}, {"raised, fixed-point units", "volume.quanta.raised", 1},
		{"net, fixed-point units", "volume.quanta.net", 1}, {"compacted, fixed-point units", "volume.quanta.compacted", 1},
		{"added, fixed-point units", "volume.quanta.added", 1},
	};
	static const struct row aboard[] = {{"carried by bodies, m3", "volume.carried", 1}, {"carried by bodies, fixed-point units", "volume.quanta.carried", 1}};
	static const struct row thrown[] = {
		{"thrown, kg", "thrown.mass", 1}, {"of that in flight, kg", "thrown.in_flight_mass", 1}, {"thrown, fixed-point units", "thrown.quanta.thrown", 1},
		{"landed, fixed-point units", "thrown.quanta.landed", 1}, {"in flight, fixed-point units", "thrown.quanta.in_flight", 1}, {"lost, fixed-point units", "thrown.quanta.lost", 1},
	};
	static const char *const heads[] = {
		"net + compacted - added, fixed-point units", "net + compacted + carried - added, fixed-point units",
		"net + compacted + in flight - added, fixed-point units", "net + compacted + carried + in flight - added, fixed-point units",
	};
	bool carries = false;
	for (size_t i = 0; i < report->count; i++)
		carries = carries || html_at(&report->runs[i], "volume.carried") != NULL;
	html_section(report, "volume", "Volume balance");
	html_volume_plot(report);
	html_table(report, "");
	ROWS(report, list);
	if (carries)
		ROWS(report, aboard);
	if (throws(report))
		ROWS(report, thrown);
	bool conserves = false;
	for (size_t i = 0; i < report->count; i++)
		conserves = conserves || has_soils(&report->runs[i]);
	if (conserves)
		html_row_head(report, heads[carries + 2 * throws(report)]);
	for (size_t i = 0; i < report->count && conserves; i++)
		html_number_cell(has_soils(&report->runs[i]) ? balance(&report->runs[i]) : (double)NAN, 1, report->file);
	if (conserves)
		fputs("</tr>\n", report->file);
	html_table_end(report);
	fputs("<p class=\"small\">A fixed-point unit is 2<sup>-20</sup> m of height at one post. If the model conserves volume, net + compacted - added is 0.</p>\n", report->file);
	html_section_end(report);
}

/* --- notes --- */

static void counted(const struct html_report *report, const struct html_run *run, const char *path, const char *what)
{
	char text[300];
	const double count = html_number(run, path);
	if (!(count > 0))
		return;
	snprintf(text, sizeof text, "%.0f %s", count, what);
	html_sentence(report, run, text);
}

/* What was wrong with how vehicles lay. */
static void lies_of(const struct html_report *report, const struct html_run *run)
{
	const cJSON *vehicle, *lie;
	cJSON_ArrayForEach(vehicle, html_members(run, "vehicles")) {
		cJSON_ArrayForEach(lie, cJSON_GetObjectItemCaseSensitive(vehicle, "lies")) {
			static const char *const words[][2] = {{"overturned", "lay on its side or roof"}, {"high_centred", "bore most of the weight: the vehicle hung on it"},
							       {"buried", "was deeper in the soil than the soil bears"}, {"under_ground", "was under the ground"}};
			const char *what = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(lie, "what")), *geom = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(lie, "geom"));
			const cJSON *time = cJSON_GetObjectItemCaseSensitive(lie, "time"), *depth = cJSON_GetObjectItemCaseSensitive(lie, "depth");
			const cJSON *at = cJSON_GetObjectItemCaseSensitive(lie, "at"), *x = cJSON_GetArrayItem(at, 0), *y = cJSON_GetArrayItem(at, 1);
			char text[400], deep[48] = "";
			for (size_t i = 0; i < sizeof words / sizeof *words && what != NULL; i++)
				what = strcmp(what, words[i][0]) == 0 ? words[i][1] : what;
			if (cJSON_IsNumber(depth))
				snprintf(deep, sizeof deep, ", up to %.3g m deep", depth->valuedouble);
			if (what == NULL || !cJSON_IsNumber(time) || !cJSON_IsNumber(x) || !cJSON_IsNumber(y))
				continue;
			snprintf(text, sizeof text, "%.120s %.60s from t = %.4g s on, at %.6g, %.6g m%s", geom != NULL ? geom : vehicle->string, what, time->valuedouble,
				 x->valuedouble, y->valuedouble, deep);
			html_sentence(report, run, text);
		}
	}
}

static void notes_of(const struct html_report *report, const struct html_run *run)
{
	const char *ended = html_string(run, "ended");
	const cJSON *note, *object;
	if (ended != NULL && strcmp(ended, "complete") != 0) {
		char text[300];
		snprintf(text, sizeof text, "The drive did not complete. It ended as: %.100s", ended);
		html_sentence(report, run, text);
	}
	if (isfinite(html_number(run, "resumed_from")))
		html_sentence(report, run, "The drive was resumed (--resume). Times, cache, memory and files are those of the last part");
	cJSON_ArrayForEach(note, html_at(run, "notes")) {
		if (cJSON_IsString(note))
			html_sentence(report, run, note->valuestring);
	}
	lies_of(report, run);
	counted(report, run, "refused_posts", "times a post would have been pressed deeper than an offset holds");
	counted(report, run, "forces.sunk", "times the soil did not carry an object's load");
	counted(report, run, "forces.slides", "times a loaded object stood where the soil cannot hold it");
	counted(report, run, "forces.saturated", "times a post bore more than can be summed");
	cJSON_ArrayForEach(object, html_members(run, "objects")) {
		const cJSON *skipped = cJSON_GetObjectItemCaseSensitive(object, "skipped");
		char text[300];
		if (!cJSON_IsNumber(skipped) || !(skipped->valuedouble > 0))
			continue;
		snprintf(text, sizeof text, "%.0f path samples of %.120s had no ground", skipped->valuedouble, object->string);
		html_sentence(report, run, text);
	}
}

void html_tables_notes(const struct html_report *report)
{
	html_section(report, "notes", "Notes");
	const long before = ftell(report->file);
	if (report->count == 1)
		began_on(report);
	for (size_t i = 0; i < report->count; i++)
		notes_of(report, &report->runs[i]);
	if (ftell(report->file) == before)
		fputs("<p>None.</p>\n", report->file);
	html_section_end(report);
}
