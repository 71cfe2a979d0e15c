/* furrow rig: its rows as a table, and as JSON. */
#include <math.h>
#include <stdio.h>

#include "json.h"
#include "rig_table.h"

/* --- text --- */

struct cell {
	const char *name;
	int width, places; /* places -1: as short as the number is */
	double value;
};
#define CELLS 12

/* Fills what a row shows, in its order. Returns how many cells it has. */
static int cells_of(const struct rig_table *table, const struct rig_row *row, struct cell cells[CELLS])
{
	const struct rig_params *params = table->params;
	const bool driven = rig_has_slip(table), turned = rig_is_turned(params), force = !driven || params->depth_count > 0;
	int count = 0;
	if (params->load_count > 0)
		cells[count++] = (struct cell){"load N", 10, -1, params->loads[row->load]};
	else
		cells[count++] = (struct cell){"depth mm", 10, -1, params->depths[row->load] * 1e3};
	if (turned)
		cells[count++] = (struct cell){"angle", 8, -1, rig_angle(params, row->angle)};
	if (driven)
		cells[count++] = (struct cell){"slip", 8, 3, row->slip};
	if (params->depth_count == 0)
		cells[count++] = (struct cell){"sinkage mm", 12, 2, row->sinkage * 1e3};
	if (!force || turned)
		cells[count++] = (struct cell){"drawbar N", 12, 2, row->drawbar};
	if (turned)
		cells[count++] = (struct cell){"side N", 12, 2, row->side};
	if (driven) {
		cells[count++] = (struct cell){table->found.belt ? "pull N" : "torque N m", 12, 3, row->torque};
		if (!force)
			cells[count++] = (struct cell){"efficiency", 12, 3, row->efficiency};
	}
	if (force) {
		cells[count++] = (struct cell){"against N", 12, 2, row->against};
		cells[count++] = (struct cell){"least", 10, 2, row->against_least};
		cells[count++] = (struct cell){"most", 10, 2, row->against_most};
		cells[count++] = (struct cell){params->depth_count > 0 ? "fz N" : "heap mm", 12, params->depth_count > 0 ? 2 : 1,
					       params->depth_count > 0 ? row->fz : row->heap * 1e3};
	}
	return count;
}

static void print_head(const struct rig_table *table, size_t soil)
{
	const struct rig_row none = {.load = 0};
	struct cell cells[CELLS];
	const int count = cells_of(table, &none, cells);
	printf("%s%s, posts of %g mm\n", soil > 0 ? "\n" : "", table->soils[soil], table->found.spacing * 1e3);
	for (int i = 0; i < count; i++)
		printf("%*s", cells[i].width, cells[i].name);
	putchar('\n');
}

static void print_row(const struct rig_table *table, const struct rig_row *row)
{
	struct cell cells[CELLS];
	const int count = cells_of(table, row, cells);
	for (int i = 0; i < count; i++)
		if (!isfinite(cells[i].value))
			printf("%*s", cells[i].width, "-");
		else if (rig_has_slip(table) && row->slip <= RIG_SLIP_LOCKED && cells[i].value == row->slip)
			printf("%*s", cells[i].width, "locked");
		else if (cells[i].places < 0)
			printf("%*g", cells[i].width, cells[i].value);
		else
			printf("%*.*f", cells[i].width, cells[i].places, cells[i].value);
	printf("  %s\n", trials_rig_states[row->state]);
}

static void print_differences(const struct rig_table *table, size_t soil)
{
	const char *const names[RIG_FIGURES] = {"sinkage %.2f mm", "drawbar %.2f N", "side force %.2f N", table->found.belt ? "pull %.3f N" : "torque %.3f N m"};
	const struct rig_params *params = table->params;
	const size_t angles = params->angle_count > 0 ? params->angle_count : 1;
	for (size_t place = 0; place < params->load_count * angles && table->measured_count > 0; place++) {
		const char *before = " ";
		printf("from the measured trials at %g N", params->loads[place / angles]);
		if (rig_is_turned(params))
			printf(", %g degrees", rig_angle(params, place % angles));
		printf(", RMS:");
		for (int i = 0; i < RIG_FIGURES; i++) {
			const double difference = names[i] != NULL ? rig_difference(table, soil, place / angles, place % angles, i) : (double)NAN;
			if (!isfinite(difference))
				continue;
			fputs(before, stdout);
			printf(names[i], difference);
			before = ", ";
		}
		puts(before[0] == ' ' ? " no slip in common" : "");
	}
}

void rig_told_print(const struct rig_table *table)
{
	for (size_t soil = 0; soil < table->params->soil_count; soil++) {
		print_head(table, soil);
		for (size_t i = 0; i < table->count; i++)
			if (table->rows[i].soil == soil)
				print_row(table, &table->rows[i]);
		print_differences(table, soil);
	}
}

/* --- JSON --- */

static cJSON *row_of(const struct rig_table *table, const struct rig_row *row)
{
	struct rig_column columns[RIG_COLUMNS];
	cJSON *object = cJSON_CreateObject();
	cJSON_AddStringToObject(object, "soil", table->soils[row->soil]);
	rig_columns(table->params, row, columns);
	for (int i = 0; i < RIG_COLUMNS; i++)
		json_number(object, columns[i].name, columns[i].value);
	cJSON_AddStringToObject(object, "state", trials_rig_states[row->state]);
	return object;
}

static cJSON *table_of(const struct rig_table *table)
{
	cJSON *object = cJSON_CreateObject(), *rows = cJSON_CreateArray();
	cJSON_AddStringToObject(object, "shape", table->params->shape);
	json_number(object, "spacing", table->found.spacing);
	json_number(object, "way", table->found.way);
	json_number(object, "speed", table->params->speed > 0 ? table->params->speed : RIG_SPEED);
	for (size_t i = 0; i < table->count; i++)
		cJSON_AddItemToArray(rows, row_of(table, &table->rows[i]));
	cJSON_AddItemToObject(object, "rows", rows);
	return object;
}

enum status rig_told_json(const struct rig_table *table)
{
	return json_print(table_of(table));
}

cJSON *rig_told_plan(const struct rig_table *table)
{
	cJSON *plan = table_of(table), *list = cJSON_AddArrayToObject(plan, "measured");
	cJSON_AddBoolToObject(plan, "belt", table->found.belt);
	for (const struct rig_measured *m = table->measured; m < table->measured + table->measured_count; m++) {
		cJSON *trial = cJSON_CreateObject();
		cJSON_AddItemToArray(list, trial);
		json_number(trial, "slip", m->slip);
		json_number(trial, "angle", m->angle);
		json_number(trial, "sinkage", m->sinkage);
		json_number(trial, "drawbar", m->drawbar);
		json_number(trial, "side", m->side);
		json_number(trial, "torque", m->torque);
	}
	return plan;
}
