/*
 * What a query needs of the ground: which tiles exist, and how high and low they are. Ranges come from the store. A tile that
 * the store may not have yet is only known to have changed.
 *
 * Invariant: `changed` describes the moment when it was found. A page leaves it only for the store, with the same bits. So it
 * stays true until the ground changes, however commits proceed.
 */
#include <math.h>
#include <stdlib.h>

#include "resident/newest_internal.h"

enum { RANGES = 1 << 16, BASE_TILES = 4 };

/* --- what changed --- */

static void note_changed(void *user, uint64_t key)
{
	struct newest *newest = user;
	if (tile_from_key(key).level != newest->level)
		return;
	if (newest->changed_count == newest->changed_room) {
		size_t room = newest->changed_room > 0 ? 2 * newest->changed_room : 64;
		uint64_t *keys = mem_realloc(newest->changed, room, sizeof *keys);
		if (keys == NULL) {
			newest->lost = true;
			return;
		}
		newest->changed = keys;
		newest->changed_room = room;
	}
	newest->changed[newest->changed_count++] = key;
}

static int compare(const void *a, const void *b)
{
	const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
	return x < y ? -1 : x > y;
}

static bool has_changed(const struct newest *newest, struct tile tile)
{
	uint64_t first, last;
	size_t low = 0, high = newest->changed_count;
	if (high == 0)
		return false;
	tile_descendants(tile, newest->level, &first, &last);
	while (low < high) {
		size_t middle = low + (high - low) / 2;
		if (newest->changed[middle] < first)
			low = middle + 1;
		else
			high = middle;
	}
	return low < newest->changed_count && newest->changed[low] <= last;
}

void resident_newest_changed(struct newest *newest)
{
	if (newest != NULL)
		newest->settled = false;
}

enum status resident_newest_settle(struct newest *newest)
{
	if (newest->pages == NULL || newest->settled)
		return STATUS_OK;
	newest->changed_count = 0;
	newest->lost = false;
	key_cache_finish(&newest->offsets);
	newest->offsets = (struct key_cache){.most = RANGES};
	resident_newest_forget_tiles(newest);
	page_cache_each_changed(newest->pages->cache, note_changed, newest);
	if (newest->lost)
		return fail_memory("what changed, for a query");
	if (newest->changed_count > 0)
		qsort(newest->changed, newest->changed_count, sizeof *newest->changed, compare);
	newest->settled = true;
	return STATUS_OK;
}

/* --- ranges --- */

static enum status stored_offsets(struct newest *newest, struct tile tile, struct key_pair *range)
{
	bool found;
	enum status status = key_cache_find(&newest->offsets, tile_key(tile), range, &found);
	if (status != STATUS_OK || found)
		return status;
	status = store_read_offset_range(resident_ground_reader(newest->base), tile, &range->a, &range->b, &found);
	if (status != STATUS_OK)
		return status;
	if (!found)
		range->a = range->b = NAN;
	return key_cache_put(&newest->offsets, tile_key(tile), range->a, range->b);
}

static enum status base_range(struct newest *newest, struct tile tile, struct key_pair *range)
{
	bool found, any = false;
	enum status status = key_cache_find(&newest->bases, tile_key(tile), range, &found);
	if (status != STATUS_OK || found)
		return status;
	status = resident_ground_range(newest->base, tile, &range->a, &range->b, &any);
	if (status != STATUS_OK)
		return status;
	if (!any)
		range->a = range->b = NAN;
	return key_cache_put(&newest->bases, tile_key(tile), range->a, range->b);
}

static enum status bounds(void *user, struct tile tile, double *low, double *high, bool *any)
{
	struct newest *newest = user;
	struct key_pair base, offset = {.a = NAN};
	enum status status = base_range(newest, tile, &base);
	if (status != STATUS_OK)
		return status;
	*any = !isnan(base.a);
	*low = base.a;
	*high = base.b;
	if (!*any || !newest->deformed)
		return STATUS_OK;
	const struct tile held = tile.level < newest->level ? tile_ancestor(tile, newest->level) : tile;
	if (has_changed(newest, held)) {
		*low = -INFINITY;
		*high = INFINITY;
		return STATUS_OK;
	}
	status = stored_offsets(newest, held, &offset);
	if (status == STATUS_OK && !isnan(offset.a)) {
		*low += fmin(offset.a, 0);
		*high += fmax(offset.b, 0);
	}
	return status;
}

/* --- which tiles exist --- */

static enum status present(void *user, struct tile tile, bool *out)
{
	struct newest *newest = user;
	enum status status = STATUS_OK;
	*out = false;
	if (!extent_has(newest->extent, tile))
		return STATUS_OK;
	if (!has_changed(newest, tile)) {
		struct key_pair range;
		status = stored_offsets(newest, tile, &range);
		*out = status == STATUS_OK && !isnan(range.a);
		return status;
	}
	if (tile.level == newest->level) {
		/* It was touched, but may be unchanged: then the store will have no such tile. */
		const struct resident_newest_tile *held;
		status = resident_newest_tile(newest, tile, &held);
		*out = status == STATUS_OK && held->offsets;
		return status;
	}
	for (unsigned i = 0; i < 4 && status == STATUS_OK && !*out; i++)
		status = present(newest, (struct tile){tile.level - 1, 2 * tile.x + (i & 1), 2 * tile.y + (i >> 1)}, out);
	return status;
}

static enum status posts(void *user, struct tile tile, struct terrain_posts *out)
{
	const struct resident_newest_tile *held;
	enum status status = resident_newest_tile(user, tile, &held);
	if (status == STATUS_OK)
		*out = (struct terrain_posts){held->heights, (const double(*)[2])held->blocks};
	return status;
}

/* --- life --- */

enum status resident_newest_create(struct store *store, struct pages *pages, struct newest **out)
{
	const struct store_meta *meta = store_meta(store);
	struct newest *newest = mem_calloc(1, sizeof *newest);
	if (newest == NULL)
		return fail_memory("queries");
	*newest = (struct newest){
		.store = store,
		.pages = pages,
		.extent = &meta->extent,
		.fits = isnan(meta->low) || lattice_fits(meta->low, meta->high),
		.offsets = {.most = RANGES},
		.bases = {.most = RANGES},
	};
	newest->deformed = store_has_working_level(store, &newest->level);
	if (newest->deformed && newest->level > -TILE_LEVEL_MIN) {
		enum status refused = fail_with(STATUS_INPUT, "query: offsets of level %d are too coarse to be divided down to level "
						"0; give a store deformed at level %d or finer", newest->level, -TILE_LEVEL_MIN);
		mem_free(newest);
		return refused;
	}
	newest->ground = (struct terrain_ground){
		.user = newest,
		.extent = newest->extent,
		.finest = newest->deformed && newest->level < 0 ? newest->level : 0,
		.posts = posts,
		.present = present,
		.bounds = bounds,
	};
	enum status status = resident_newest_create_tiles(newest);
	if (status == STATUS_OK)
		status = resident_ground_create(store, BASE_TILES, &newest->base);
	if (status != STATUS_OK) {
		resident_newest_destroy(newest);
		return status;
	}
	*out = newest;
	return STATUS_OK;
}

void resident_newest_destroy(struct newest *newest)
{
	if (newest == NULL)
		return;
	resident_newest_destroy_tiles(newest);
	resident_ground_destroy(newest->base);
	key_cache_finish(&newest->offsets);
	key_cache_finish(&newest->bases);
	mem_free(newest->changed);
	mem_free(newest);
}

enum status resident_newest_heights(struct newest *newest, const struct terrain_point *points, size_t count, struct terrain_height *heights)
{
	enum status status = resident_newest_settle(newest);
	return status == STATUS_OK ? terrain_heights(&newest->ground, points, count, heights) : status;
}

enum status resident_newest_rays(struct newest *newest, const struct terrain_ray *rays, size_t count, struct terrain_hit *hits)
{
	enum status status = resident_newest_settle(newest);
	return status == STATUS_OK ? terrain_rays(&newest->ground, rays, count, hits) : status;
}
