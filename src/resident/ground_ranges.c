/*
 * The ranges of bases and offsets, found without a tile. Ranges of bases never change, so the ones used last are kept. Ranges of
 * offsets change with commits. All are kept, for an owner that needs them as they were before its own changes.
 */
#include "resident/ground_internal.h"

#include <assert.h>
#include <math.h>

/* --- what is kept --- */

/* Without memory to move a key to the younger half, the range counts as absent and is read again. */
static bool kept(struct ground *ground, struct key_cache *cache, struct tile tile, struct key_pair *pair)
{
	bool found;
	mutex_lock(&ground->mutex);
	found = key_cache_find(cache, tile_key(tile), pair, &found) == STATUS_OK && found;
	mutex_unlock(&ground->mutex);
	return found;
}

static bool kept_base(struct ground *ground, struct tile tile, struct store_range *range)
{
	struct key_pair base, error;
	if (!kept(ground, &ground->bases, tile, &base) || !kept(ground, &ground->errors, tile, &error))
		return false;
	*range = (struct store_range){.low = base.a, .high = base.b, .error = error.a};
	return true;
}

static enum status keep_base(struct ground *ground, struct tile tile, const struct store_range *range)
{
	mutex_lock(&ground->mutex);
	enum status status = key_cache_put(&ground->bases, tile_key(tile), range->low, range->high);
	if (status == STATUS_OK)
		status = key_cache_put(&ground->errors, tile_key(tile), range->error, 0);
	mutex_unlock(&ground->mutex);
	return status;
}

/* --- looking up --- */

/* Counts a wait: the owner read a range itself, since `began`, s. */
static void count_range_wait(struct ground *ground, double began)
{
	mutex_lock(&ground->mutex);
	ground->figures.range_waits++;
	ground->figures.range_wait_ms += (clock_seconds() - began) * 1e3;
	mutex_unlock(&ground->mutex);
}

static enum status read_base_range(struct ground *ground, struct store_reader *reader, struct tile tile, struct store_range *range)
{
	mutex_lock(&ground->mutex);
	ground->figures.ranges++;
	mutex_unlock(&ground->mutex);
	enum status status = store_read_base_range(reader, tile, range);
	return status == STATUS_OK ? keep_base(ground, tile, range) : status;
}

static enum status read_offset_range(struct ground *ground, struct store_reader *reader, struct tile tile, struct key_pair *range)
{
	bool found;
	mutex_lock(&ground->mutex);
	const uint64_t forgotten = ground->forgotten;
	mutex_unlock(&ground->mutex);
	enum status status = store_read_offset_range(reader, tile, &range->a, &range->b, &found);
	mutex_lock(&ground->mutex);
	ground->figures.offset_ranges++;
	if (status == STATUS_OK && !found)
		range->a = range->b = NAN;
	/* If all were forgotten meanwhile, this one may be from before. */
	if (status == STATUS_OK && forgotten == ground->forgotten)
		status = key_cache_put(&ground->offsets, tile_key(tile), range->a, range->b);
	mutex_unlock(&ground->mutex);
	return status;
}

enum status resident_ground_base_range(struct ground *ground, struct tile tile, struct store_range *range)
{
	assert(tile.level >= 0);
	if (kept_base(ground, tile, range))
		return STATUS_OK;
	double began = clock_seconds();
	enum status status = read_base_range(ground, ground->reader, tile, range);
	count_range_wait(ground, began);
	return status;
}

enum status resident_ground_offset_range(struct ground *ground, struct tile tile, double *low, double *high, bool *found)
{
	struct key_pair range = {.a = NAN};
	enum status status = STATUS_OK;
	if (!kept(ground, &ground->offsets, tile, &range)) {
		double began = clock_seconds();
		status = read_offset_range(ground, ground->reader, tile, &range);
		count_range_wait(ground, began);
	}
	*found = status == STATUS_OK && !isnan(range.a);
	*low = *found ? fmin(range.a, 0) : 0;
	*high = *found ? fmax(range.b, 0) : 0;
	return status;
}

void resident_ground_forget_offsets(struct ground *ground)
{
	mutex_lock(&ground->mutex);
	key_cache_finish(&ground->offsets);
	ground->forgotten++;
	mutex_unlock(&ground->mutex);
}

/* Computes the range of a tile below level 0 from the posts of its level-0 tile. NaN: all is nodata. */
static void range_of_posts(const struct ground *ground, struct tile tile, const int32_t *posts, struct store_range *range)
{
	uint32_t cells = ground->meta->extent.cells;
	uint64_t x = (uint64_t)tile.x * cells >> -tile.level, y = (uint64_t)tile.y * cells >> -tile.level;
	uint32_t side = lattice_patch_posts(cells, -tile.level);
	int32_t lowest = INT32_MAX, highest = INT32_MIN;
	resident_ground_widen(posts + (size_t)(y & (cells - 1)) * (cells + 1) + (x & (cells - 1)), side, side, cells + 1, &lowest, &highest);
	*range = (struct store_range){.low = NAN, .high = NAN, .error = 0};
	if (lowest > highest)
		return;
	range->low = ground->reference + lattice_base_metres(lowest);
	range->high = ground->reference + lattice_base_metres(highest);
}

enum status resident_ground_range(struct ground *ground, struct tile tile, double *low, double *high, bool *any)
{
	struct store_range range;
	enum status status = STATUS_OK;
	if (tile.level >= 0) {
		status = resident_ground_base_range(ground, tile, &range);
	} else if (!kept_base(ground, tile, &range)) {
		const int32_t *posts;
		mutex_lock(&ground->mutex);
		status = resident_ground_posts_locked(ground, tile_ancestor(tile, 0), &posts);
		if (status == STATUS_OK)
			range_of_posts(ground, tile, posts, &range);
		mutex_unlock(&ground->mutex);
	}
	if (status != STATUS_OK)
		return status;
	*low = range.low;
	*high = range.high;
	*any = !isnan(range.low);
	return STATUS_OK;
}

/* --- ranges that other threads load --- */

bool resident_ground_has_range(struct ground *ground, const struct ground_range_key *key)
{
	struct key_pair pair;
	struct store_range range;
	if (key->kind == GROUND_OFFSETS)
		return kept(ground, &ground->offsets, key->tile, &pair);
	if (kept_base(ground, key->tile, &range))
		return true;
	if (key->tile.level >= 0)
		return false;
	mutex_lock(&ground->mutex);
	bool found = recent_find(&ground->recent, tile_key(tile_ancestor(key->tile, 0))) != RECENT_NONE;
	mutex_unlock(&ground->mutex);
	return found;
}

static enum status warm_fine_range(struct ground *ground, struct store_reader *reader, struct tile tile)
{
	struct store_range range;
	const struct tile top = tile_ancestor(tile, 0);
	enum status status = resident_ground_warm(ground, reader, top);
	if (status != STATUS_OK)
		return status;
	mutex_lock(&ground->mutex);
	const uint32_t place = recent_find(&ground->recent, tile_key(top));
	if (place != RECENT_NONE)
		range_of_posts(ground, tile, ground->posts[place], &range);
	mutex_unlock(&ground->mutex);
	/* If the owner evicted it at once, it reads the tile itself. */
	return place != RECENT_NONE ? keep_base(ground, tile, &range) : STATUS_OK;
}

enum status resident_ground_warm_range(struct ground *ground, struct store_reader *reader, const struct ground_range_key *key)
{
	struct store_range range;
	struct key_pair pair;
	if (key->kind == GROUND_BASE) {
		if (kept_base(ground, key->tile, &range))
			return STATUS_OK;
		return key->tile.level < 0 ? warm_fine_range(ground, reader, key->tile) : read_base_range(ground, reader, key->tile, &range);
	}
	return kept(ground, &ground->offsets, key->tile, &pair) ? STATUS_OK : read_offset_range(ground, reader, key->tile, &pair);
}
