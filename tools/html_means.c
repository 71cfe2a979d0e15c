/* The table of means over the last quarter of a drive's time: each vehicle, then each object of objects.csv. */
#include <math.h>
#include <string.h>

#include "html_report.h"

#define PART 0.75   /* of the time, from which rows count */
#define OBJECTS 100 /* of a drive that the table shows */

struct figure {
	enum html_value value;
	const char *name, *unit; /* "slip", ", mm" */
	double scale;            /* a value of a row in the unit that is shown, times this, is in the base unit */
	bool force;              /* of a vehicle: the sum over its wheels, not their mean */
};

static double ends_at(const struct html_run *run)
{
	double end = NAN;
	for (size_t i = 0; i < run->objects.count; i++) {
		const struct html_body *body = &run->objects.list[i];
		end = body->count > 0 ? fmax(end, body->time[body->count - 1]) : end;
	}
	return end;
}

static double mean_of(const struct html_body *body, double from, enum html_value value)
{
	double sum = 0, count = 0;
	for (size_t i = body->count; i-- > 0 && body->time[i] >= from * (1 - 1e-9);)
		if (isfinite(body->values[value][i])) {
			sum += body->values[value][i];
			count++;
		}
	return count > 0 ? sum / count : (double)NAN;
}

/* Returns the figure of an object, or of a vehicle's wheels together. NaN: not known. */
static double find(const struct html_run *run, const char *name, bool vehicle, const struct figure *figure)
{
	const double from = PART * ends_at(run);
	double sum = 0, count = 0;
	for (size_t i = 0; i < run->objects.count; i++) {
		const struct html_body *body = &run->objects.list[i];
		if (!(vehicle ? html_is_part(body->name, name) : strcmp(body->name, name) == 0))
			continue;
		const double mean = mean_of(body, from, figure->value);
		if (isnan(mean) && !figure->force)
			continue;
		sum += mean;
		count++;
	}
	return count == 0 ? (double)NAN : figure->scale * (vehicle && !figure->force ? sum / count : sum);
}

/* --- energy in that time --- */

/* Work in the last quarter, kJ, and what went with it. */
struct spent {
	double seconds, way;  /* s, m in plan */
	double work;          /* of a vehicle's actuators */
	double soil, traction; /* of its wheels, or of the object: into the soil; of the soil's force along the way */
};

/* Returns the first row of the body that counts; its count if there are not two. */
static size_t first_row(const struct html_body *body, double from)
{
	size_t first = body->count;
	while (first > 0 && body->time[first - 1] >= from * (1 - 1e-9))
		first--;
	return first + 1 < body->count ? first : body->count;
}

static void add_object(struct spent *spent, const struct html_body *body, double from)
{
	const size_t first = first_row(body, from);
	if (first == body->count)
		return;
	spent->soil += body->values[HTML_ENERGY][body->count - 1] - body->values[HTML_ENERGY][first];
	spent->traction += body->values[HTML_PUSH][body->count - 1] - body->values[HTML_PUSH][first];
	spent->seconds = body->time[body->count - 1] - body->time[first];
	spent->way = body->way[body->count - 1] - body->way[first];
}

static struct spent spent_by(const struct html_run *run, const char *name, bool vehicle)
{
	const double from = PART * ends_at(run);
	struct spent spent = {.work = NAN};
	for (size_t i = 0; i < run->objects.count; i++)
		if (vehicle ? html_is_part(run->objects.list[i].name, name) : strcmp(run->objects.list[i].name, name) == 0)
			add_object(&spent, &run->objects.list[i], from);
	for (size_t i = 0; i < run->vehicles.count && vehicle; i++) {
		const struct html_body *body = &run->vehicles.list[i];
		const size_t first = first_row(body, from);
		if (strcmp(body->name, name) != 0 || first == body->count)
			continue;
		spent.seconds = body->time[body->count - 1] - body->time[first];
		spent.way = body->way[body->count - 1] - body->way[first];
		spent.work = body->values[HTML_WORK][body->count - 1] - body->values[HTML_WORK][first];
	}
	return spent;
}

static double power(const struct spent *spent)
{
	return spent->seconds > 0 ? 1e3 * spent->work / spent->seconds : (double)NAN;
}

static double work_a_metre(const struct spent *spent)
{
	return spent->way > 0 ? 1e3 * spent->work / spent->way : (double)NAN;
}

static double soil_a_metre(const struct spent *spent)
{
	return spent->way > 0 ? 1e3 * spent->soil / spent->way : (double)NAN;
}

#define PULLS 0.01 /* of the axles' work: less is noise */

/* The axles' work is what went into the soil and what the soil's force did along the way. */
static double efficiency(const struct spent *spent)
{
	return spent->soil > 0 && spent->traction > PULLS * (spent->traction + spent->soil) ? spent->traction / (spent->traction + spent->soil) : (double)NAN;
}

static void write_energy(const struct html_report *report, const char *name, bool vehicle)
{
	static const struct {
		const char *name;
		double (*find)(const struct spent *);
	} rows[] = {
		{"mean power of its actuators, W", power},
		{"work of its actuators for each metre, J/m", work_a_metre},
		{"energy into the soil for each metre, J/m", soil_a_metre},
		{"tractive efficiency, share of 1", efficiency},
	};
	for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
		double found[HTML_RUNS];
		char label[200];
		bool any = false;
		for (size_t k = 0; k < report->count; k++) {
			const struct spent spent = spent_by(&report->runs[k], name, vehicle);
			found[k] = rows[r].find(&spent);
			any = any || isfinite(found[k]);
		}
		if (!any)
			continue;
		snprintf(label, sizeof label, "%.120s: %s", name, rows[r].name);
		html_row_head(report, label);
		for (size_t k = 0; k < report->count; k++)
			html_number_cell(found[k], 1, report->file);
		fputs("</tr>\n", report->file);
	}
}

/* --- the table --- */

static void write_rows(const struct html_report *report, const char *name, bool vehicle)
{
	static const struct figure figures[] = {
		{HTML_SLIP, "slip", "", 1, false},          {HTML_SINKAGE, "sinkage", ", mm", 1e-3, false}, {HTML_TRACTION, "traction", ", N", 1, true},
		{HTML_DRAWBAR, "drawbar pull", ", N", 1, true}, {HTML_TORQUE, "torque", ", N m", 1, true},  {HTML_VERTICAL, "vertical force", ", N", 1, true},
	};
	const bool slope = html_any_slope(report);
	for (size_t f = 0; f < sizeof figures / sizeof *figures; f++) {
		double found[HTML_RUNS];
		char label[200];
		bool any = false;
		for (size_t k = 0; k < report->count; k++) {
			found[k] = find(&report->runs[k], name, vehicle, &figures[f]);
			any = any || isfinite(found[k]);
		}
		if (!any || (figures[f].value == HTML_TRACTION && !slope))
			continue;
		snprintf(label, sizeof label, "%.120s: mean %s%s%s", name, figures[f].name, !vehicle ? "" : figures[f].force ? ", sum of its wheels" : " of its wheels",
			 figures[f].unit);
		html_row_head(report, label);
		for (size_t k = 0; k < report->count; k++)
			html_number_cell(found[k], figures[f].scale, report->file);
		fputs("</tr>\n", report->file);
	}
	write_energy(report, name, vehicle);
}

/* Whether one of the first `runs` drives has the object. */
static bool before(const struct html_report *report, size_t runs, const char *name)
{
	for (size_t i = 0; i < runs; i++)
		for (size_t k = 0; k < report->runs[i].objects.count && k < OBJECTS; k++)
			if (strcmp(report->runs[i].objects.list[k].name, name) == 0)
				return true;
	return false;
}

static void write_times(const struct html_report *report, const char *name, double part)
{
	html_row_head(report, name);
	for (size_t i = 0; i < report->count; i++)
		html_number_cell(part * ends_at(&report->runs[i]), 1, report->file);
	fputs("</tr>\n", report->file);
}

void html_means_write(const struct html_report *report)
{
	bool any = false, more = false;
	for (size_t i = 0; i < report->count; i++) {
		any = any || report->runs[i].objects.count > 0;
		more = more || report->runs[i].objects.count > OBJECTS;
	}
	if (!any) {
		html_sentence(report, NULL, "No means of slip, sinkage and forces: there are no rows of objects.csv");
		return;
	}
	html_table(report, "means over the last quarter of the time");
	write_times(report, "rows of objects.csv from t, s", PART);
	write_times(report, "to t, s", 1);
	for (size_t i = 0; i < report->count; i++) {
		const cJSON *vehicle;
		cJSON_ArrayForEach(vehicle, html_members(&report->runs[i], "vehicles")) {
			bool told = false;
			for (size_t k = 0; k < i; k++)
				told = told || cJSON_GetObjectItemCaseSensitive(html_members(&report->runs[k], "vehicles"), vehicle->string) != NULL;
			if (!told)
				write_rows(report, vehicle->string, true);
		}
	}
	for (size_t i = 0; i < report->count; i++)
		for (size_t k = 0; k < report->runs[i].objects.count && k < OBJECTS; k++)
			if (!before(report, i, report->runs[i].objects.list[k].name))
				write_rows(report, report->runs[i].objects.list[k].name, false);
	html_table_end(report);
	if (more)
		html_sentence(report, NULL, "The table shows the first 100 objects of each drive");
	fputs("<p class=\"small\">Each figure is the mean of the rows of objects.csv in that time. Wheels of a vehicle are its soil geoms. Torque is what turns the wheel: the soil's moment "
	      "about the axle, turned round. Vertical force is the soil's force upward. Drawbar pull is explained below its plot. Power, "
	      "energy for each metre and tractive efficiency are those of the same rows: efficiency is the work of traction over that of the axles. The actuators' work is the sum "
	      "over all of them; one that holds the vehicle back has work below 0.</p>\n", report->file);
}
