/*
 * Copies what a store shows into one plain store.
 *
 *   the store, read as it is at one moment -> every row that counts -> PATH.part -> published
 *
 * Rows are copied with their blobs, hashes and revisions. No post is decoded, and no coarser level is made anew: each row of a chain of
 * overlays is the row of the whole already. The base is copied from the plain store at the end of the chain.
 *
 * Invariants:
 *   1. Each row's hash is checked while it is copied. The copied base has the hash that the headers name.
 *   2. The new file is made beside its name and renamed, so it is whole or absent.
 */
#include "store/internal.h"

struct copying {
	struct store *from, *to;
	enum row_table table; /* being copied */
	int64_t done, total;  /* rows of all tables */
	const char *what;
	store_progress_fn progress;
	void *user;
};

static enum status copy_row(void *user, const struct row_entry *entry)
{
	struct copying *copying = user;
	struct rows *from = store_table(copying->from, copying->table);
	struct tile tile = tile_from_key(entry->key);
	if (!extent_has(from->extent, tile) || tile_key(tile) != entry->key)
		return fail_with(STATUS_INPUT, "%s: it has a tile outside its terrain; the store is damaged, restore it", from->path);
	TRY(store_rows_copy(from, &copying->to->rows, copying->table, tile, entry->revision));
	copying->done++;
	if (copying->progress != NULL)
		TRY(copying->progress(copying->user, copying->done, copying->total));
	return STATUS_OK;
}

static enum status copy_rows(struct copying *copying)
{
	struct store *from = copying->from;
	for (int table = 0; table < ROW_TABLES; table++) {
		int64_t rows = 0, bytes;
		TRY(store_rows_count(store_table(from, (enum row_table)table), (enum row_table)table, &rows, &bytes));
		copying->total += rows;
	}
	for (int table = 0; table < ROW_TABLES; table++) {
		copying->table = (enum row_table)table;
		TRY(store_rows_each(store_table(from, copying->table), copying->table, 0, INT64_MAX, copy_row, copying));
	}
	return STATUS_OK;
}

/* Headers name the base by a hash. Checks that its rows have that hash, before anything is published. */
static enum status check_base(struct copying *copying)
{
	struct store *to = copying->to;
	uint64_t hash;
	to->meta.low = copying->from->meta.low;
	to->meta.high = copying->from->meta.high;
	TRY(store_identity_compute(to, &hash));
	if (hash != copying->from->base_hash)
		return fail_with(STATUS_INPUT, "%s: its base rows are not those that its header names (base_hash %016llx, not %016llx); restore it, "
				 "or import it again", copying->from->base->path, (unsigned long long)hash,
				 (unsigned long long)copying->from->base_hash);
	return STATUS_OK;
}

static enum status copy_run(struct copying *copying)
{
	struct store_run_copy run = {0};
	enum status status;
	TRY_OR(done, store_run_copy(copying->from, &run));
	TRY_OR(done, store_overlay_begin_as(copying->to, copying->from, &run, copying->what));
done:
	store_run_copy_finish(&run);
	return status;
}

enum status store_copy(struct store *from, const char *out, enum store_overwrite overwrite, const char *what, bool imagery, store_progress_fn progress, void *user)
{
	struct copying copying = {.from = from, .what = what, .progress = progress, .user = user};
	enum status status;
	TRY_OR(done, store_overlay_hold(from, from->db));
	TRY_OR(done, store_create(out, &from->meta, overwrite, &copying.to));
	TRY_OR(done, copy_rows(&copying));
	TRY_OR(done, check_base(&copying));
	TRY_OR(done, copy_run(&copying));
	if (imagery)
		TRY_OR(done, store_imagery_copy(from, copying.to));
	TRY_OR(done, store_publish(copying.to));
done:
	store_close(copying.to);
	return status;
}
