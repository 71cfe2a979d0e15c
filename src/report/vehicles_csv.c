/* vehicles.csv: where vehicles are and how they move, a row for each multiple of 1 / output.vehicles. VEHICLES.md has the columns. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "report/rows_file.h"

static const char fixed[] = "t,name,x,y,z,roll,pitch,yaw,vx,vy,vz,kinetic,work", carried[] = ",carried,carried_weight",
		  engine[] = ",engine_speed,gear,engine_work,driveline_loss", brakes[] = ",brake_loss";

/* What a column after the fixed ones has. The file has them in this order. */
enum kind { JOINT, CONTROL, FORCE, CURRENT, VOLTAGE, ENERGY, KINDS };
static const char letters[KINDS] = "qufive";

/* A column of a joint or an actuator. Vehicles that have one of this name share it. */
struct column {
	const char *name;
	enum kind kind;
	int *index; /* for each vehicle: its joint or actuator; -1: it has none */
};

struct report_vehicles {
	struct vehicles *vehicles;
	const char *directory;
	FILE *file;
	bool carries; /* a vehicle may carry soil */
	bool engines, brakes; /* a vehicle has a powertrain, has brakes */
	struct column *columns;
	size_t count;
	char *header; /* the file's first line */
};

static enum status failed(const struct report_vehicles *rows)
{
	return fail_with(STATUS_FAILED, "%s/vehicles.csv: %s; free some disk space", rows->directory, strerror(errno));
}

/* Electric drives have current, voltage, and what they have taken of their battery and not given back. */
static double value_of(const struct report_vehicles *rows, const struct vehicle_row *row, enum kind kind, int index)
{
	if (kind >= CURRENT) {
		struct vehicle_drive drive;
		vehicle_drive(rows->vehicles, row->vehicle, (size_t)index, &drive);
		return kind == CURRENT ? drive.current : kind == VOLTAGE ? drive.voltage : drive.taken - drive.recovered;
	}
	return (kind == JOINT ? row->joints : kind == CONTROL ? row->controls : row->forces)[index];
}

static enum status write_row(const struct report_vehicles *rows, const struct vehicle_row *row)
{
	struct vehicle_info info;
	vehicle_info(rows->vehicles, row->vehicle, &info);
	int printed = fprintf(rows->file, "%.9g,%s,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g", row->time, info.name, row->position[0],
			      row->position[1], row->position[2], row->roll, row->pitch, row->yaw, row->velocity[0], row->velocity[1],
			      row->velocity[2], row->kinetic, row->work);
	if (rows->carries && printed > 0)
		printed = fprintf(rows->file, ",%.9g,%.9g", row->aboard.volume, row->aboard.weight);
	const struct vehicle_train *train = &row->train;
	if (rows->engines && printed > 0)
		printed = train->has_engine ? fprintf(rows->file, ",%.9g,%d,%.9g,%.9g", train->engine_speed, train->gear, train->engine_work, train->loss) : fprintf(rows->file, ",,,,");
	if (rows->brakes && printed > 0)
		printed = train->has_brakes ? fprintf(rows->file, ",%.9g", train->brake_work) : fprintf(rows->file, ",");
	for (size_t i = 0; i < rows->count && printed > 0; i++) {
		const struct column *column = &rows->columns[i];
		const int index = column->index[row->vehicle];
		if (index < 0)
			printed = fputs(",", rows->file) >= 0;
		else
			printed = fprintf(rows->file, ",%.9g", value_of(rows, row, column->kind, index));
	}
	return printed > 0 && fputs("\n", rows->file) >= 0 ? STATUS_OK : failed(rows);
}

enum status report_vehicles_write(const struct report_vehicles *rows)
{
	if (rows == NULL || !vehicle_rows_due(rows->vehicles))
		return STATUS_OK;
	for (size_t v = 0; v < vehicle_count(rows->vehicles); v++) {
		struct vehicle_row row;
		vehicle_row(rows->vehicles, v, &row);
		TRY(write_row(rows, &row));
	}
	return fflush(rows->file) == 0 ? STATUS_OK : failed(rows);
}

/* --- columns --- */

static struct column *find_column(struct report_vehicles *rows, const char *name, enum kind kind)
{
	for (size_t i = 0; i < rows->count; i++)
		if (rows->columns[i].kind == kind && strcmp(rows->columns[i].name, name) == 0)
			return &rows->columns[i];
	return NULL;
}

static enum status add_column(struct report_vehicles *rows, size_t vehicle, size_t index, enum kind kind)
{
	const size_t vehicles = vehicle_count(rows->vehicles);
	struct vehicle_drive drive = {.name = ""};
	if (kind >= CURRENT)
		vehicle_drive(rows->vehicles, vehicle, index, &drive);
	const char *name = kind >= CURRENT ? drive.name : kind == JOINT ? vehicle_joint_name(rows->vehicles, vehicle, index) : vehicle_actuator_name(rows->vehicles, vehicle, index);
	if (name[0] == '\0')
		return STATUS_OK;
	struct column *column = find_column(rows, name, kind);
	if (column == NULL) {
		TRY(mem_resize(&rows->columns, rows->count + 1, sizeof *rows->columns, "vehicles.csv"));
		column = &rows->columns[rows->count];
		*column = (struct column){name, kind, mem_alloc(vehicles, sizeof *column->index)};
		TRY_MEM(column->index, "vehicles.csv");
		rows->count++;
		for (size_t i = 0; i < vehicles; i++)
			column->index[i] = -1;
	}
	column->index[vehicle] = (int)index;
	return STATUS_OK;
}

static enum status find_columns(struct report_vehicles *rows)
{
	for (enum kind kind = JOINT; kind < KINDS; kind++)
		for (size_t v = 0; v < vehicle_count(rows->vehicles); v++) {
			struct vehicle_info info;
			vehicle_info(rows->vehicles, v, &info);
			const size_t count = kind == JOINT ? info.joint_count : kind >= CURRENT ? vehicle_drive_count(rows->vehicles, v) : info.actuator_count;
			for (size_t i = 0; i < count; i++)
				TRY(add_column(rows, v, i, kind));
		}
	return STATUS_OK;
}

static enum status make_header(struct report_vehicles *rows)
{
	size_t size = 0;
	FILE *stream = open_memstream(&rows->header, &size);
	TRY_MEM(stream, "vehicles.csv");
	fputs(fixed, stream);
	fputs(rows->carries ? carried : "", stream);
	fputs(rows->engines ? engine : "", stream);
	fputs(rows->brakes ? brakes : "", stream);
	for (size_t i = 0; i < rows->count; i++)
		fprintf(stream, ",%c:%s", letters[rows->columns[i].kind], rows->columns[i].name);
	fputc('\n', stream);
	const bool whole = !ferror(stream);
	return fclose(stream) == 0 && whole ? STATUS_OK : fail_memory("vehicles.csv");
}

enum status report_vehicles_open(const struct world *world, struct vehicles *vehicles, const char *directory,
				 struct report_vehicles **out)
{
	char path[4096];
	*out = NULL;
	snprintf(path, sizeof path, "%s/vehicles.csv", directory);
	if (vehicles == NULL || world_scene(world)->vehicle_rows == 0) {
		unlink(path); /* that another run left */
		return STATUS_OK;
	}
	struct report_vehicles *rows = mem_calloc(1, sizeof *rows);
	TRY_MEM(rows, "vehicles.csv");
	*rows = (struct report_vehicles){.vehicles = vehicles, .directory = directory, .carries = scene_vehicles_carry(world_scene(world))};
	for (size_t v = 0; v < vehicle_count(vehicles); v++) {
		struct vehicle_info info;
		vehicle_info(vehicles, v, &info);
		rows->engines = rows->engines || info.train.has_engine;
		rows->brakes = rows->brakes || info.train.has_brakes;
	}
	enum status status;
	TRY_OR(failed, find_columns(rows));
	TRY_OR(failed, make_header(rows));
	TRY_OR(failed, report_rows_file_open(world, path, rows->header, true, &rows->file, NULL));
	*out = rows;
	return STATUS_OK;
failed:
	report_vehicles_close(rows);
	return status;
}

void report_vehicles_close(struct report_vehicles *rows)
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

enum status report_vehicles_mark(const struct report_vehicles *rows, int64_t *end)
{
	return rows == NULL || report_rows_file_end(rows->file, end) ? STATUS_OK : failed(rows);
}

enum status report_vehicles_rollback(const struct report_vehicles *rows, int64_t end)
{
	return rows == NULL || report_rows_file_cut(rows->file, end) ? STATUS_OK : failed(rows);
}
