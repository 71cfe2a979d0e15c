/*
 * Puts base tiles into a store that is being made. It commits after a certain number of bytes or seconds.
 *
 * Committed tiles survive a killed process and a power failure, since commits are synced. Packing a tile is a separate function
 * that needs no store, so several threads can pack.
 */
#include "store/internal.h"

#include <assert.h>

#define COMMIT_SECONDS 2.0

struct store_packer {
	struct codec ground, small; /* `small` only of a small store: the shorter blob is taken */
	bool is_small;
	struct extent extent;
	uint8_t children;
};

enum status store_packer_create(const struct store_meta *meta, struct store_packer **out)
{
	struct store_packer *packer = mem_calloc(1, sizeof *packer);
	TRY_MEM(packer, "packing tiles");
	packer->extent = meta->extent;
	packer->is_small = meta->pack == STORE_PACK_SMALL;
	enum status status;
	TRY_OR(failed, store_codec_init(&packer->ground, tile_posts(&meta->extent), CODEC_GROUND));
	if (packer->is_small)
		TRY_OR(failed, store_codec_init(&packer->small, tile_posts(&meta->extent), CODEC_SMALL));
	*out = packer;
	return STATUS_OK;
failed:
	store_packer_destroy(packer);
	return status;
}

void store_packer_destroy(struct store_packer *packer)
{
	if (packer == NULL)
		return;
	store_codec_finish(&packer->ground);
	store_codec_finish(&packer->small);
	mem_free(packer);
}

size_t store_packed_most(const struct store_packer *packer)
{
	return store_codec_bound(&packer->ground);
}

struct store_packed store_pack(struct store_packer *packer, struct tile tile, const int32_t *codes)
{
	struct store_packed packed;
	if (store_below_has(tile)) {
		packer->children = store_below_children(&packer->extent, tile);
		return (struct store_packed){CODEC_BELOW, &packer->children, 1};
	}
	packed.codec = store_codec_encode(&packer->ground, codes, &packed.bytes, &packed.size);
	if (packer->is_small) {
		struct store_packed other;
		other.codec = store_codec_encode(&packer->small, codes, &other.bytes, &other.size);
		packed = other.size < packed.size ? other : packed;
	}
	return packed;
}

enum status store_put_begin(struct store *store)
{
	store->uncommitted = 0;
	store->committed = clock_seconds();
	return store_sql_exec(store->db, store->path, "making the store", "BEGIN EXCLUSIVE");
}

static enum status commit(struct store *store)
{
	TRY(store_misfit_write(store));
	return store_sql_exec(store->db, store->path, "writing it", "COMMIT");
}

enum status store_put_packed(struct store *store, struct tile tile, const struct store_packed *packed,
			     const struct store_range *range)
{
	assert(store->part_path != NULL && extent_has(&store->meta.extent, tile));
	struct row row = {
		.tile = tile,
		.low = range->low,
		.high = range->high,
		.error = range->error,
		.codec = packed->codec,
		.bytes = packed->bytes,
		.size = packed->size,
	};
	row.hash = store_rows_hash(ROW_BASE, &row);
	TRY(store_rows_put(&store->rows, ROW_BASE, &row));
	store->uncommitted += (int64_t)packed->size;
	bool due = store->uncommitted >= store->commit_bytes || clock_seconds() - store->committed >= COMMIT_SECONDS;
	if (!due)
		return STATUS_OK;
	TRY(commit(store));
	return store_put_begin(store);
}

enum status store_put_base(struct store *store, struct tile tile, const int32_t *codes,
			   const struct store_range *range)
{
	struct store_packed packed;
	packed.codec = store_codec_encode(&store->rows.codec, codes, &packed.bytes, &packed.size);
	return store_put_packed(store, tile, &packed, range);
}

enum status store_get_base(struct store *store, struct tile tile, int32_t *codes, struct store_range *range, bool *found)
{
	struct row row;
	TRY(store_rows_read(&store->rows, ROW_BASE, tile, codes, &row, found));
	if (*found && range != NULL)
		*range = (struct store_range){row.low, row.high, row.error};
	return STATUS_OK;
}

enum status store_suspend(struct store *store)
{
	assert(store->part_path != NULL);
	enum status status = commit(store);
	struct failure failure;
	failure_capture(&failure, status);
	store->keeps_part = store->keeps_part || status == STATUS_OK;
	store_close(store);
	return status == STATUS_OK ? STATUS_OK : failure_restore(&failure);
}
