/* sensors.csv: what sensors of vehicles measure, a row for each multiple of 1 / output.sensors. docs/SENSORS.md has the columns. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "report/rows_file.h"
#include "report/sensors.h"

/* Numbers of a sensor. Vehicles that have one of this name and size share them. */
struct column {
	struct vehicle_sensor sensor;
	int *index; /* for each vehicle: its sensor; -1: it has none */
};

struct report_sensors {
	struct vehicles *vehicles;
	const char *directory;
	FILE *file;
	struct column *columns;
	size_t count, room;
	char *header; /* the file's first line */
};

static enum status failed(const struct report_sensors *rows)
{
	return fail_with(STATUS_FAILED, "%s/sensors.csv: %s; free some disk space", rows->directory, strerror(errno));
}

static enum status write_row(const struct report_sensors *rows, const struct world *world, size_t vehicle)
{
	struct vehicle_info info;
	vehicle_info(rows->vehicles, vehicle, &info);
	int printed = fprintf(rows->file, "%.9g,%s", world_time(world), info.name);
	for (size_t i = 0; i < rows->count && printed > 0; i++) {
		const struct column *column = &rows->columns[i];
		const int index = column->index[vehicle];
		const double *numbers = index >= 0 ? vehicle_sensed(rows->vehicles, vehicle, (size_t)index) : NULL;
		for (size_t k = 0; k < column->sensor.size && printed > 0; k++)
			printed = numbers == NULL || isnan(numbers[k]) ? fprintf(rows->file, ",") : fprintf(rows->file, ",%.12g", numbers[k]);
	}
	return printed > 0 && fputs("\n", rows->file) >= 0 ? STATUS_OK : failed(rows);
}

enum status report_sensors_write(const struct report_sensors *rows, const struct world *world)
{
	if (rows == NULL || !vehicle_sensors_due(rows->vehicles))
		return STATUS_OK;
	TRY(vehicle_sense(rows->vehicles));
	for (size_t v = 0; v < vehicle_count(rows->vehicles); v++)
		if (vehicle_sensor_count(rows->vehicles, v) > 0)
			TRY(write_row(rows, world, v));
	return fflush(rows->file) == 0 ? STATUS_OK : failed(rows);
}

/* --- columns --- */

static struct column *find_column(struct report_sensors *rows, const struct vehicle_sensor *sensor)
{
	for (size_t i = 0; i < rows->count; i++)
		if (strcmp(rows->columns[i].sensor.name, sensor->name) == 0 && rows->columns[i].sensor.size == sensor->size && rows->columns[i].sensor.turns == sensor->turns)
			return &rows->columns[i];
	return NULL;
}

static enum status add_column(struct report_sensors *rows, size_t vehicle, size_t index)
{
	const size_t vehicles = vehicle_count(rows->vehicles);
	struct vehicle_sensor sensor;
	vehicle_sensor(rows->vehicles, vehicle, index, &sensor);
	struct column *column = find_column(rows, &sensor);
	if (column == NULL) {
		TRY(mem_grow(&rows->columns, &rows->room, rows->count + 1, sizeof *rows->columns, "sensors.csv"));
		column = &rows->columns[rows->count];
		*column = (struct column){sensor, mem_alloc(vehicles, sizeof *column->index)};
		TRY_MEM(column->index, "sensors.csv");
		rows->count++;
		for (size_t i = 0; i < vehicles; i++)
			column->index[i] = -1;
	}
	column->index[vehicle] = (int)index;
	return STATUS_OK;
}

static void print_quoted(const char *text, FILE *stream)
{
	if (strpbrk(text, ",\"\r\n") == NULL) {
		fputs(text, stream);
		return;
	}
	fputc('"', stream);
	for (; *text != '\0'; text++)
		fputs(*text == '"' ? "\"\"" : *text == '\n' || *text == '\r' ? " " : (const char[]){*text, '\0'}, stream);
	fputc('"', stream);
}

static enum status make_header(struct report_sensors *rows)
{
	size_t size = 0;
	FILE *stream = open_memstream(&rows->header, &size);
	TRY_MEM(stream, "sensors.csv");
	fputs("t,name", stream);
	for (size_t i = 0; i < rows->count; i++)
		for (size_t k = 0; k < rows->columns[i].sensor.size; k++) {
			char text[400];
			report_sensor_column(&rows->columns[i].sensor, k, text);
			fputc(',', stream);
			print_quoted(text, stream);
		}
	fputc('\n', stream);
	const bool whole = !ferror(stream);
	return fclose(stream) == 0 && whole ? STATUS_OK : fail_memory("sensors.csv");
}

/* --- life --- */

static void tell_what_is_missed(const struct report_sensors *rows, const struct scene *scene)
{
	size_t count = 0;
	for (size_t i = 0; i < rows->count; i++) {
		count += rows->columns[i].sensor.size;
		if (!rows->columns[i].sensor.known)
			note("output.sensors: %s is of type %s%s, which knows no terrain: its cells are empty; take it away, or use a camera of the scene", rows->columns[i].sensor.name,
			     rows->columns[i].sensor.type, strcmp(rows->columns[i].sensor.type, "rangefinder") == 0 ? " on a camera" : "");
	}
	if (count == 0)
		note("output.sensors: no model has a <sensor>; give a model some, or the scene vehicles[].imu: {}");
	if (scene->sensor_rows * scene->time_step > 1 + 1e-9)
		note("output.sensors: %g rows a second are more than there are steps: a row comes each %g s; shorten time_step, or give %g", scene->sensor_rows, scene->time_step,
		     1 / scene->time_step);
}

enum status report_sensors_open(const struct world *world, struct vehicles *vehicles, const char *directory, struct report_sensors **out)
{
	char path[4096];
	*out = NULL;
	TRY(report_sensors_json(world, vehicles, directory));
	snprintf(path, sizeof path, "%s/sensors.csv", directory);
	if (vehicles == NULL || !(world_scene(world)->sensor_rows > 0)) {
		unlink(path);
		return STATUS_OK;
	}
	struct report_sensors *rows = mem_calloc(1, sizeof *rows);
	TRY_MEM(rows, "sensors.csv");
	*rows = (struct report_sensors){.vehicles = vehicles, .directory = directory};
	enum status status;
	for (size_t v = 0; v < vehicle_count(vehicles); v++)
		for (size_t i = 0; i < vehicle_sensor_count(vehicles, v); i++)
			TRY_OR(failed, add_column(rows, v, i));
	tell_what_is_missed(rows, world_scene(world));
	TRY_OR(failed, make_header(rows));
	TRY_OR(failed, report_rows_file_open(world, path, rows->header, true, &rows->file, NULL));
	*out = rows;
	return STATUS_OK;
failed:
	report_sensors_close(rows);
	return status;
}

void report_sensors_close(struct report_sensors *rows)
{
	if (rows == NULL)
		return;
	if (rows->file != NULL)
		fclose(rows->file);
	for (size_t i = 0; i < rows->count; i++)
		mem_free(rows->columns[i].index);
	mem_free(rows->columns);
	free(rows->header);
	mem_free(rows);
}

enum status report_sensors_mark(const struct report_sensors *rows, int64_t *end)
{
	return rows == NULL || report_rows_file_end(rows->file, end) ? STATUS_OK : failed(rows);
}

enum status report_sensors_rollback(const struct report_sensors *rows, int64_t end)
{
	return rows == NULL || report_rows_file_cut(rows->file, end) ? STATUS_OK : failed(rows);
}
