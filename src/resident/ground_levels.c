/*
 * Base heights of any level, from tiles that the store has.
 *
 * Below level 0 a tile may be stored in part, where an inset lies, or not at all. A post has the
 * value of the finest level that gives one. Its own level gives one if the post is stored. A
 * coarser level gives one if it has all posts around; it is interpolated between them, and raised
 * by relief. Rocks are added at every level. So the value depends on the post alone, and tiles that share it agree.
 */
#include "resident/ground_internal.h"

#include <assert.h>
#include <math.h>
#include <string.h>

/* Without memory to keep the answer it is looked up again. */
enum status resident_ground_stored(struct ground *ground, struct store_reader *reader, struct tile tile, bool *stored)
{
	struct key_pair known;
	struct store_range range;
	bool found;
	*stored = tile.level >= 0;
	if (tile.level >= 0 || tile.level < ground->finest)
		return STATUS_OK;
	mutex_lock(&ground->mutex);
	found = key_cache_find(&ground->stored, tile_key(tile), &known, &found) == STATUS_OK && found;
	mutex_unlock(&ground->mutex);
	if (found) {
		*stored = known.a != 0;
		return STATUS_OK;
	}
	TRY(store_find_base_range(reader, tile, &range, stored));
	mutex_lock(&ground->mutex);
	const enum status status = key_cache_put(&ground->stored, tile_key(tile), *stored ? 1 : 0, 0);
	mutex_unlock(&ground->mutex);
	return status;
}

enum status resident_ground_has_base(struct ground *ground, struct tile tile, bool *stored)
{
	return resident_ground_stored(ground, ground->reader, tile, stored);
}

/* Gives the posts of a tile that have no value yet those that a level has. raised: room for relief, or NULL. *left: posts without a value. */
static enum status fill_from(struct ground *ground, struct tile tile, int level, int32_t *raised, int32_t *posts, size_t *left)
{
	const struct extent *extent = &ground->meta->extent;
	const struct tile from = tile_ancestor(tile, level);
	const int32_t *there;
	bool stored;
	TRY(resident_ground_has_base(ground, from, &stored));
	if (!stored)
		return STATUS_OK;
	if (raised != NULL)
		TRY(relief_heights(ground->relief, tile.level, level, tile_post_rect(extent, tile), raised));
	enum status status;
	mutex_lock(&ground->mutex);
	TRY_OR(done, resident_ground_posts_locked(ground, from, &there));
	if (level == tile.level)
		memcpy(posts, there, tile_posts(extent) * (size_t)tile_posts(extent) * sizeof *posts);
	*left = lattice_fill(there, extent->cells, level - tile.level, tile_within(extent, tile, level, 0), tile_within(extent, tile, level, 1), raised,
			     posts);
done:
	mutex_unlock(&ground->mutex);
	return status;
}

enum status resident_ground_posts(struct ground *ground, struct tile tile, int32_t *posts)
{
	const struct extent *extent = &ground->meta->extent;
	const size_t side = tile_posts(extent), count = side * side;
	const int coarsest = tile.level > 0 ? tile.level : 0;
	enum status status = STATUS_OK;
	size_t left = count;
	int32_t *raised = relief_has_level(ground->relief, tile.level)
				  ? mem_alloc(count, sizeof *raised)
				  : NULL;
	if (raised == NULL && relief_has_level(ground->relief, tile.level))
		return fail_memory("relief");
	for (size_t i = 0; i < count; i++)
		posts[i] = BASE_NODATA;
	for (int level = tile.level; level <= coarsest && left > 0; level++)
		TRY_OR(done, fill_from(ground, tile, level, raised, posts, &left));
	TRY_OR(done, rocks_add(ground->rocks, tile.level, tile_post_rect(extent, tile), posts));
done:
	mem_free(raised);
	return status;
}

enum status resident_ground_patch(struct ground *ground, struct tile tile, int32_t *patch, int *shift, uint32_t *sub_x,
			 uint32_t *sub_y)
{
	assert(tile.level < 0);
	const struct extent *extent = &ground->meta->extent;
	const uint32_t stride = extent->cells + 1;
	*shift = 0;
	*sub_x = *sub_y = 0;
	if (ground->rocks != NULL || (relief_any(ground->relief) && ground->relief->classes > 1))
		return resident_ground_posts(ground, tile, patch);
	for (int level = ground->finest > tile.level ? ground->finest : tile.level; level < 0; level++) {
		bool stored;
		TRY(resident_ground_has_base(ground, tile_ancestor(tile, level), &stored));
		if (stored)
			return resident_ground_posts(ground, tile, patch);
	}
	*shift = -tile.level;
	/* x and y: the tile's first post, in 2^-shift cells of level 0, within its tile of level 0. */
	const uint64_t x = tile_within(extent, tile, 0, 0), y = tile_within(extent, tile, 0, 1), part = ((uint64_t)1 << *shift) - 1;
	*sub_x = (uint32_t)(x & part);
	*sub_y = (uint32_t)(y & part);
	const uint32_t side = lattice_patch_posts(extent->cells, *shift);
	const int32_t *posts;
	enum status status;
	mutex_lock(&ground->mutex);
	TRY_OR(done, resident_ground_posts_locked(ground, tile_ancestor(tile, 0), &posts));
	for (uint32_t row = 0; row < side; row++)
		memcpy(patch + (size_t)row * side, posts + (size_t)((y >> *shift) + row) * stride + (x >> *shift), side * sizeof *patch);
done:
	mutex_unlock(&ground->mutex);
	return status;
}

/* --- the highest post of a rectangle --- */

bool resident_ground_widen(const int32_t *posts, uint32_t width, uint32_t height, uint32_t stride, int32_t *low, int32_t *high)
{
	bool whole = true;
	for (uint32_t y = 0; y < height; y++)
		for (uint32_t x = 0; x < width; x++) {
			int32_t post = posts[(size_t)y * stride + x];
			whole &= post != BASE_NODATA;
			if (post == BASE_NODATA)
				continue;
			*low = post < *low ? post : *low;
			*high = post > *high ? post : *high;
		}
	return whole;
}

/* Returns the posts of a coarser level from which a rectangle is interpolated. */
static struct post_rect around(struct post_rect rect, int shift)
{
	int64_t up = ((int64_t)1 << shift) - 1;
	return (struct post_rect){rect.x0 >> shift, rect.y0 >> shift, ((rect.x1 - 1 + up) >> shift) + 1,
				  ((rect.y1 - 1 + up) >> shift) + 1};
}

/* Finds the fewest tiles that hold all posts of first .. end - 1. A post on an edge is in two tiles. */
static void tiles_over(int64_t first, int64_t end, int64_t cells, int64_t tiles, uint32_t range[2])
{
	int64_t low = first / cells, high = end - first > 1 ? (end - 2) / cells : low;
	range[0] = (uint32_t)(low < tiles ? low : tiles - 1);
	range[1] = (uint32_t)(high < tiles ? high : tiles - 1);
}

/* Widens low .. high by the posts that a tile has of a rectangle. *whole becomes false if it lacks one. */
static enum status widen_by_tile(struct ground *ground, struct tile tile, struct post_rect rect, int32_t *low, int32_t *high, bool *whole)
{
	const struct extent *extent = &ground->meta->extent;
	const struct post_rect own = tile_post_rect(extent, tile), in = post_rect_intersect(rect, own);
	const size_t stride = (size_t)extent->cells + 1;
	const int32_t *posts;
	bool stored;
	TRY(resident_ground_has_base(ground, tile, &stored));
	*whole &= stored;
	if (!stored)
		return STATUS_OK;
	enum status status;
	mutex_lock(&ground->mutex);
	TRY_OR(done, resident_ground_posts_locked(ground, tile, &posts));
	*whole &= resident_ground_widen(posts + (size_t)(in.y0 - own.y0) * stride + (size_t)(in.x0 - own.x0), (uint32_t)(in.x1 - in.x0),
					(uint32_t)(in.y1 - in.y0), (uint32_t)stride, low, high);
done:
	mutex_unlock(&ground->mutex);
	return status;
}

/* Widens low .. high by the posts that level `from` has of a rectangle. *whole: it has all of them. */
static enum status widen_by_level(struct ground *ground, int from, struct post_rect rect, int32_t *low, int32_t *high, bool *whole)
{
	const struct extent *extent = &ground->meta->extent;
	const int64_t cells = extent->cells;
	uint32_t across[2], up[2];
	tiles_over(rect.x0, rect.x1, cells, extent_tiles_x(extent, from), across);
	tiles_over(rect.y0, rect.y1, cells, extent_tiles_y(extent, from), up);
	*whole = true;
	for (uint32_t y = up[0]; y <= up[1]; y++)
		for (uint32_t x = across[0]; x <= across[1]; x++)
			TRY(widen_by_tile(ground, (struct tile){from, x, y}, rect, low, high, whole));
	return STATUS_OK;
}

enum status resident_ground_highest(struct ground *ground, int level, struct post_rect rect, int64_t *highest)
{
	const struct extent *extent = &ground->meta->extent;
	int32_t lowest = INT32_MAX, most = INT32_MIN;
	bool whole = false;
	enum status status = STATUS_OK;
	*highest = INT64_MIN;
	rect = post_rect_intersect(rect, (struct post_rect){0, 0, extent_posts(extent->width, level), extent_posts(extent->height, level)});
	if (post_rect_empty(rect))
		return STATUS_OK;
	if (level >= 0)
		TRY_OR(done, widen_by_level(ground, level, rect, &lowest, &most, &whole));
	for (int from = ground->finest > level ? ground->finest : level; from <= 0 && level < 0 && !whole; from++)
		TRY_OR(done, widen_by_level(ground, from, around(rect, from - level), &lowest, &most, &whole));
done:
	if (lowest <= most)
		*highest = (int64_t)most * (1 << (OFFSET_BITS - BASE_BITS)) +
			   (int64_t)ground->reference * (1 << OFFSET_BITS) +
			   (level < 0 ? lattice_offset(relief_bound(ground->relief, 0)) : 0) + lattice_offset(rocks_bound(ground->rocks));
	return status;
}

/* --- the height at a point --- */

/* Finds the cell of a level that contains (x, y), in posts of this level. The point is within the world. The last cell includes
 * the world's edge. */
static void cell_of(const struct extent *extent, int level, double x, double y, int64_t cell[2])
{
	const int64_t last[2] = {extent_posts(extent->width, level) - 2, extent_posts(extent->height, level) - 2};
	cell[0] = (int64_t)x < last[0] ? (int64_t)x : last[0];
	cell[1] = (int64_t)y < last[1] ? (int64_t)y : last[1];
}

struct tile resident_ground_tile_of(const struct extent *extent, int level, double x, double y)
{
	int64_t cell[2];
	cell_of(extent, level, ldexp(x, -level), ldexp(y, -level), cell);
	return (struct tile){level, (uint32_t)(cell[0] / extent->cells), (uint32_t)(cell[1] / extent->cells)};
}

struct tile resident_ground_tile(const struct extent *extent, double x, double y)
{
	return resident_ground_tile_of(extent, 0, x, y);
}

/* Gives post (x, y) of a level as a tile of another one has it, without relief. BASE_NODATA: it lacks one around it. */
static enum status post_within(struct ground *ground, struct tile tile, int shift, int64_t x, int64_t y, int32_t *post)
{
	const uint64_t cells = ground->meta->extent.cells;
	const int32_t *posts;
	enum status status;
	mutex_lock(&ground->mutex);
	TRY_OR(done, resident_ground_posts_locked(ground, tile, &posts));
	*post = lattice_finer(posts, (uint32_t)cells + 1, shift, (uint64_t)x - ((uint64_t)tile.x * cells << shift),
			      (uint64_t)y - ((uint64_t)tile.y * cells << shift));
done:
	mutex_unlock(&ground->mutex);
	return status;
}

/* Gives a post of a level at most zero: of the finest level that has it, or has all posts around.
 * BASE_NODATA: none has. */
static enum status post_at(struct ground *ground, int level, int64_t x, int64_t y, int32_t *post)
{
	const struct extent *extent = &ground->meta->extent;
	const int64_t cells = extent->cells;
	*post = BASE_NODATA;
	for (int from = ground->finest > level ? ground->finest : level; from <= 0; from++) {
		const int shift = from - level;
		int64_t cell[2];
		int32_t raised;
		bool stored;
		cell_of(extent, from, ldexp((double)x, -shift), ldexp((double)y, -shift), cell);
		const struct tile tile = {from, (uint32_t)(cell[0] / cells),
					  (uint32_t)(cell[1] / cells)};
		TRY(resident_ground_has_base(ground, tile, &stored));
		if (!stored)
			continue;
		TRY(relief_heights(ground->relief, level, from, (struct post_rect){x, y, x + 1, y + 1}, &raised));
		TRY(post_within(ground, tile, shift, x, y, post));
		if (*post != BASE_NODATA) {
			*post += raised;
			return rocks_add(ground->rocks, level, (struct post_rect){x, y, x + 1, y + 1}, post);
		}
	}
	return STATUS_OK;
}

/* Returns the level down to which relief or rocks raise posts; 1: there are none. */
static int raised_finest(const struct ground *ground)
{
	const int relief = relief_any(ground->relief) ? ground->relief->finest : 1, rocks = ground->rocks != NULL ? ground->rocks->finest : 1;
	return rocks < relief ? rocks : relief;
}

/* Interpolates between the four posts of that level around (x, y), in posts of level 0.
 * NaN: one that has weight has no data. */
static enum status height_of_raised(struct ground *ground, double x, double y, double *sum)
{
	const int level = raised_finest(ground);
	const double px = ldexp(x, -level), py = ldexp(y, -level);
	int64_t cell[2];
	double corners[4];
	cell_of(&ground->meta->extent, level, px, py, cell);
	for (int i = 0; i < 4; i++) {
		int32_t post;
		TRY(post_at(ground, level, cell[0] + i % 2, cell[1] + i / 2, &post));
		corners[i] = post == BASE_NODATA ? (double)NAN : post;
	}
	*sum = lattice_bilinear(corners, px - (double)cell[0], py - (double)cell[1], 0);
	return STATUS_OK;
}

/* Interpolates between the four posts of a level around (x, y), in posts of level 0. NaN: the level lacks one that has weight. */
static enum status height_of_level(struct ground *ground, int level, double x, double y, double *sum)
{
	const struct extent *extent = &ground->meta->extent;
	const struct tile tile = resident_ground_tile_of(extent, level, x, y);
	const int64_t cells = extent->cells;
	int64_t cell[2];
	double corners[4], px = ldexp(x, -level), py = ldexp(y, -level);
	int32_t rocks[4] = {0};
	const int32_t *posts;
	bool stored;
	*sum = (double)NAN;
	TRY(resident_ground_has_base(ground, tile, &stored));
	if (!stored)
		return STATUS_OK;
	cell_of(extent, level, px, py, cell);
	if (ground->rocks != NULL)
		rocks_heights(ground->rocks, level, (struct post_rect){cell[0], cell[1], cell[0] + 2, cell[1] + 2}, rocks);
	enum status status;
	mutex_lock(&ground->mutex);
	TRY_OR(done, resident_ground_posts_locked(ground, tile, &posts));
	for (int i = 0; i < 4; i++) {
		int32_t post = posts[(cell[1] % cells + i / 2) * (cells + 1) + cell[0] % cells + i % 2];
		corners[i] = post == BASE_NODATA ? (double)NAN : post + rocks[i];
	}
	*sum = lattice_bilinear(corners, px - (double)cell[0], py - (double)cell[1], 0);
done:
	mutex_unlock(&ground->mutex);
	return status;
}

enum status resident_ground_height(struct ground *ground, int64_t x, int64_t y, int64_t *height, bool *any)
{
	const struct extent *extent = &ground->meta->extent;
	double px = lattice_offset_metres(x) / extent->spacing, py = lattice_offset_metres(y) / extent->spacing, sum = (double)NAN;
	*any = false;
	if (px < 0 || py < 0 || px > (double)(extent->width - 1) || py > (double)(extent->height - 1))
		return STATUS_OK;
	const int raised = raised_finest(ground), last = raised - 1; /* that level, and coarser ones, are not stored whole */
	for (int level = ground->finest; level <= last && isnan(sum); level++)
		TRY(height_of_level(ground, level, px, py, &sum));
	if (isnan(sum) && raised <= 0)
		TRY(height_of_raised(ground, px, py, &sum));
	if (isnan(sum))
		return STATUS_OK;
	*height = (int64_t)floor(sum * (1 << (OFFSET_BITS - BASE_BITS)) + 0.5) + (int64_t)ground->reference * (1 << OFFSET_BITS);
	*any = true;
	return STATUS_OK;
}
