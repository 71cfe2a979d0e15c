/* The table "Drives" of the report: electric drives, engines and brakes, as run.json has them. Without any it is not there. */
#include <stdio.h>
#include <string.h>

#include "html_report.h"

struct figure {
	const char *name, *key;
	double unit;
};

static const struct figure electric[] = {{"current at the end, A", "current", 1}, {"voltage at the end, V", "voltage", 1}, {"torque at the end, N m", "torque", 1},
					 {"energy taken, kJ", "taken", 1e3}, {"energy given back, kJ", "recovered", 1e3}, {"work of the motor, kJ", "mechanical", 1e3},
					 {"heat of its windings, kJ", "heat", 1e3}};
static const struct figure engine[] = {{"engine speed at the end, rpm", "engine_speed", 1}, {"gear at the end", "gear", 1}, {"work of the engine, kJ", "engine_work", 1e3},
				       {"lost in clutch, converter and differentials, kJ", "driveline_loss", 1e3}, {"kinetic energy of the engine at the end, kJ", "engine_kinetic", 1e3}};
static const struct figure brakes[] = {{"energy that the brakes took, kJ", "brake_loss", 1e3}};
#define COUNT(list) (sizeof(list) / sizeof *(list))

static const cJSON *member(const cJSON *of, const char *key)
{
	return key != NULL && key[0] != '\0' ? cJSON_GetObjectItemCaseSensitive(of, key) : of;
}

/* Writes the rows of one thing: `part` of the vehicle, and `name` of that. Folders without it have empty cells. */
static void write_rows(const struct html_report *report, const char *vehicle, const char *part, const char *name, const struct figure *figures, size_t count)
{
	for (size_t f = 0; f < count; f++) {
		char label[400];
		snprintf(label, sizeof label, "%.120s%s%.120s: %s", vehicle, name != NULL ? " " : "", name != NULL ? name : "", figures[f].name);
		html_row_head(report, label);
		for (size_t i = 0; i < report->count; i++) {
			const cJSON *of = member(member(member(html_members(&report->runs[i], "vehicles"), vehicle), part), name), *value = member(of, figures[f].key);
			if (cJSON_IsNumber(value))
				html_number_cell(value->valuedouble, figures[f].unit, report->file);
			else
				fputs("<td></td>", report->file);
		}
		fputs("</tr>\n", report->file);
	}
}

static bool has(const struct html_report *report, size_t runs, const char *vehicle, const char *part, const char *name)
{
	for (size_t i = 0; i < runs; i++)
		if (member(member(member(html_members(&report->runs[i], "vehicles"), vehicle), part), name) != NULL)
			return true;
	return false;
}

/* Writes what of a vehicle earlier folders have not had. */
static void write_vehicle(const struct html_report *report, size_t run, const cJSON *vehicle, bool *begun)
{
	const char *name = vehicle->string;
	const cJSON *drives = member(vehicle, "drives"), *drive;
	const bool turns = member(vehicle, "powertrain") != NULL && !has(report, run, name, "powertrain", NULL);
	const bool stops = member(vehicle, "brake_loss") != NULL && !has(report, run, name, "brake_loss", NULL);
	if (!*begun && (drives != NULL || turns || stops)) {
		html_table(report, "drives");
		*begun = true;
	}
	if (turns)
		write_rows(report, name, "powertrain", NULL, engine, COUNT(engine));
	if (stops)
		write_rows(report, name, NULL, NULL, brakes, COUNT(brakes));
	cJSON_ArrayForEach(drive, drives)
		if (drive->string != NULL && !has(report, run, name, "drives", drive->string)) {
			write_rows(report, name, "drives", drive->string, electric, COUNT(electric));
		}
}

void html_drives(const struct html_report *report)
{
	bool begun = false;
	for (size_t i = 0; i < report->count; i++) {
		const cJSON *vehicle;
		cJSON_ArrayForEach(vehicle, html_members(&report->runs[i], "vehicles"))
			if (vehicle->string != NULL)
				write_vehicle(report, i, vehicle, &begun);
	}
	if (begun)
		html_table_end(report);
}
