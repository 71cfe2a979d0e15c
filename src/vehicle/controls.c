/* A table of controls in time: t and one column for each actuator that it names. Between two rows controls change evenly. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vehicle/internal.h"

#define LINE_MOST 16384

struct table {
	struct vehicle *vehicle;
	FILE *file;
	const char *where, *path;
	int line;
	size_t room;
	char text[LINE_MOST];
};

static enum status wrong(const struct table *table, const char *what, const char *allowed)
{
	return fail_with(STATUS_INPUT, "%s: driver.controls: %s:%d: %.64s; allowed: %s", table->where, table->path, table->line, what, allowed);
}

/* Reads the next line that is not empty, without its end. *any: there was one. */
static enum status next(struct table *table, bool *any)
{
	*any = false;
	while (fgets(table->text, sizeof table->text, table->file) != NULL) {
		table->line++;
		const size_t length = strcspn(table->text, "\r\n");
		if (table->text[length] == '\0' && !feof(table->file))
			return wrong(table, "the line is too long, or has a byte 0", "lines of 16383 bytes");
		table->text[length] = '\0';
		if (length == 0)
			continue;
		*any = true;
		return STATUS_OK;
	}
	return ferror(table->file) ? wrong(table, strerror(errno), "a file that can be read") : STATUS_OK;
}

static enum status read_header(struct table *table)
{
	struct driver *driver = &table->vehicle->driver;
	bool any;
	char *rest = table->text;
	TRY(next(table, &any));
	const char *name = any ? strsep(&rest, ",") : NULL;
	if (name == NULL || strcmp(name, "t") != 0)
		return wrong(table, "the first line does not begin with t", "t,ACTUATOR,...");
	TRY(mem_zeroed(&driver->held, strlen(table->text) + (rest != NULL ? strlen(rest) : 0) + 2, sizeof *driver->held, "a table of controls"));
	while ((name = strsep(&rest, ",")) != NULL) {
		const int actuator = vehicle_find_part(table->vehicle, mjOBJ_ACTUATOR, name);
		if (actuator < 0)
			return wrong(table, name, "names of the model's actuators");
		for (size_t i = 0; i < driver->held_count; i++)
			if (driver->held[i] == actuator)
				return wrong(table, name, "each actuator once");
		driver->held[driver->held_count++] = actuator;
	}
	return driver->held_count > 0 ? STATUS_OK : wrong(table, "no actuator", "t,ACTUATOR,...");
}

static enum status read_row(struct table *table)
{
	struct driver *driver = &table->vehicle->driver;
	const size_t width = driver->held_count + 1;
	char *rest = table->text, *field, *end;
	TRY(mem_grow(&driver->table, &table->room, driver->row_count + 1, width * sizeof *driver->table, "a table of controls"));
	double *row = &driver->table[driver->row_count * width];
	size_t count = 0;
	for (; (field = strsep(&rest, ",")) != NULL && count < width; count++) {
		row[count] = strtod(field, &end);
		if (end == field || *end != '\0' || !(fabs(row[count]) <= 1e12))
			return wrong(table, field, "numbers");
	}
	if (count != width || field != NULL)
		return wrong(table, "another number of columns", "as many as in the first line");
	if (driver->row_count > 0 ? !(row[0] > row[-(ptrdiff_t)width]) : !(row[0] >= 0))
		return wrong(table, "t does not grow", "times that grow from row to row, from 0");
	driver->row_count++;
	return STATUS_OK;
}

static enum status read(struct table *table)
{
	bool any;
	TRY(read_header(table));
	for (;;) {
		TRY(next(table, &any));
		if (!any)
			break;
		TRY(read_row(table));
	}
	return table->vehicle->driver.row_count > 0 ? STATUS_OK : wrong(table, "no row", "at least one");
}

enum status vehicle_read_controls(struct vehicle *vehicle, const char *where)
{
	struct table *table = mem_calloc(1, sizeof *table);
	TRY_MEM(table, "a table of controls");
	*table = (struct table){.vehicle = vehicle, .where = where, .path = vehicle->scene->controls};
	table->file = input_open(table->path);
	enum status status;
	if (table->file == NULL) {
		status = fail_with(STATUS_INPUT, "%s: driver.controls: %s: %s; name a file that can be read", where, table->path, input_problem());
	} else {
		status = read(table);
		fclose(table->file);
	}
	mem_free(table);
	return status;
}

void vehicle_table_control(struct vehicle *vehicle, double time)
{
	const struct driver *driver = &vehicle->driver;
	const size_t width = driver->held_count + 1;
	size_t low = 0, high = driver->row_count; /* the last row at or before `time` is in [low, high) */
	while (high - low > 1) {
		const size_t middle = low + (high - low) / 2;
		if (driver->table[middle * width] <= time)
			low = middle;
		else
			high = middle;
	}
	const double *row = &driver->table[low * width], *after = low + 1 < driver->row_count ? row + width : row;
	const double share = after != row ? fmin(fmax((time - row[0]) / (after[0] - row[0]), 0), 1) : 0;
	for (size_t i = 0; i < driver->held_count; i++)
		*vehicle_ctrl(vehicle, driver->held[i]) = row[1 + i] + share * (after[1 + i] - row[1 + i]);
}
