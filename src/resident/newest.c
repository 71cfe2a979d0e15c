/*
 * What a query needs of the ground: which tiles exist, and how high and low they are. Ranges come from the store. A tile that
 * the store may not have yet is only known to have changed.
 *
 * Invariant: `changed` describes the moment when it was found. A page leaves it only for the store, with the same bits. So it
 * stays true until the ground changes, however commits proceed.
 */
#include <math.h>

#include "resident/ground_internal.h"
#include "resident/newest_internal.h"

enum { RANGES = 1 << 16, BASE_TILES = 4 };

/* --- what changed --- */

static void note_changed(void *user, uint64_t key)
{
	struct newest *newest = user;
	const struct tile tile = tile_from_key(key);
	if (tile.level == newest->level && newest->noted == STATUS_OK)
		newest->noted = resident_bounds_add(&newest->changed, tile, -INFINITY, INFINITY);
}

static bool has_changed(const struct newest *newest, struct tile tile)
{
	double low = 0, high = 0;
	return resident_bounds_widen(&newest->changed, tile, &low, &high);
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
	newest->noted = STATUS_OK;
	resident_bounds_clear(&newest->changed);
	resident_ground_forget_offsets(newest->base);
	resident_newest_forget_tiles(newest);
	page_cache_each_changed(newest->pages->cache, note_changed, newest);
	if (newest->noted != STATUS_OK)
		return newest->noted;
	newest->settled = true;
	return STATUS_OK;
}

/* --- ranges --- */

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
	struct key_pair base;
	TRY(base_range(newest, tile, &base));
	*any = !isnan(base.a);
	*low = base.a;
	*high = base.b;
	if (!*any || !newest->deformed)
		return STATUS_OK;
	const struct tile held = tile.level < newest->level ? tile_ancestor(tile, newest->level) : tile;
	if (resident_bounds_widen(&newest->changed, held, low, high)) /* then the store's range is of no use */
		return STATUS_OK;
	double lowest, highest;
	bool found;
	TRY(resident_ground_offset_range(newest->base, held, &lowest, &highest, &found));
	*low += lowest;
	*high += highest;
	return STATUS_OK;
}

/* --- which tiles exist --- */

static enum status present(void *user, struct tile tile, bool *out)
{
	struct newest *newest = user;
	const struct relief *relief = store_relief(newest->store);
	*out = false;
	if (!extent_has(newest->extent, tile))
		return STATUS_OK;
	const struct rocks *rocks = store_rocks(newest->store);
	*out = (relief_any(relief) && tile.level >= relief->finest) || (rocks != NULL && tile.level >= rocks->finest);
	if (*out)
		return STATUS_OK;
	enum status status = resident_ground_has_base(newest->base, tile, out);
	if (status != STATUS_OK || *out || !newest->deformed || tile.level < newest->level)
		return status;
	if (!has_changed(newest, tile)) {
		double low, high;
		return resident_ground_offset_range(newest->base, tile, &low, &high, out);
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

static enum status posts(void *user, struct tile tile, struct resident_posts *out)
{
	const struct resident_newest_tile *held;
	TRY(resident_newest_tile(user, tile, &held));
	*out = (struct resident_posts){held->heights, (const double(*)[2])held->blocks};
	return STATUS_OK;
}

/* --- life --- */

enum status resident_newest_create(struct store *store, struct pages *pages, struct newest **out)
{
	const struct store_meta *meta = store_meta(store);
	struct newest *newest = mem_calloc(1, sizeof *newest);
	TRY_MEM(newest, "queries");
	*newest = (struct newest){
		.store = store,
		.pages = pages,
		.extent = &meta->extent,
		.fits = isnan(meta->low) || lattice_fits(meta->low, meta->high),
		.changed = {.extent = &meta->extent},
		.bases = {.most = RANGES},
	};
	newest->deformed = store_has_working_level(store, &newest->level);
	const int base = store_finest_base(store);
	if (newest->deformed && newest->level - base > -TILE_LEVEL_MIN) {
		enum status refused = fail_with(STATUS_INPUT, "query: offsets of level %d are too coarse to be divided down to level "
						"%d; give a store deformed at level %d or finer", newest->level, base,
						base - TILE_LEVEL_MIN);
		mem_free(newest);
		return refused;
	}
	newest->ground = (struct resident_source){
		.user = newest,
		.extent = newest->extent,
		.finest = newest->fits ? store_finest(store) : 0,
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
	newest->base->offsets.most = RANGES; /* they may be dropped: any later value is as good */
	*out = newest;
	return STATUS_OK;
}

void resident_newest_destroy(struct newest *newest)
{
	if (newest == NULL)
		return;
	resident_newest_destroy_tiles(newest);
	resident_ground_destroy(newest->base);
	key_cache_finish(&newest->bases);
	resident_bounds_finish(&newest->changed);
	mem_free(newest);
}

enum status resident_newest_heights(struct newest *newest, const struct resident_point *points, size_t count, struct resident_height *heights)
{
	TRY(resident_newest_settle(newest));
	return resident_heights(&newest->ground, points, count, heights);
}

enum status resident_newest_rays(struct newest *newest, const struct resident_ray *rays, size_t count, struct resident_hit *hits)
{
	TRY(resident_newest_settle(newest));
	return resident_rays(&newest->ground, rays, count, hits);
}
