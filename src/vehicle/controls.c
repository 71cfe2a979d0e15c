/* A table of controls in time: t and one column for each actuator that it names. Between two rows controls change evenly. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "vehicle/powertrain.h"
#include "vehicle/table.h"

struct reader {
	struct vehicle *vehicle;
	struct vehicle_table table;
	size_t room;
};

static enum status read_header(struct reader *reader)
{
	struct driver *driver = &reader->vehicle->driver;
	struct vehicle_table *table = &reader->table;
	bool any;
	char *rest = table->text;
	TRY(vehicle_table_next(table, &any));
	const char *name = any ? strsep(&rest, ",") : NULL;
	if (name == NULL || strcmp(name, "t") != 0)
		return vehicle_table_wrong(table, "the first line does not begin with t", "t,ACTUATOR,...");
	TRY(mem_zeroed(&driver->held, strlen(table->text) + (rest != NULL ? strlen(rest) : 0) + 2, sizeof *driver->held, "a table of controls"));
	while ((name = strsep(&rest, ",")) != NULL) {
		const int actuator = vehicle_control_find(reader->vehicle, name);
		if (actuator < 0)
			return vehicle_table_wrong(table, name, "names of the model's actuators");
		for (size_t i = 0; i < driver->held_count; i++)
			if (driver->held[i] == actuator)
				return vehicle_table_wrong(table, name, "each actuator once");
		driver->held[driver->held_count++] = actuator;
	}
	return driver->held_count > 0 ? STATUS_OK : vehicle_table_wrong(table, "no actuator", "t,ACTUATOR,...");
}

static enum status read_row(struct reader *reader)
{
	struct driver *driver = &reader->vehicle->driver;
	struct vehicle_table *table = &reader->table;
	const size_t width = driver->held_count + 1;
	char *rest = table->text, *field;
	TRY(mem_grow(&driver->table, &reader->room, driver->row_count + 1, width * sizeof *driver->table, "a table of controls"));
	double *row = &driver->table[driver->row_count * width];
	size_t count = 0;
	for (; (field = strsep(&rest, ",")) != NULL && count < width; count++)
		TRY(vehicle_table_number(table, field, &row[count]));
	if (count != width || field != NULL)
		return vehicle_table_wrong(table, "another number of columns", "as many as in the first line");
	if (driver->row_count > 0 ? !(row[0] > row[-(ptrdiff_t)width]) : !(row[0] >= 0))
		return vehicle_table_wrong(table, "t does not grow", "times that grow from row to row, from 0");
	driver->row_count++;
	return STATUS_OK;
}

static enum status read(struct reader *reader)
{
	bool any;
	TRY(read_header(reader));
	for (;;) {
		TRY(vehicle_table_next(&reader->table, &any));
		if (!any)
			break;
		TRY(read_row(reader));
	}
	return reader->vehicle->driver.row_count > 0 ? STATUS_OK : vehicle_table_wrong(&reader->table, "no row", "at least one");
}

enum status vehicle_read_controls(struct vehicle *vehicle, const char *where)
{
	struct reader *reader = mem_calloc(1, sizeof *reader);
	TRY_MEM(reader, "a table of controls");
	reader->vehicle = vehicle;
	reader->table = (struct vehicle_table){.where = where, .key = "driver.controls", .path = vehicle->scene->controls, .most = TABLE_LINE};
	enum status status = vehicle_table_open(&reader->table);
	if (status == STATUS_OK) {
		status = read(reader);
		vehicle_table_close(&reader->table);
	}
	mem_free(reader);
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
