/*
 * The ranges of bases and offsets, found without a tile. Ranges of bases never change, so the ones used last are kept. Ranges of
 * offsets change with commits. All are kept, for an owner that needs them as they were before its own changes.
 */
#include "resident/ground_internal.h"

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
	enum status status;
	TRY_OR(done, key_cache_put(&ground->bases, tile_key(tile), range->low, range->high));
	TRY_OR(done, key_cache_put(&ground->errors, tile_key(tile), range->error, 0));
done:
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
	TRY(store_read_base_range(reader, tile, range));
	return keep_base(ground, tile, range);
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

/* --- below level 0 --- */

struct lattice_range {
	int32_t low, high; /* low > high: nothing */
};

/* Widens the range by those posts of a stored tile from which `tile`, below it, is interpolated. Returns true if none of them is missing. */
static bool widen_by_posts(const struct ground *ground, struct tile tile, int level, const int32_t *posts, struct lattice_range *range)
{
	const struct extent *extent = &ground->meta->extent;
	const int shift = level - tile.level;
	const size_t x = (size_t)(tile_within(extent, tile, level, 0) >> shift), y = (size_t)(tile_within(extent, tile, level, 1) >> shift);
	const uint32_t side = lattice_patch_posts(extent->cells, shift), stride = extent->cells + 1;
	return resident_ground_widen(posts + y * stride + x, side, side, stride, &range->low, &range->high);
}

/* The same for the owner (reader NULL), or for another thread. *there is false if another thread's tile was evicted at once. */
static enum status widen_by_tile(struct ground *ground, struct store_reader *reader, struct tile tile, int level,
				 struct lattice_range *range, bool *whole, bool *there)
{
	const struct tile from = tile_ancestor(tile, level);
	const int32_t *posts = NULL;
	enum status status = reader != NULL ? resident_ground_warm(ground, reader, from) : STATUS_OK;
	if (status != STATUS_OK)
		return status;
	mutex_lock(&ground->mutex);
	if (reader == NULL) {
		status = resident_ground_posts_locked(ground, from, &posts);
	} else {
		const uint32_t place = recent_find(&ground->recent, tile_key(from));
		posts = place != RECENT_NONE ? ground->posts[place] : NULL;
	}
	*there = status == STATUS_OK && posts != NULL;
	*whole = *there && widen_by_posts(ground, tile, level, posts, range);
	mutex_unlock(&ground->mutex);
	return status;
}

/* Computes the range of a tile below level 0: of what the store has of it, and of what the rest is interpolated from. */
static enum status fine_range(struct ground *ground, struct store_reader *reader, struct tile tile, struct store_range *range, bool *there)
{
	struct store_reader *const used = reader != NULL ? reader : ground->reader;
	struct lattice_range around = {INT32_MAX, INT32_MIN};
	bool stored, whole = false;
	*there = true;
	*range = (struct store_range){(double)NAN, (double)NAN, 0};
	enum status status = store_find_base_range(used, tile, range, &stored);
	for (int level = tile.level + 1; level <= 0 && !whole && *there && status == STATUS_OK; level++) {
		status = resident_ground_stored(ground, used, tile_ancestor(tile, level), &stored);
		if (status == STATUS_OK && stored)
			status = widen_by_tile(ground, reader, tile, level, &around, &whole, there);
	}
	if (status != STATUS_OK || around.low > around.high)
		return status;
	range->low = fmin(range->low, ground->reference + lattice_base_metres(around.low)); /* fmin ignores NaN */
	range->high = fmax(range->high, ground->reference + lattice_base_metres(around.high));
	return STATUS_OK;
}

/* --- ranges of bases --- */

static enum status find_base_range(struct ground *ground, struct tile tile,
				   struct store_range *range)
{
	bool there;
	if (kept_base(ground, tile, range))
		return STATUS_OK;
	if (tile.level < 0) {
		enum status status = fine_range(ground, NULL, tile, range, &there);
		return status == STATUS_OK && ground->finest < 0 ? keep_base(ground, tile, range) : status;
	}
	double began = clock_seconds();
	enum status status = read_base_range(ground, ground->reader, tile, range);
	count_range_wait(ground, began);
	return status;
}

enum status resident_ground_base_range(struct ground *ground, struct tile tile,
				       struct store_range *range)
{
	const struct relief *relief = ground->relief;
	enum status status = find_base_range(ground, tile, range);
	if (status != STATUS_OK)
		return status;
	range->high += rocks_bound(ground->rocks);
	range->error += rocks_error(ground->rocks, tile.level);
	if (!relief_any(relief))
		return status;
	range->low -= relief_bound(relief, 0);
	range->high += relief_bound(relief, 0);
	range->error += 3 * relief_rms(relief, tile.level);
	return STATUS_OK;
}

enum status resident_ground_range(struct ground *ground, struct tile tile, double *low, double *high, bool *any)
{
	struct store_range range;
	TRY(resident_ground_base_range(ground, tile, &range));
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
	if (key->tile.level >= 0 || ground->finest < 0)
		return false;
	mutex_lock(&ground->mutex);
	bool found = recent_find(&ground->recent, tile_key(tile_ancestor(key->tile, 0))) != RECENT_NONE;
	mutex_unlock(&ground->mutex);
	return found;
}

static enum status warm_fine_range(struct ground *ground, struct store_reader *reader, struct tile tile)
{
	struct store_range range;
	bool there;
	enum status status = fine_range(ground, reader, tile, &range, &there);
	/* If the owner evicted a tile at once, it finds the range itself. */
	return status == STATUS_OK && there ? keep_base(ground, tile, &range) : status;
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
