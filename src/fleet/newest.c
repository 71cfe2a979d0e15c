/* Lists that all ranks have, and of which each rank knows some rows: how high the ground of tiles is, and probes of bodies. Each row is taken from the rank that knows it. */
#include "fleet/internal.h"

struct rows {
	const struct fleet *fleet;
	const char *what; /* comes for what, for a message */
	const void *keys; /* what its rows are of, for `knows` */
	char *list;
	size_t count, size; /* rows; bytes of a row */
	bool (*knows)(const struct rows *rows, size_t at); /* this rank */
};

static enum status get_rows(void *user, int rank, struct fleet_bytes *bytes)
{
	const struct rows *rows = user;
	uint32_t count;
	(void)rank; /* this rank's own are in the list already, with the same bytes */
	TRY(fleet_get(bytes, &count, sizeof count));
	for (uint32_t i = 0; i < count; i++) {
		uint32_t at;
		TRY(fleet_get(bytes, &at, sizeof at));
		if (at >= rows->count)
			return fail_with(STATUS_FAILED, "ranks: %s that was not asked for; report this", rows->what);
		TRY(fleet_get(bytes, rows->list + at * rows->size, rows->size));
	}
	return STATUS_OK;
}

static enum status put_rows(struct fleet *fleet, enum fleet_kind kind, const struct rows *rows)
{
	uint32_t known = 0;
	for (size_t i = 0; i < rows->count; i++)
		known += rows->knows(rows, i);
	TRY(fleet_begin(fleet, kind, STATUS_OK));
	TRY(fleet_put(&fleet->sent, &known, sizeof known));
	for (size_t i = 0; i < rows->count; i++) {
		const uint32_t at = (uint32_t)i;
		if (!rows->knows(rows, i))
			continue;
		TRY(fleet_put(&fleet->sent, &at, sizeof at));
		TRY(fleet_put(&fleet->sent, rows->list + i * rows->size, rows->size));
	}
	return STATUS_OK;
}

static enum status share(struct fleet *fleet, enum fleet_kind kind, struct rows *rows, enum status status)
{
	struct fleet_told told;
	if (fleet->failed)
		return status;
	if (status == STATUS_OK)
		status = put_rows(fleet, kind, rows);
	return fleet_tell(fleet, kind, status, &told, get_rows, rows);
}

/* It changed the tile last. A tile that no rank has changed is the same on all. */
static bool has_newest(const struct rows *rows, size_t at)
{
	const uint64_t *keys = rows->keys;
	return fleet_is_changed(rows->fleet, keys[at]);
}

enum status fleet_newest(void *user, size_t count, const uint64_t *keys, double *numbers, enum status status)
{
	struct rows rows = {user, "a number came for a tile", keys, (char *)numbers, count, sizeof *numbers, has_newest};
	return share(user, FLEET_NEWEST, &rows, status);
}

static bool is_here(const struct rows *rows, size_t at)
{
	const int32_t *numbers = rows->keys;
	const struct body *body = world_body(rows->fleet->world, (size_t)numbers[at]);
	return body != NULL && body->kind != BODY_PATH && !body->elsewhere;
}

enum status fleet_probed(void *user, size_t count, const int32_t *numbers, struct furrow_contact *contacts, enum status status)
{
	struct rows rows = {user, "a contact came for a body", numbers, (char *)contacts, count, sizeof *contacts, is_here};
	return share(user, FLEET_PROBE, &rows, status);
}
