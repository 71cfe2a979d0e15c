/*
 * Keeps the posts of recently used tiles in memory. The owner's thread uses them; a second thread, the warming thread, may read
 * tiles ahead. Each place holds the posts of one tile.
 *
 * Invariants of the data that the mutex guards:
 * - The posts of a place without a tile have no meaning. The posts of every other place are complete.
 * - `latest` is the place that the owner used last, or RECENT_NONE at the start. Only a read by the owner may replace its tile.
 * - Posts are read and changed only while the mutex is held.
 *
 * Reading a tile takes long. So the warming thread reads into a spare buffer without the mutex. Then it exchanges this buffer with
 * the buffer of a place. Only the owner keeps the mutex while it reads, since no other thread is more urgent.
 */
#include "resident/ground_internal.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#define RANGES 16384 /* number of tiles whose height range stays in memory: about as many as a few pictures need */

int32_t resident_ground_reference(const struct store *store)
{
	const struct store_meta *meta = store_meta(store);
	return isnan(meta->low) ? 0 : lattice_reference(meta->low, meta->high);
}

enum status resident_ground_create(struct store *store, uint32_t tiles, struct ground **out)
{
	struct ground *ground = mem_calloc(1, sizeof *ground);
	if (ground == NULL)
		return fail_memory("the ground");
	assert(tiles >= 1);
	mutex_init(&ground->mutex);
	ground->bases.most = ground->errors.most = RANGES;
	ground->offsets.most = SIZE_MAX;
	ground->meta = store_meta(store);
	ground->reference = resident_ground_reference(store);
	ground->latest = RECENT_NONE;
	ground->posts = mem_calloc(tiles, sizeof *ground->posts);
	enum status status = ground->posts != NULL ? recent_create(&ground->recent, tiles) : fail_memory("the ground");
	if (status == STATUS_OK)
		status = store_reader_create(store, &ground->reader);
	if (status != STATUS_OK) {
		resident_ground_destroy(ground);
		return status;
	}
	*out = ground;
	return STATUS_OK;
}

void resident_ground_destroy(struct ground *ground)
{
	if (ground == NULL)
		return;
	for (uint32_t i = 0; i < ground->recent.count; i++)
		mem_free(ground->posts[i]);
	mem_free(ground->posts);
	recent_finish(&ground->recent);
	mem_free(ground->spare);
	key_cache_finish(&ground->bases);
	key_cache_finish(&ground->errors);
	key_cache_finish(&ground->offsets);
	mutex_finish(&ground->mutex);
	store_reader_destroy(ground->reader);
	mem_free(ground);
}

struct store_reader *resident_ground_reader(struct ground *ground)
{
	return ground->reader;
}

static int32_t *alloc_posts(const struct ground *ground)
{
	size_t side = tile_posts(&ground->meta->extent);
	return mem_alloc(side * side, sizeof(int32_t));
}

static enum status read_posts(const struct ground *ground, struct store_reader *reader, struct tile tile, int32_t *posts)
{
	size_t side = tile_posts(&ground->meta->extent), count = side * side;
	struct store_range range;
	enum status status = store_read_base(reader, tile, posts, &range);
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		posts[i] = lattice_base_relative(height_code_metres(posts[i], ground->meta->step), ground->reference);
	return status;
}

/* Only the owner calls it, with the mutex held. The posts stay in memory while the mutex is held. */
enum status resident_ground_posts_locked(struct ground *ground, struct tile tile, const int32_t **posts)
{
	assert(tile.level >= 0);
	uint64_t key = tile_key(tile);
	uint32_t place = recent_find(&ground->recent, key);
	if (place == RECENT_NONE) {
		double began = clock_seconds();
		place = recent_oldest(&ground->recent, RECENT_NONE);
		if (ground->posts[place] == NULL && (ground->posts[place] = alloc_posts(ground)) == NULL)
			return fail_memory("a base tile");
		recent_empty(&ground->recent, place); /* has no tile until the read is complete */
		enum status status = read_posts(ground, ground->reader, tile, ground->posts[place]);
		if (status != STATUS_OK)
			return status;
		ground->figures.reads++;
		ground->figures.waits++;
		ground->figures.wait_ms += (clock_seconds() - began) * 1e3;
	}
	recent_use(&ground->recent, place, key);
	ground->latest = place;
	*posts = ground->posts[place];
	return STATUS_OK;
}

enum status resident_ground_posts(struct ground *ground, struct tile tile, int32_t *posts)
{
	size_t side = tile_posts(&ground->meta->extent);
	const int32_t *there;
	mutex_lock(&ground->mutex);
	enum status status = resident_ground_posts_locked(ground, tile, &there);
	if (status == STATUS_OK)
		memcpy(posts, there, side * side * sizeof *posts);
	mutex_unlock(&ground->mutex);
	return status;
}

enum status resident_ground_patch(struct ground *ground, struct tile tile, int32_t *patch, int *shift, uint32_t *sub_x,
			 uint32_t *sub_y)
{
	assert(tile.level < 0);
	uint32_t cells = ground->meta->extent.cells, mask = cells - 1, stride = cells + 1;
	*shift = -tile.level;
	/* x and y: the tile's first post, in 2^-shift cells of level 0. From this come the cell within the level-0 tile (cx, cy), and
	 * the place within that cell (sub_x, sub_y). */
	uint64_t x = (uint64_t)tile.x * cells, y = (uint64_t)tile.y * cells, part = ((uint64_t)1 << *shift) - 1;
	uint32_t cx = (uint32_t)(x >> *shift) & mask, cy = (uint32_t)(y >> *shift) & mask;
	*sub_x = (uint32_t)(x & part);
	*sub_y = (uint32_t)(y & part);
	uint32_t side = lattice_patch_posts(cells, *shift);
	const int32_t *posts;
	mutex_lock(&ground->mutex);
	enum status status = resident_ground_posts_locked(ground, tile_ancestor(tile, 0), &posts);
	for (uint32_t row = 0; row < side && status == STATUS_OK; row++)
		memcpy(patch + (size_t)row * side, posts + (size_t)(cy + row) * stride + cx, side * sizeof *patch);
	mutex_unlock(&ground->mutex);
	return status;
}

void resident_ground_widen(const int32_t *posts, uint32_t width, uint32_t height, uint32_t stride, int32_t *low, int32_t *high)
{
	for (uint32_t y = 0; y < height; y++)
		for (uint32_t x = 0; x < width; x++) {
			int32_t post = posts[(size_t)y * stride + x];
			if (post == BASE_NODATA)
				continue;
			*low = post < *low ? post : *low;
			*high = post > *high ? post : *high;
		}
}

/* Returns the posts of level 0 from which a rectangle of a finer level is interpolated. */
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

enum status resident_ground_highest(struct ground *ground, int level, struct post_rect rect, int64_t *highest)
{
	const struct extent *extent = &ground->meta->extent;
	const int from = level > 0 ? level : 0;
	const int64_t cells = extent->cells;
	int32_t lowest = INT32_MAX, most = INT32_MIN;
	*highest = INT64_MIN;
	rect = post_rect_intersect(rect, (struct post_rect){0, 0, extent_posts(extent->width, level), extent_posts(extent->height, level)});
	if (post_rect_empty(rect))
		return STATUS_OK;
	rect = around(rect, from - level);
	uint32_t across[2], up[2];
	tiles_over(rect.x0, rect.x1, cells, extent_tiles_x(extent, from), across);
	tiles_over(rect.y0, rect.y1, cells, extent_tiles_y(extent, from), up);
	enum status status = STATUS_OK;
	for (uint32_t y = up[0]; y <= up[1] && status == STATUS_OK; y++)
		for (uint32_t x = across[0]; x <= across[1] && status == STATUS_OK; x++) {
			const struct tile tile = {from, x, y};
			const struct post_rect own = {x * cells, y * cells, (x + 1) * cells + 1, (y + 1) * cells + 1};
			const struct post_rect in = post_rect_intersect(rect, own);
			const int32_t *posts;
			mutex_lock(&ground->mutex);
			status = resident_ground_posts_locked(ground, tile, &posts);
			if (status == STATUS_OK)
				resident_ground_widen(posts + (size_t)(in.y0 - own.y0) * (size_t)(cells + 1) + (size_t)(in.x0 - own.x0),
				      (uint32_t)(in.x1 - in.x0), (uint32_t)(in.y1 - in.y0), (uint32_t)cells + 1, &lowest, &most);
			mutex_unlock(&ground->mutex);
		}
	if (lowest <= most)
		*highest = (int64_t)most * (1 << (OFFSET_BITS - BASE_BITS)) + (int64_t)ground->reference * (1 << OFFSET_BITS);
	return status;
}

/* Finds the level-0 cell for a height at (x, y), within the world. The last cell includes the world's edge. */
static void cell_of(const struct extent *extent, double x, double y, int64_t *cx, int64_t *cy)
{
	*cx = (int64_t)x < extent->width - 1 ? (int64_t)x : extent->width - 2;
	*cy = (int64_t)y < extent->height - 1 ? (int64_t)y : extent->height - 2;
}

struct tile resident_ground_tile(const struct extent *extent, double x, double y)
{
	int64_t cx, cy;
	cell_of(extent, x, y, &cx, &cy);
	return (struct tile){0, (uint32_t)(cx / extent->cells), (uint32_t)(cy / extent->cells)};
}

enum status resident_ground_height(struct ground *ground, int64_t x, int64_t y, int64_t *height, bool *any)
{
	const struct extent *extent = &ground->meta->extent;
	double px = lattice_offset_metres(x) / extent->spacing, py = lattice_offset_metres(y) / extent->spacing;
	*any = false;
	if (px < 0 || py < 0 || px > (double)(extent->width - 1) || py > (double)(extent->height - 1))
		return STATUS_OK;
	int64_t cx, cy, cells = extent->cells;
	cell_of(extent, px, py, &cx, &cy);
	double u = px - (double)cx, v = py - (double)cy;
	const int32_t *posts;
	double corners[4];
	mutex_lock(&ground->mutex);
	enum status status = resident_ground_posts_locked(ground, resident_ground_tile(extent, px, py), &posts);
	for (int i = 0; i < 4 && status == STATUS_OK; i++) {
		int32_t post = posts[(cy % cells + i / 2) * (cells + 1) + cx % cells + i % 2];
		corners[i] = post == BASE_NODATA ? (double)NAN : post;
	}
	mutex_unlock(&ground->mutex);
	if (status != STATUS_OK)
		return status;
	const double sum = lattice_bilinear(corners, u, v, 0);
	if (isnan(sum))
		return STATUS_OK;
	*height = (int64_t)floor(sum * (1 << (OFFSET_BITS - BASE_BITS)) + 0.5) + (int64_t)ground->reference * (1 << OFFSET_BITS);
	*any = true;
	return STATUS_OK;
}

void resident_ground_figures(struct ground *ground, struct resident_ground_figures *figures)
{
	mutex_lock(&ground->mutex);
	*figures = ground->figures;
	mutex_unlock(&ground->mutex);
}

bool resident_ground_touch(struct ground *ground, struct tile tile)
{
	mutex_lock(&ground->mutex);
	uint32_t place = recent_find(&ground->recent, tile_key(tile));
	if (place != RECENT_NONE)
		recent_use(&ground->recent, place, tile_key(tile));
	mutex_unlock(&ground->mutex);
	return place != RECENT_NONE;
}

enum status resident_ground_warm(struct ground *ground, struct store_reader *reader, struct tile tile)
{
	assert(tile.level >= 0);
	if (resident_ground_touch(ground, tile))
		return STATUS_OK;
	mutex_lock(&ground->mutex);
	int32_t *posts = ground->spare;
	ground->spare = NULL;
	mutex_unlock(&ground->mutex);
	if (posts == NULL && (posts = alloc_posts(ground)) == NULL)
		return fail_memory("a base tile");
	enum status status = read_posts(ground, reader, tile, posts);
	mutex_lock(&ground->mutex);
	ground->figures.reads += status == STATUS_OK;
	/* If the owner has read the same tile meanwhile, its copy stays. */
	uint32_t place = recent_find(&ground->recent, tile_key(tile));
	if (status == STATUS_OK && place == RECENT_NONE && (place = recent_oldest(&ground->recent, ground->latest)) != RECENT_NONE) {
		int32_t *old = ground->posts[place];
		recent_use(&ground->recent, place, tile_key(tile));
		ground->posts[place] = posts;
		posts = old;
	}
	if (ground->spare == NULL) {
		ground->spare = posts;
		posts = NULL;
	}
	mutex_unlock(&ground->mutex);
	mem_free(posts);
	return status;
}
