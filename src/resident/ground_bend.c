/*
 * How far the triangles between posts are off the ground that is bilinear between them. Let a cell have the posts a, b in the south
 * and c, d in the north. The difference is largest at its middle: |a - b - c + d| / 4. A level finer by one has a quarter of it.
 */
#include "resident/ground_internal.h"

#include <math.h>
#include <stdlib.h>

/* Returns the largest |a - b - c + d| of side x side posts, in 2^-18 m. Rows are `stride` posts apart. *whole: all posts have data.
 * Cells without are left out. */
static int64_t twist_of(const int32_t *posts, uint32_t side, size_t stride, bool *whole)
{
	int64_t most = 0;
	*whole = true;
	for (uint32_t y = 0; y + 1 < side; y++)
		for (uint32_t x = 0; x + 1 < side; x++) {
			const int32_t *south = posts + y * stride + x, *north = south + stride;
			if (south[0] == BASE_NODATA || south[1] == BASE_NODATA || north[0] == BASE_NODATA || north[1] == BASE_NODATA) {
				*whole = false;
				continue;
			}
			const int64_t twist = llabs(((int64_t)south[0] - south[1]) - ((int64_t)north[0] - north[1]));
			most = twist > most ? twist : most;
		}
	return most;
}

/* Finds it for the cells of `tile`, from those posts of the tile of `level` above it that are around them. */
static enum status bend_by(struct ground *ground, struct tile tile, int level, double *bend, bool *whole)
{
	const struct extent *extent = &ground->meta->extent;
	const int shift = level - tile.level;
	const size_t x = (size_t)(tile_within(extent, tile, level, 0) >> shift), y = (size_t)(tile_within(extent, tile, level, 1) >> shift);
	const size_t stride = extent->cells + 1;
	const int32_t *posts;
	mutex_lock(&ground->mutex);
	enum status status;
	TRY_OR(done, resident_ground_posts_locked(ground, tile_ancestor(tile, level), &posts));
	const int64_t twist = twist_of(posts + y * stride + x, lattice_patch_posts(extent->cells, shift), stride, whole);
	*bend = fmax(*bend, ldexp(lattice_base_metres(twist) / 4, -2 * shift));
done:
	mutex_unlock(&ground->mutex);
	return status;
}

enum status resident_ground_bend(struct ground *ground, struct tile tile, double *bend)
{
	struct key_pair known;
	bool found = false, whole = false;
	*bend = 0;
	mutex_lock(&ground->mutex);
	enum status status = key_cache_find(&ground->bends, tile_key(tile), &known, &found);
	mutex_unlock(&ground->mutex);
	if (status != STATUS_OK || found) {
		*bend = found ? known.a : 0;
		return status;
	}
	for (int level = tile.level; level <= 0 && !whole && status == STATUS_OK; level++) {
		bool stored;
		status = resident_ground_has_base(ground, tile_ancestor(tile, level), &stored);
		if (status == STATUS_OK && stored)
			status = bend_by(ground, tile, level, bend, &whole);
	}
	if (status != STATUS_OK)
		return status;
	mutex_lock(&ground->mutex);
	status = key_cache_put(&ground->bends, tile_key(tile), *bend, 0);
	mutex_unlock(&ground->mutex);
	return status;
}

bool resident_ground_has_bend(struct ground *ground, struct tile tile)
{
	struct key_pair known;
	bool found = false;
	mutex_lock(&ground->mutex);
	found = (key_cache_find(&ground->bends, tile_key(tile), &known, &found) == STATUS_OK && found) ||
		(ground->finest == 0 && recent_find(&ground->recent, tile_key(tile_ancestor(tile, 0))) != RECENT_NONE);
	mutex_unlock(&ground->mutex);
	return found;
}
