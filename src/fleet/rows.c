/*
 * Rows of objects.csv. Each rank has the rows of its own bodies. Rank 0 gets them with each exchange and writes them as one process does: in
 * the order of time, then of bodies. It writes a row when no rank can have one that comes before it.
 */
#include "fleet/internal.h"

#include <stdlib.h>

#define ROWS_AT_ONCE 64 /* that are written together */

static enum status add(struct fleet_row_list *list, const struct fleet_row *row)
{
	TRY(mem_grow(&list->rows, &list->room, list->count + 1, sizeof *list->rows, "rows"));
	list->rows[list->count++] = *row;
	return STATUS_OK;
}

enum status fleet_rows_take(void *user, const struct world_row *rows, size_t count)
{
	struct fleet *fleet = user;
	for (const struct world_row *row = rows; row < rows + count; row++)
		TRY(add(&fleet->given, &(struct fleet_row){
			.time = row->time,
			.slip = row->slip,
			.position = {row->position[0], row->position[1], row->position[2]},
			.body = (int64_t)row->body,
			.force = row->force,
			.aboard = row->aboard,
			.soil = row->soil,
		}));
	return STATUS_OK;
}

void fleet_rows(struct fleet *fleet, const struct report_rows *rows)
{
	fleet->rows = rows;
}

enum status fleet_rows_put(struct fleet *fleet)
{
	const uint32_t count = (uint32_t)fleet->given.count;
	fleet->given.count = 0;
	TRY(fleet_put(&fleet->sent, &count, sizeof count));
	return fleet_put(&fleet->sent, fleet->given.rows, count * sizeof *fleet->given.rows);
}

enum status fleet_rows_get(struct fleet *fleet, struct fleet_bytes *bytes)
{
	uint32_t count;
	TRY(fleet_get(bytes, &count, sizeof count));
	for (uint32_t i = 0; i < count; i++) {
		struct fleet_row row;
		TRY(fleet_get(bytes, &row, sizeof row));
		if (fleet->rank == 0)
			TRY(add(&fleet->waiting, &row));
	}
	return STATUS_OK;
}

static int before(const void *a, const void *b)
{
	const struct fleet_row *x = a, *y = b;
	if (x->time != y->time)
		return x->time < y->time ? -1 : 1;
	return (x->body > y->body) - (x->body < y->body);
}

static enum status write_some(struct fleet *fleet, const struct fleet_row *from, size_t count)
{
	struct world_row rows[ROWS_AT_ONCE];
	for (size_t i = 0; i < count; i++) {
		rows[i] = (struct world_row){
			.time = from[i].time,
			.body = (size_t)from[i].body,
			.slip = from[i].slip,
			.position = {from[i].position[0], from[i].position[1], from[i].position[2]},
			.soil = from[i].soil,
			.force = from[i].force,
			.aboard = from[i].aboard,
		};
		if (world_body(fleet->world, rows[i].body) == NULL) /* one that is lifted by now has rows, too */
			return fail_with(STATUS_FAILED, "ranks: a row came of a body that there is not; report this");
		rows[i].object = world_body(fleet->world, rows[i].body)->object;
	}
	return report_rows_write(fleet->rows, rows, count);
}

enum status fleet_rows_write(struct fleet *fleet, double until)
{
	struct fleet_row_list *waiting = &fleet->waiting;
	size_t written = 0, due = 0;
	if (fleet->rows == NULL || waiting->count == 0)
		return STATUS_OK;
	qsort(waiting->rows, waiting->count, sizeof *waiting->rows, before);
	while (due < waiting->count && waiting->rows[due].time <= until)
		due++;
	enum status status = STATUS_OK;
	while (written < due && status == STATUS_OK) { /* rows are not written a second time, also if this fails */
		const size_t count = due - written < ROWS_AT_ONCE ? due - written : ROWS_AT_ONCE;
		status = write_some(fleet, waiting->rows + written, count);
		written += count;
	}
	for (size_t i = written; i < waiting->count; i++)
		waiting->rows[i - written] = waiting->rows[i];
	waiting->count -= written;
	return status;
}

void fleet_rows_finish(struct fleet *fleet)
{
	mem_free_all(fleet->given.rows, fleet->waiting.rows);
}
