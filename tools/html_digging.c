/*
 * Digging, of each body that carries soil: what is aboard, how hard it cuts, the energy of digging for each m3 that it brought, and its cycles.
 *
 *     cutting force = the soil's force on the body, without the weight of what is aboard: (fx, fy, fz + carried_weight)
 *     it digs       where its work on the soil grows from one row to the next
 *     energy        of a cycle: its work on the soil from the low before to where it begins to hold its load (html_digging.h), so without dumping
 *     fill          volume aboard / struck capacity (run.json: `capacity`, of the body's shape at level attitude)
 *     mass          weight aboard / gravity
 */
#include "html_digging.h"

#include <math.h>
#include <string.h>

#include "command.h"
#include "html_report.h"
#include "html_row.h"
#include "svg.h"

enum { LINES = HTML_RUNS * HTML_COLOURS, CYCLES = 100 };

/* --- rows --- */

enum status html_digging_take(struct html_body *body, const struct html_row *row)
{
	const size_t at = body->count;
	if (at == 0 && isfinite(row->carried) && (body->digging = mem_calloc(1, sizeof *body->digging)) == NULL)
		return fail_memory("the rows of a drive");
	struct html_digging *digging = body->digging;
	if (digging == NULL)
		return STATUS_OK;
	if (at >= digging->room) {
		const size_t room = mem_room(digging->room, at + 1);
		for (int k = 0; k < DIG_VALUES; k++)
			TRY(mem_resize(&digging->values[k], room, sizeof(double), "the rows of a drive"));
		digging->room = room;
	}
	const double weight = isfinite(row->weight) ? row->weight : 0, level = hypot(row->force[0], row->force[1]);
	digging->values[DIG_VOLUME][at] = isfinite(row->carried) ? row->carried : 0;
	digging->values[DIG_WEIGHT][at] = weight;
	digging->values[DIG_LEVEL][at] = level;
	digging->values[DIG_FORCE][at] = hypot(level, row->force[2] + weight);
	digging->values[DIG_WORK][at] = row->work;
	return STATUS_OK;
}

void html_digging_finish(struct html_digging *digging)
{
	if (digging == NULL)
		return;
	for (int k = 0; k < DIG_VALUES; k++)
		mem_free(digging->values[k]);
	mem_free(digging);
}

/* --- bodies that are shown --- */

struct shown {
	const struct html_run *run;
	const struct html_body *body;
	struct html_line line;      /* its colour and dash */
	double capacity, gravity;   /* m3, m/s2; NaN: not known */
	struct html_cycle cycles[CYCLES];
	size_t count;               /* of all its cycles */
	/* Of the whole drive: */
	double brought, spent;      /* m3, J of the cycles */
	double most;                /* m3 */
	double mean[2], peak[2];    /* N: of DIG_LEVEL and DIG_FORCE, while it digs; the largest */
	double seconds, lifted;     /* it digs; J: what lifts the load */
};

static const cJSON *member(const cJSON *of, const char *name)
{
	return cJSON_GetObjectItemCaseSensitive(of, name);
}

static double number(const cJSON *value)
{
	return cJSON_IsNumber(value) && isfinite(value->valuedouble) ? value->valuedouble : (double)NAN;
}

/* Finds capacity and gravity of a body: of an object with a path, or of a vehicle's soil geom. Returns false if run.json has no soil aboard of it. */
static bool find_facts(struct shown *shown)
{
	const char *name = shown->body->name;
	const cJSON *vehicle, *told = member(member(html_members(shown->run, "objects"), name), "carried");
	shown->gravity = number(member(told, "gravity"));
	cJSON_ArrayForEach(vehicle, html_members(shown->run, "vehicles")) {
		if (vehicle->string == NULL || !html_is_part(name, vehicle->string))
			continue;
		shown->gravity = number(member(vehicle, "gravity"));
		told = member(member(member(vehicle, "carried"), "geoms"), name);
	}
	shown->capacity = number(member(told, "capacity"));
	if (!(shown->gravity > 0))
		shown->gravity = (double)NAN;
	if (!(shown->capacity > 0))
		shown->capacity = (double)NAN;
	return told != NULL;
}

/* Whether it digs between the row before and this one. */
static bool digs(const struct html_digging *digging, size_t i)
{
	const double *work = digging->values[DIG_WORK];
	return isfinite(work[i]) ? i > 0 && work[i] > work[i - 1] && digging->values[DIG_FORCE][i] > 0 : digging->values[DIG_FORCE][i] > 0;
}

static double spent_in(const struct shown *shown, const struct html_cycle *cycle)
{
	const double *work = shown->body->digging->values[DIG_WORK];
	return work[cycle->holds] - work[cycle->low];
}

static double brought_in(const struct shown *shown, const struct html_cycle *cycle)
{
	const double *volume = shown->body->digging->values[DIG_VOLUME];
	return volume[cycle->held] - volume[cycle->low];
}

static enum status find_sums(struct shown *shown)
{
	const struct html_body *body = shown->body;
	const struct html_digging *digging = body->digging;
	size_t rows = 0;
	shown->peak[0] = shown->peak[1] = shown->mean[0] = shown->mean[1] = (double)NAN;
	for (size_t i = 0; i < body->count; i++) {
		const bool counts = digs(digging, i);
		shown->most = fmax(shown->most, digging->values[DIG_VOLUME][i]);
		shown->seconds += counts && i > 0 ? body->time[i] - body->time[i - 1] : 0;
		for (int k = 0; k < 2; k++) {
			const double force = digging->values[k == 0 ? DIG_LEVEL : DIG_FORCE][i];
			shown->peak[k] = fmax(shown->peak[k], force);
			if (counts)
				shown->mean[k] = (rows > 0 ? shown->mean[k] : 0) + force;
		}
		rows += counts;
	}
	for (int k = 0; k < 2; k++)
		shown->mean[k] /= (double)rows;
	TRY(html_digging_cycles(body, shown->cycles, CYCLES, &shown->count));
	for (size_t i = 0; i < shown->count && i < CYCLES; i++) {
		shown->brought += brought_in(shown, &shown->cycles[i]);
		shown->spent += spent_in(shown, &shown->cycles[i]);
	}
	return STATUS_OK;
}

/* Lists the bodies that carry, of a drive as many as its plots show. *more: how many these are; *left: how many are left out. */
static enum status take(const struct html_report *report, size_t run, struct shown *list, size_t *more, size_t *left)
{
	const struct html_bodies *bodies = &report->runs[run].objects;
	size_t count = 0;
	*left = 0;
	for (size_t k = 0; k < bodies->count; k++) {
		struct shown found = {.run = &report->runs[run], .body = &bodies->list[k], .line = html_line_of(report, run, count)};
		if (found.body->digging == NULL || found.body->count == 0 || !find_facts(&found))
			continue;
		if (count == html_bodies_most(report)) {
			++*left;
			continue;
		}
		TRY(find_sums(&found));
		list[count++] = found;
	}
	*more = count;
	return STATUS_OK;
}

/* --- plots --- */

struct value {
	enum html_dig value;
	double by;   /* that it is multiplied by; 0: of the body, mass or fill */
	const char *name, *up;
};

static double scale_of(const struct shown *shown, const struct value *value)
{
	return value->by > 0 ? value->by : 1 / (value->value == DIG_WEIGHT ? shown->gravity : shown->capacity);
}

static enum status write_value(const struct html_report *report, const struct shown *list, size_t count, const struct value *value)
{
	struct html_line lines[LINES];
	double *made[LINES] = {NULL};
	char title[100];
	size_t drawn = 0;
	enum status status = STATUS_OK;
	for (size_t i = 0; i < count; i++) {
		const struct html_body *body = list[i].body;
		TRY_OR(done, mem_make(&made[drawn], body->count, sizeof **made, "a plot"));
		for (size_t k = 0; k < body->count; k++)
			made[drawn][k] = body->digging->values[value->value][k] * scale_of(&list[i], value);
		struct html_line line = list[i].line;
		line.count = body->count;
		line.x = body->time;
		line.y = made[drawn];
		if (html_line_any(&line))
			lines[drawn++] = line;
		else
			mem_free(made[drawn]);
	}
	snprintf(title, sizeof title, "%s over time", value->name);
	const struct html_plot plot = {.title = title, .across = "time, s", .up = value->up, .lines = lines, .count = drawn, .zero = true, .upright = (double)NAN};
	if (drawn > 0)
		html_plot_write(&plot, report->file);
done:
	for (size_t i = 0; i < drawn; i++)
		mem_free(made[i]);
	return status;
}

/* --- tables --- */

static void number_cell(double value, FILE *file)
{
	if (isfinite(value))
		fprintf(file, "<td class=\"number\"><data value=\"%.17g\">%.4g</data></td>", value, value == 0 ? 0 : value);
	else
		fputs("<td class=\"none\">&#8211;</td>", file);
}

static void name_of(const struct html_report *report, const struct shown *shown)
{
	if (report->count > 1) {
		svg_text(shown->run->folder, report->file);
		fputs(": ", report->file);
	}
	svg_text(shown->body->name, report->file);
}

enum figure {
	CAPACITY, MOST, MOST_MASS, MOST_FILL, BROUGHT, ABOARD, LEVEL_PEAK, LEVEL_MEAN, FORCE_PEAK, FORCE_MEAN, SECONDS, ENERGY, ENERGY_A_VOLUME, FIGURES
};

static double figure(const struct shown *shown, enum figure which)
{
	const struct html_digging *digging = shown->body->digging;
	const size_t last = shown->body->count - 1;
	double most = 0;
	switch (which) {
	case CAPACITY:
		return shown->capacity;
	case MOST:
		return shown->most;
	case MOST_MASS:
		for (size_t i = 0; i <= last; i++)
			most = fmax(most, digging->values[DIG_WEIGHT][i]);
		return most / shown->gravity;
	case MOST_FILL:
		return shown->most / shown->capacity;
	case BROUGHT:
		return shown->brought;
	case ABOARD:
		return digging->values[DIG_VOLUME][last];
	case LEVEL_PEAK:
		return shown->peak[0];
	case LEVEL_MEAN:
		return shown->mean[0];
	case FORCE_PEAK:
		return shown->peak[1];
	case FORCE_MEAN:
		return shown->mean[1];
	case SECONDS:
		return shown->seconds;
	case ENERGY:
		return shown->spent;
	case ENERGY_A_VOLUME:
		return shown->brought > 0 ? shown->spent / shown->brought : (double)NAN;
	default:
		return (double)NAN;
	}
}

static void write_figures(const struct html_report *report, const struct shown *list, size_t count)
{
	static const char *const names[FIGURES] = {
		[CAPACITY] = "struck capacity, m3", [MOST] = "most that was aboard, m3", [MOST_MASS] = "most that was aboard, kg", [MOST_FILL] = "largest fill, share of the struck capacity",
		[BROUGHT] = "brought in all cycles, m3", [ABOARD] = "aboard at the end, m3", [LEVEL_PEAK] = "horizontal cutting force: largest, N",
		[LEVEL_MEAN] = "horizontal cutting force: mean while it digs, N", [FORCE_PEAK] = "whole cutting force: largest, N", [FORCE_MEAN] = "whole cutting force: mean while it digs, N",
		[SECONDS] = "time in which it digs, s", [ENERGY] = "energy of digging, J", [ENERGY_A_VOLUME] = "energy of digging for each m3 that it brought, J/m3",
	};
	FILE *file = report->file;
	fputs("<div class=\"scroll\"><table><thead><tr><th scope=\"col\">of the whole drive</th>", file);
	for (size_t i = 0; i < count; i++) {
		fputs("<th scope=\"col\">", file);
		name_of(report, &list[i]);
		fputs("</th>", file);
	}
	fputs("</tr></thead><tbody>\n", file);
	for (int k = 0; k < FIGURES; k++) {
		bool any = false;
		for (size_t i = 0; i < count; i++)
			any = any || isfinite(figure(&list[i], (enum figure)k));
		if (!any)
			continue;
		html_row_head(report, names[k]);
		for (size_t i = 0; i < count; i++)
			number_cell(figure(&list[i], (enum figure)k), file);
		fputs("</tr>\n", file);
	}
	html_table_end(report);
}

static void place_cell(const struct html_body *body, size_t row, bool known, FILE *file)
{
	if (known)
		fprintf(file, "<td class=\"number\">%.2f, %.2f</td>", body->x[row], body->y[row]);
	else
		fputs("<td class=\"none\">&#8211;</td>", file);
}

static void write_cycle(const struct html_report *report, const struct shown *shown, size_t number_of)
{
	const struct html_body *body = shown->body;
	const struct html_cycle *cycle = &shown->cycles[number_of];
	const double *volume = body->digging->values[DIG_VOLUME], *weight = body->digging->values[DIG_WEIGHT];
	const double brought = brought_in(shown, cycle), none = (double)NAN;
	FILE *file = report->file;
	fputs("<tr><th scope=\"row\">", file);
	name_of(report, shown);
	fprintf(file, ", %zu</th>", number_of + 1);
	number_cell(body->time[cycle->fills], file);
	number_cell(body->time[cycle->holds], file);
	place_cell(body, cycle->half, true, file);
	number_cell(brought, file);
	number_cell((weight[cycle->held] - weight[cycle->low]) / shown->gravity, file);
	number_cell(volume[cycle->held] / shown->capacity, file);
	number_cell(spent_in(shown, cycle), file);
	number_cell(brought > 0 ? spent_in(shown, cycle) / brought : none, file);
	number_cell(body->time[cycle->dumps] - body->time[cycle->holds], file);
	number_cell(body->way[cycle->dumps] - body->way[cycle->holds], file);
	number_cell(cycle->dumped ? body->time[cycle->dumps] : none, file);
	number_cell(cycle->dumped ? body->time[cycle->emptied] : none, file);
	place_cell(body, cycle->fallen, cycle->dumped, file);
	number_cell(cycle->dumped ? volume[cycle->held] - volume[cycle->end] : none, file);
	fputs("</tr>\n", file);
}

static void write_cycles(const struct html_report *report, const struct shown *list, size_t count)
{
	static const char *const heads[] = {
		"cycle", "fills from, s", "to, s", "at x, y, m", "brought, m3", "brought, kg", "fill, share of 1", "energy of digging, J", "energy, J/m3", "held for, s", "over, m",
		"dumped from, s", "to, s", "at x, y, m", "dumped, m3",
	};
	size_t any = 0;
	for (size_t i = 0; i < count; i++)
		any += list[i].count;
	if (any == 0) {
		html_sentence(report, NULL, "No cycles: nothing was aboard in any row");
		return;
	}
	fputs("<div class=\"scroll\"><table><thead><tr>", report->file);
	for (size_t k = 0; k < sizeof heads / sizeof *heads; k++)
		fprintf(report->file, "<th scope=\"col\">%s</th>", heads[k]);
	fputs("</tr></thead><tbody>\n", report->file);
	for (size_t i = 0; i < count; i++)
		for (size_t k = 0; k < list[i].count && k < CYCLES; k++)
			write_cycle(report, &list[i], k);
	html_table_end(report);
	for (size_t i = 0; i < count; i++)
		if (list[i].count > CYCLES) {
			char text[200];
			snprintf(text, sizeof text, "The table and the sums have the first %d of %zu cycles of %.80s", CYCLES, list[i].count, list[i].body->name);
			html_sentence(report, list[i].run, text);
		}
}

static void explain(const struct html_report *report, const struct shown *list, size_t count)
{
	bool works = true, holds = true;
	for (size_t i = 0; i < count; i++) {
		works = works && isfinite(list[i].spent);
		holds = holds && isfinite(list[i].capacity);
	}
	fputs("<p class=\"small\">The cutting force is the soil's force on the body without the weight of what is aboard. A body digs where its work on the soil grows from one row to the next. "
	      "In a cycle the volume aboard rises from a low to a peak and falls again; rises and falls of less than a tenth of the most aboard are part of what they interrupt. Behind the peak "
	      "it holds its load where the volume stays within a twentieth for the longest time. What it holds then is what it brought; the rest was spilled. It is dumped while 99 to 1 % of that is aboard. The "
	      "places are where half of it was. The energy of digging is the body's work on the soil from the low before to where it begins to hold. It does not have what lifts the load.</p>\n", report->file);
	if (holds)
		fputs("<p class=\"small\">The struck capacity is the volume between the body's upper envelope and a straightedge that rests on it, along and across, at level attitude. A heap makes the fill larger than 1.</p>\n", report->file);
	else
		html_sentence(report, NULL, "No fill where there is no struck capacity: nothing of such a body, as of a plate or a blade, stands up around a hollow, or run.json does not tell it");
	if (!works)
		html_sentence(report, NULL, "No energy of digging for a body whose work the rows do not tell");
}

/* --- the section --- */

/* Whether something of a drive carries, whatever its rows tell. */
static bool carries(const struct html_run *run)
{
	return html_at(run, "volume.carried") != NULL;
}

static enum status write_shown(const struct html_report *report, const struct shown *list, size_t count)
{
	static const struct value values[] = {
		{DIG_WEIGHT, 0, "carried mass", "carried mass, kg"}, {DIG_VOLUME, 0, "bucket fill", "bucket fill, share of the struck capacity"},
		{DIG_LEVEL, 1, "horizontal cutting force", "horizontal cutting force, N"}, {DIG_FORCE, 1, "whole cutting force", "whole cutting force, N"},
		{DIG_WORK, 1e-3, "work on the soil", "work on the soil, kJ"},
	};
	html_legend_begin(report);
	for (size_t i = 0; i < count; i++)
		html_legend_line(report, &list[i].line, list[i].run->folder, list[i].body->name);
	html_legend_end(report);
	fputs("<div class=\"plots\">\n", report->file);
	for (size_t k = 0; k < sizeof values / sizeof *values; k++)
		TRY(write_value(report, list, count, &values[k]));
	fputs("</div>\n", report->file);
	write_figures(report, list, count);
	write_cycles(report, list, count);
	explain(report, list, count);
	return STATUS_OK;
}

enum status html_digging_write(const struct html_report *report)
{
	struct shown *list;
	size_t count = 0;
	bool any = false;
	enum status status = STATUS_OK;
	for (size_t i = 0; i < report->count; i++)
		any = any || carries(&report->runs[i]);
	if (!any)
		return STATUS_OK;
	TRY(mem_make(&list, LINES, sizeof *list, "digging"));
	html_section(report, "digging", "Digging");
	for (size_t i = 0; i < report->count; i++) {
		size_t more, left;
		TRY_OR(done, take(report, i, list + count, &more, &left));
		count += more;
		if (left > 0) {
			char text[200];
			snprintf(text, sizeof text, "This section shows the first %zu of %zu bodies that carry", more, more + left);
			html_sentence(report, &report->runs[i], text);
		}
		if (carries(&report->runs[i]) && more == 0)
			html_sentence(report, &report->runs[i], "No digging: objects.csv has no rows of what is aboard; set output.forces in the scene");
	}
	if (count > 0)
		TRY_OR(done, write_shown(report, list, count));
done:
	mem_free(list);
	html_section_end(report);
	return status;
}
