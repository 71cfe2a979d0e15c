/* furrow rig: its rows as CSV, and measured trials from one. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rig_table.h"

static void write_number(double value, const char *end, FILE *file)
{
	if (isfinite(value))
		fprintf(file, "%.9g", value);
	fputs(end, file);
}

bool rig_has_slip(const struct rig_table *table)
{
	return table->found.wheel || table->found.belt;
}

bool rig_is_turned(const struct rig_params *params)
{
	for (size_t i = 0; i < params->angle_count; i++)
		if (params->angles[i] != 0)
			return true;
	return false;
}

double rig_angle(const struct rig_params *params, size_t angle)
{
	return params->angle_count > 0 ? params->angles[angle] : 0;
}

void rig_columns(const struct rig_params *params, const struct rig_row *row, struct rig_column columns[RIG_COLUMNS])
{
	const struct rig_column all[RIG_COLUMNS] = {
		{"load", params->load_count > 0 ? params->loads[row->load] : (double)NAN}, {"slip", row->slip}, {"torque", row->torque}, {"sinkage", row->sinkage},
		{"drawbar", row->drawbar}, {"side", row->side}, {"fz", row->fz}, {"efficiency", row->efficiency}, {"deeper", row->deeper},
		/* behind the state: */
		{"slip_angle", rig_angle(params, row->angle)}, {"overturning", row->overturning}, {"aligning", row->aligning}, {"against", row->against},
		{"against_least", row->against_least}, {"against_most", row->against_most}, {"heap", row->heap}, {"heap_volume", row->heap_volume},
		{"depth", params->depth_count > 0 ? params->depths[row->load] : (double)NAN},
	};
	memcpy(columns, all, sizeof all);
}

#define BEFORE_STATE 9 /* columns; others came later, so that those of old keep their places */

void rig_csv_write(const struct rig_table *table, FILE *file)
{
	struct rig_column columns[RIG_COLUMNS];
	const struct rig_row none = {.load = 0};
	fputs("soil", file);
	rig_columns(table->params, &none, columns);
	for (int i = 0; i < RIG_COLUMNS; i++)
		fprintf(file, "%s,%s", i == BEFORE_STATE ? ",state" : "", columns[i].name);
	fputc('\n', file);
	for (size_t i = 0; i < table->count; i++) {
		const struct rig_row *row = &table->rows[i];
		const char *quote = strpbrk(table->soils[row->soil], ",\"") != NULL ? "\"" : "";
		fputs(quote, file);
		for (const char *at = table->soils[row->soil]; *at != '\0'; at++)
			fputs(*at == '"' ? "\"\"" : (char[]){*at, '\0'}, file);
		fputs(quote, file);
		rig_columns(table->params, row, columns);
		for (int k = 0; k < RIG_COLUMNS; k++) {
			if (k == BEFORE_STATE)
				fprintf(file, ",%s", trials_rig_states[row->state]);
			fputc(',', file);
			write_number(columns[k].value, "", file);
		}
		fputc('\n', file);
	}
}

/* --- measured trials --- */

/* The names that a column may have, what it is, and what its numbers are multiplied by. */
static const struct name {
	const char *name;
	int what;
	double unit;
} names[] = {
	{"slip", 0, 1}, {"sinkage", 1, 1}, {"sinkage_m", 1, 1}, {"sinkage_mm", 1, 1e-3}, {"drawbar", 2, 1}, {"drawbar_N", 2, 1}, {"drag_N", 2, -1},
	{"torque", 3, 1}, {"torque_Nm", 3, 1}, {"slip_angle_deg", 4, 1}, {"side", 5, 1}, {"side_N", 5, 1}, {"lateral_N", 5, 1},
};
#define SAME_ANGLE 0.5 /* degrees: by how much measured slip angles of one setting differ at most */
#define NAMES (sizeof names / sizeof *names)
#define COLUMNS_MOST 64

static int columns_of(char *line, int columns[COLUMNS_MOST])
{
	int count = 0;
	for (char *rest = line, *cell; (cell = strsep(&rest, ",\r\n")) != NULL && count < COLUMNS_MOST; count++) {
		columns[count] = -1;
		for (size_t i = 0; i < NAMES; i++)
			if (strcmp(cell + strspn(cell, " "), names[i].name) == 0)
				columns[count] = (int)i;
	}
	return count;
}

static bool has(const int *columns, int count, int what)
{
	for (int i = 0; i < count; i++)
		if (columns[i] >= 0 && names[columns[i]].what == what)
			return true;
	return false;
}

/* Returns false if a cell that is read is no number. */
static bool read_line(char *line, const int *columns, int count, struct rig_measured *out)
{
	double values[6] = {NAN, NAN, NAN, NAN, 0, NAN};
	char *rest = line;
	for (int i = 0; i < count; i++) {
		char *cell = strsep(&rest, ",\r\n"), *end;
		if (columns[i] < 0)
			continue;
		if (cell == NULL)
			return false;
		const double value = strtod(cell, &end);
		if (end == cell || end[strspn(end, " ")] != '\0')
			return false;
		values[names[columns[i]].what] = value * names[columns[i]].unit;
	}
	*out = (struct rig_measured){.slip = values[0], .sinkage = values[1], .drawbar = values[2], .torque = values[3], .angle = values[4], .side = values[5]};
	return isfinite(values[0]);
}

static enum status read_all(const char *path, FILE *file, struct rig_measured *list, size_t *count)
{
	char line[4096];
	int columns[COLUMNS_MOST], number = 1;
	if (fgets(line, sizeof line, file) == NULL)
		return fail_with(STATUS_INPUT, "%s: is empty; its first line must name its columns", path);
	const int width = columns_of(line, columns);
	if (!has(columns, width, 0) || !(has(columns, width, 1) || has(columns, width, 2) || has(columns, width, 3) || has(columns, width, 5)))
		return fail_with(STATUS_INPUT, "%s:1: no column slip, or none of sinkage, sinkage_mm, drawbar, drag_N, side, lateral_N, torque; name the columns so", path);
	while (fgets(line, sizeof line, file) != NULL) {
		number++;
		if (line[strspn(line, " \r\n")] == '\0' || line[0] == '#')
			continue;
		if (*count == RIG_MEASURED_MOST)
			return fail_with(STATUS_INPUT, "%s:%d: more than %d trials; give fewer", path, number, RIG_MEASURED_MOST);
		if (!read_line(line, columns, width, &list[*count]))
			return fail_with(STATUS_INPUT, "%s:%d: a number is missing or is none; each line needs one in each column", path, number);
		(*count)++;
	}
	if (ferror(file))
		return fail_with(STATUS_INPUT, "%s: %s; give a file that can be read", path, input_problem());
	if (*count == 0)
		return fail_with(STATUS_INPUT, "%s: has no trial; give a line for each", path);
	return STATUS_OK;
}

enum status rig_measured_read(const char *path, struct rig_measured **out, size_t *count)
{
	*count = 0;
	*out = mem_alloc(RIG_MEASURED_MOST, sizeof **out);
	if (*out == NULL)
		return fail_memory("measured trials");
	FILE *file = input_open(path);
	if (file == NULL)
		return fail_with(STATUS_INPUT, "%s: %s; give a file that can be read", path, strerror(errno));
	enum status status = read_all(path, file, *out, count);
	fclose(file);
	return status;
}

bool rig_same_angle(double a, double b)
{
	return fabs(a - b) <= SAME_ANGLE;
}

/* --- figures --- */

double rig_figure(const struct rig_row *row, int figure)
{
	const double all[RIG_FIGURES] = {row->sinkage * 1e3, row->drawbar, row->side, row->torque, row->efficiency, row->against};
	return all[figure];
}

double rig_measured_figure(const struct rig_measured *measured, int figure)
{
	const double all[RIG_FIGURES] = {measured->sinkage * 1e3, measured->drawbar, measured->side, measured->torque, NAN, NAN};
	return all[figure];
}

/* The curve at a slip, between the rows on both sides of it. NaN: beyond them. */
static double curve_at(const struct rig_table *table, size_t soil, size_t load, size_t angle, int figure, double slip)
{
	const struct rig_row *low = NULL, *high = NULL;
	for (const struct rig_row *row = table->rows; row < table->rows + table->count; row++) {
		if (row->soil != soil || row->load != load || row->angle != angle || !isfinite(rig_figure(row, figure)))
			continue;
		if (row->slip <= slip && (low == NULL || row->slip > low->slip))
			low = row;
		if (row->slip >= slip && (high == NULL || row->slip < high->slip))
			high = row;
	}
	if (low == NULL || high == NULL)
		return NAN;
	const double share = high->slip > low->slip ? (slip - low->slip) / (high->slip - low->slip) : 0;
	return rig_figure(low, figure) + (rig_figure(high, figure) - rig_figure(low, figure)) * share;
}

double rig_difference(const struct rig_table *table, size_t soil, size_t load, size_t angle, int figure)
{
	double sum = 0, count = 0;
	for (const struct rig_measured *m = table->measured; m < table->measured + table->measured_count; m++) {
		if (!rig_same_angle(m->angle, rig_angle(table->params, angle)))
			continue;
		const double gap = curve_at(table, soil, load, angle, figure, m->slip) - rig_measured_figure(m, figure);
		if (isfinite(gap)) {
			sum += gap * gap;
			count++;
		}
	}
	return count > 0 ? sqrt(sum / count) : (double)NAN;
}
