/*
 * Forces from outside on bodies of a vehicle: a table in time, and what a host sets.
 *
 * A row of the table holds from its t until the next row of the same body. In a step of the engine a force is its mean over the step. So a push
 * of F for a time t brings F t. Forces act at the body's centre of mass, along east, north and up.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "vehicle/internal.h"
#include "vehicle/table.h"

#define LINE_MOST 4096 /* bytes, with its end */
#define COLUMNS_MOST 8 /* t, body, forces, moments */

struct push {
	double t, wrench[6]; /* s; N and N m */
	int body;
	int line;
	size_t end; /* of the rows of this body: the number of the first one after them */
};

struct pushes {
	struct push *rows; /* by body, then by time */
	size_t count, room;
};

struct reader {
	const struct vehicle *vehicle;
	size_t columns;
	struct vehicle_table table;
};

static enum status read_header(struct reader *reader)
{
	if (strcmp(reader->table.text, "t,body,fx,fy,fz") == 0)
		reader->columns = 5;
	else if (strcmp(reader->table.text, "t,body,fx,fy,fz,tx,ty,tz") == 0)
		reader->columns = COLUMNS_MOST;
	else
		return vehicle_table_wrong(&reader->table, "another header", "t,body,fx,fy,fz or t,body,fx,fy,fz,tx,ty,tz");
	return STATUS_OK;
}

static enum status find_body(const struct reader *reader, const char *name, int *body)
{
	const struct vehicle *vehicle = reader->vehicle;
	*body = vehicle_body_by_name(vehicle, name);
	if (*body >= 0)
		return STATUS_OK;
	char names[VEHICLE_NAMES];
	vehicle_list_names(vehicle->model, mjOBJ_BODY, vehicle->own.body.first, vehicle->own.body.end, names);
	return fail_with(STATUS_INPUT, "%s: pushes: %s:%d: %.64s names no body of the model; there are: %s", reader->table.where, reader->table.path, reader->table.line, name, names);
}

static enum status read_row(struct reader *reader, struct pushes *pushes)
{
	char *rest = reader->table.text, *field;
	TRY(mem_grow(&pushes->rows, &pushes->room, pushes->count + 1, sizeof *pushes->rows, "pushes"));
	struct push *push = &pushes->rows[pushes->count];
	*push = (struct push){.line = reader->table.line};
	size_t column = 0;
	for (; (field = strsep(&rest, ",")) != NULL && column < reader->columns; column++) {
		if (column == 1) {
			TRY(find_body(reader, field, &push->body));
			continue;
		}
		TRY(vehicle_table_number(&reader->table, field, column == 0 ? &push->t : &push->wrench[column - 2]));
	}
	if (column != reader->columns || field != NULL)
		return vehicle_table_wrong(&reader->table, "another number of columns", "as many as in the first line");
	if (!(push->t >= 0))
		return vehicle_table_wrong(&reader->table, "t is below 0", "times from 0 on");
	pushes->count++;
	return STATUS_OK;
}

static int by_body_and_time(const void *a, const void *b)
{
	const struct push *x = a, *y = b;
	if (x->body != y->body)
		return x->body < y->body ? -1 : 1;
	return x->line < y->line ? -1 : 1;
}

static enum status read_table(struct reader *reader, struct pushes *pushes)
{
	bool any;
	for (;;) {
		TRY(vehicle_table_next(&reader->table, &any));
		if (!any)
			break;
		TRY(reader->columns == 0 ? read_header(reader) : read_row(reader, pushes));
	}
	if (pushes->count == 0)
		return vehicle_table_wrong(&reader->table, "no row", "at least one");
	qsort(pushes->rows, pushes->count, sizeof *pushes->rows, by_body_and_time);
	for (size_t i = 1; i < pushes->count; i++)
		if (pushes->rows[i].body == pushes->rows[i - 1].body && !(pushes->rows[i].t > pushes->rows[i - 1].t)) {
			reader->table.line = pushes->rows[i].line;
			return vehicle_table_wrong(&reader->table, "t does not grow", "times that grow from row to row of a body");
		}
	for (size_t i = pushes->count; i-- > 0;)
		pushes->rows[i].end = i + 1 < pushes->count && pushes->rows[i + 1].body == pushes->rows[i].body ? pushes->rows[i + 1].end : i + 1;
	return STATUS_OK;
}

static enum status read(struct vehicle *vehicle, const char *where)
{
	struct reader *reader = mem_calloc(1, sizeof *reader);
	TRY_MEM(reader, "pushes");
	reader->vehicle = vehicle;
	reader->table = (struct vehicle_table){.where = where, .key = "pushes", .path = vehicle->scene->pushes, .most = LINE_MOST};
	enum status status = vehicle_table_open(&reader->table);
	if (status == STATUS_OK) {
		status = read_table(reader, vehicle->pushes);
		vehicle_table_close(&reader->table);
	}
	mem_free(reader);
	return status;
}

enum status vehicle_make_pushes(struct vehicle *vehicle, const char *where)
{
	TRY(mem_zeroed(&vehicle->host_forces, 6 * range_count(vehicle->own.body) + 1, sizeof *vehicle->host_forces, "pushes"));
	if (vehicle->scene->pushes == NULL)
		return STATUS_OK;
	vehicle->pushes = mem_calloc(1, sizeof *vehicle->pushes);
	TRY_MEM(vehicle->pushes, "pushes");
	return read(vehicle, where);
}

void vehicle_free_pushes(struct vehicle *vehicle)
{
	if (vehicle->pushes != NULL)
		mem_free(vehicle->pushes->rows);
	mem_free_all(vehicle->pushes, vehicle->host_forces);
}

/* Adds the mean force of one body's rows between two times. `first`: the first of them. */
static void add_mean(const struct push *rows, size_t first, double from, double to, double *wrench)
{
	const size_t end = rows[first].end;
	size_t low = first, high = end; /* the last row at or before `from` is in [low, high) */
	while (high - low > 1) {
		const size_t middle = low + (high - low) / 2;
		if (rows[middle].t <= from)
			low = middle;
		else
			high = middle;
	}
	for (size_t i = low; i < end && rows[i].t < to; i++) {
		const double begins = fmax(rows[i].t, from), ends = i + 1 < end ? fmin(rows[i + 1].t, to) : to;
		for (int k = 0; k < 6; k++)
			wrench[k] += rows[i].wrench[k] * fmax(ends - begins, 0) / (to - from);
	}
}

void vehicle_push_bodies(struct vehicle *vehicle, double time, double seconds, bool drives)
{
	const struct range bodies = vehicle->own.body;
	const struct pushes *pushes = vehicle->pushes;
	double *wrenches = vehicle->data->xfrc_applied + 6 * bodies.first;
	if (pushes == NULL && !vehicle->host_pushes)
		return;
	mju_zero(wrenches, 6 * (int)range_count(bodies));
	if (!drives)
		return;
	mju_addTo(wrenches, vehicle->host_forces, 6 * (int)range_count(bodies));
	for (size_t first = 0; pushes != NULL && first < pushes->count; first = pushes->rows[first].end)
		add_mean(pushes->rows, first, time, time + seconds, vehicle->data->xfrc_applied + 6 * pushes->rows[first].body);
}

int vehicle_body_by_name(const struct vehicle *vehicle, const char *name)
{
	for (int body = vehicle->own.body.first; body < vehicle->own.body.end; body++) {
		const char *own = vehicle_part_name(vehicle->model, mjOBJ_BODY, body);
		if (own != NULL && strcmp(own, name) == 0)
			return body;
	}
	return -1;
}

/* --- of a host --- */

size_t vehicle_bodies(const struct vehicles *vehicles, size_t index)
{
	return range_count(vehicles->list[index].own.body);
}

const char *vehicle_model_body_name(const struct vehicles *vehicles, size_t index, size_t body)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	const char *name = vehicle_part_name(vehicle->model, mjOBJ_BODY, vehicle->own.body.first + (int)body);
	return name != NULL ? name : "";
}

void vehicle_set_force(struct vehicles *vehicles, size_t index, size_t body, const double force[3], const double torque[3])
{
	struct vehicle *vehicle = &vehicles->list[index];
	mju_copy3(vehicle->host_forces + 6 * body, force);
	mju_copy3(vehicle->host_forces + 6 * body + 3, torque);
	vehicle->host_pushes = true;
}
