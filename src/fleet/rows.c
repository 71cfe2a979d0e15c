/*
 * Rows of objects.csv. Each rank has the rows of its own bodies. Rank 0 gets them with each exchange and writes them as one process does: in
 * the order of time, then of bodies. It writes a row when no rank can have one that comes before it.
 */
#include "fleet/internal.h"

#include <stdlib.h>

static enum status add(struct fleet_row_list *list, const struct fleet_row *row)
{
	struct fleet_row *rows = fleet_grown(list->rows, &list->room, list->count + 1, sizeof *rows);
	if (rows == NULL)
		return fail_memory("rows");
	list->rows = rows;
	list->rows[list->count++] = *row;
	return STATUS_OK;
}

static enum status take_row(void *user, const struct world_row *row)
{
	struct fleet *fleet = user;
	return add(&fleet->given, &(struct fleet_row){
		.time = row->time,
		.slip = row->slip,
		.position = {row->position[0], row->position[1], row->position[2]},
		.body = (int64_t)row->body,
		.force = row->force,
		.soil = row->soil,
	});
}

static enum status flush(void *user)
{
	(void)user; /* fleet_rows_write does */
	return STATUS_OK;
}

const struct world_rows *fleet_rows(struct fleet *fleet, const struct world_rows *rows)
{
	fleet->rows = rows;
	fleet->sink = (struct world_rows){.user = fleet, .row = take_row, .flush = flush};
	return &fleet->sink;
}

enum status fleet_rows_put(struct fleet *fleet)
{
	const uint32_t count = (uint32_t)fleet->given.count;
	enum status status = fleet_put(&fleet->sent, &count, sizeof count);
	if (status == STATUS_OK)
		status = fleet_put(&fleet->sent, fleet->given.rows, count * sizeof *fleet->given.rows);
	fleet->given.count = 0;
	return status;
}

enum status fleet_rows_get(struct fleet *fleet, struct fleet_bytes *bytes)
{
	uint32_t count;
	enum status status = fleet_get(bytes, &count, sizeof count);
	for (uint32_t i = 0; i < count && status == STATUS_OK; i++) {
		struct fleet_row row;
		status = fleet_get(bytes, &row, sizeof row);
		if (status == STATUS_OK && fleet->rank == 0)
			status = add(&fleet->waiting, &row);
	}
	return status;
}

static int before(const void *a, const void *b)
{
	const struct fleet_row *x = a, *y = b;
	if (x->time != y->time)
		return x->time < y->time ? -1 : 1;
	return (x->body > y->body) - (x->body < y->body);
}

enum status fleet_rows_write(struct fleet *fleet, double until)
{
	struct fleet_row_list *waiting = &fleet->waiting;
	enum status status = STATUS_OK;
	size_t written = 0;
	if (fleet->rows == NULL || waiting->count == 0)
		return STATUS_OK;
	qsort(waiting->rows, waiting->count, sizeof *waiting->rows, before);
	for (; written < waiting->count && waiting->rows[written].time <= until && status == STATUS_OK; written++) {
		const struct fleet_row *from = &waiting->rows[written];
		struct world_row row = {
			.time = from->time,
			.body = (size_t)from->body,
			.slip = from->slip,
			.position = {from->position[0], from->position[1], from->position[2]},
			.soil = from->soil,
			.force = from->force,
		};
		if (!world_ranked(fleet->world, row.body))
			return fail_with(STATUS_FAILED, "ranks: a row came of a body that there is not; report this");
		row.object = world_body(fleet->world, row.body)->object;
		status = fleet->rows->row(fleet->rows->user, &row);
	}
	for (size_t i = written; i < waiting->count; i++)
		waiting->rows[i - written] = waiting->rows[i];
	waiting->count -= written;
	return status == STATUS_OK ? fleet->rows->flush(fleet->rows->user) : status;
}

void fleet_rows_finish(struct fleet *fleet)
{
	mem_free(fleet->given.rows);
	mem_free(fleet->waiting.rows);
}
