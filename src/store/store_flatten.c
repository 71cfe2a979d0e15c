/*
 * Flattens a chain of overlays into one plain store.
 *
 *   the chain, read as it is at one moment -> every row that counts -> PATH.part -> published
 *
 * Rows are copied with their blobs, hashes and revisions. No post is decoded, and no coarser level is made anew: each row of the chain
 * is the row of the whole already. The base is copied from the plain store at the end of the chain.
 *
 * Invariants:
 *   1. Each row's hash is checked while it is copied. The copied base has the hash that the chain's headers name.
 *   2. The new file is made beside its name and renamed, so it is whole or absent. No file of the chain is written or replaced.
 */
#include "store/internal.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

struct flattening {
	struct store *from, *to;
	enum row_table table; /* being copied */
	int64_t done, total;  /* rows of all tables */
	store_progress_fn progress;
	void *user;
};

static enum status copy_row(void *user, const struct row_entry *entry)
{
	struct flattening *flattening = user;
	struct rows *from = store_table(flattening->from, flattening->table);
	struct tile tile = tile_from_key(entry->key);
	if (!extent_has(from->extent, tile) || tile_key(tile) != entry->key)
		return fail_with(STATUS_INPUT, "%s: it has a tile outside its terrain; the store is damaged, restore it", from->path);
	enum status status = store_rows_copy(from, &flattening->to->rows, flattening->table, tile, entry->revision);
	flattening->done++;
	if (status == STATUS_OK && flattening->progress != NULL)
		status = flattening->progress(flattening->user, flattening->done, flattening->total);
	return status;
}

static enum status copy_rows(struct flattening *flattening)
{
	struct store *from = flattening->from;
	enum status status = STATUS_OK;
	for (int table = 0; table < ROW_TABLES && status == STATUS_OK; table++) {
		int64_t rows = 0, bytes;
		status = store_rows_count(store_table(from, (enum row_table)table), (enum row_table)table, &rows, &bytes);
		flattening->total += rows;
	}
	for (int table = 0; table < ROW_TABLES && status == STATUS_OK; table++) {
		flattening->table = (enum row_table)table;
		status = store_rows_each(store_table(from, flattening->table), flattening->table, 0, INT64_MAX, copy_row, flattening);
	}
	return status;
}

/* The headers of the chain name the base by a hash. Checks that its rows have that hash, before anything is published. */
static enum status check_base(struct flattening *flattening)
{
	struct store *to = flattening->to;
	uint64_t hash;
	to->meta.low = flattening->from->meta.low;
	to->meta.high = flattening->from->meta.high;
	enum status status = store_identity_compute(to, &hash);
	if (status == STATUS_OK && hash != flattening->from->base_hash)
		status = fail_with(STATUS_INPUT, "%s: its base rows are not those that its header names (base_hash %016llx, not %016llx); restore it, "
				   "or import it again", store_base_path(flattening->from), (unsigned long long)hash,
				   (unsigned long long)flattening->from->base_hash);
	return status;
}

static enum status copy_run(struct flattening *flattening)
{
	struct store_run_copy run = {0};
	enum status status = store_run_copy(flattening->from, &run);
	if (status == STATUS_OK)
		status = store_overlay_begin_as(flattening->to, flattening->from, &run, "flatten");
	store_run_copy_finish(&run);
	return status;
}

/* `out` is not a file that is being read. */
static enum status check_out(const struct store *from, const char *out)
{
	char there[PATH_MAX];
	if (from->under == NULL)
		return fail_with(STATUS_INPUT, "%s: it is a store of its own, and flat already; copy the file", from->path);
	if (realpath(out, there) == NULL) /* it is not there yet; store_create tells what else is wrong */
		return STATUS_OK;
	for (const struct store *file = from; file != NULL; file = file->under)
		if (strcmp(file->real_path, there) == 0)
			return fail_with(STATUS_INPUT, "%s: it is a file of the chain that is to be flattened; give another name", out);
	return STATUS_OK;
}

enum status store_flatten(const char *path, const char *out, bool overwrite, store_progress_fn progress, void *user)
{
	struct flattening flattening = {.progress = progress, .user = user};
	enum status status = store_open(path, &(struct store_options){.mode = STORE_READ}, &flattening.from);
	if (status == STATUS_OK)
		status = check_out(flattening.from, out);
	if (status == STATUS_OK)
		status = store_overlay_hold(flattening.from, flattening.from->db);
	if (status == STATUS_OK)
		status = store_create(out, &flattening.from->meta, overwrite, &flattening.to);
	if (status == STATUS_OK)
		status = copy_rows(&flattening);
	if (status == STATUS_OK)
		status = check_base(&flattening);
	if (status == STATUS_OK)
		status = copy_run(&flattening);
	if (status == STATUS_OK)
		status = store_publish(flattening.to);
	store_close(flattening.to);
	store_close(flattening.from);
	return status;
}
