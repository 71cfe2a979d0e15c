/* Heights of tiles: the base on the lattice plus the newest offsets. Keeps the tiles used last. */
#include <math.h>
#include <string.h>

#include "resident/newest_internal.h"

#define BYTES ((size_t)32 << 20)
enum { LEAST = RESIDENT_NEWEST_LEAST, MOST = 64 };

static size_t posts_of(const struct newest *newest)
{
	size_t side = tile_posts(newest->extent);
	return side * side;
}

uint32_t resident_newest_tiles(uint32_t cells)
{
	const size_t posts = (size_t)(cells + 1) * (cells + 1), fit = BYTES / (posts * sizeof(double));
	return fit < LEAST ? LEAST : fit > MOST ? MOST : (uint32_t)fit;
}

uint64_t resident_newest_tile_bytes(uint32_t cells)
{
	const uint64_t posts = (uint64_t)(cells + 1) * (cells + 1), side = cells / RESIDENT_BLOCK;
	return sizeof(double) * (posts + 2 * side * side);
}

uint64_t resident_newest_base_bytes(uint32_t cells)
{
	return (uint64_t)NEWEST_BASES * (cells + 1) * (cells + 1) * sizeof(int32_t);
}

enum status resident_newest_create_tiles(struct newest *newest)
{
	const size_t posts = posts_of(newest);
	const uint32_t tiles = resident_newest_tiles(newest->extent->cells);
	newest->tiles = mem_calloc(tiles, sizeof *newest->tiles);
	newest->posts = mem_alloc(posts, sizeof *newest->posts);
	newest->patch = mem_alloc(posts, sizeof *newest->patch);
	if (newest->tiles == NULL || newest->posts == NULL || newest->patch == NULL)
		return fail_memory("tiles for queries");
	TRY(recent_create(&newest->recent_posts, NEWEST_BASES));
	return recent_create(&newest->recent, tiles);
}

static void free_heights(struct newest *newest)
{
	for (uint32_t i = 0; i < newest->recent.count; i++) {
		mem_free_all(newest->tiles[i].heights, newest->tiles[i].blocks);
		newest->tiles[i] = (struct resident_newest_tile){.heights = NULL};
	}
}

enum status resident_newest_keep(struct newest *newest, uint32_t tiles)
{
	if (tiles < newest->recent.count) {
		struct recent fewer;
		TRY(recent_create(&fewer, tiles));
		free_heights(newest);
		recent_finish(&newest->recent);
		newest->recent = fewer;
		return STATUS_OK;
	}
	const uint32_t count = newest->recent.count;
	if (tiles == count)
		return STATUS_OK;
	TRY(mem_resize(&newest->tiles, tiles, sizeof *newest->tiles, "tiles for queries"));
	for (uint32_t i = count; i < tiles; i++)
		newest->tiles[i] = (struct resident_newest_tile){.heights = NULL};
	return recent_grow(&newest->recent, tiles);
}

void resident_newest_destroy_tiles(struct newest *newest)
{
	free_heights(newest);
	mem_free(newest->tiles);
	recent_finish(&newest->recent);
	for (int i = 0; i < NEWEST_BASES; i++)
		mem_free(newest->base_posts[i]);
	recent_finish(&newest->recent_posts);
	mem_free_all(newest->posts, newest->patch);
}

/* Tells whether its heights include offsets. Tiles coarser than the working level are used only where there are none. */
static bool takes_offsets(const struct newest *newest, struct tile tile)
{
	return newest->deformed && tile.level <= newest->level;
}

void resident_newest_forget_tiles(struct newest *newest)
{
	for (uint32_t i = 0; i < newest->recent.count; i++)
		if (newest->recent.places[i].used && takes_offsets(newest, tile_from_key(newest->recent.places[i].key)))
			recent_empty(&newest->recent, i);
}

/* --- planes --- */

struct taking {
	const struct newest *newest;
	enum plane plane;
	void *posts;
};

static void take_image(void *user, const struct page_image *image)
{
	const struct taking *taking = user;
	const size_t bytes = posts_of(taking->newest) * plane_bytes(taking->plane);
	const struct pages *pages = taking->newest->pages;
	if (image->flags & PLANE_BIT(taking->plane))
		memcpy(taking->posts, pages->home->plane(pages, image, taking->plane), bytes);
	else
		memset(taking->posts, 0, bytes);
}

enum status resident_newest_plane(struct newest *newest, struct tile tile, enum plane plane, void *posts)
{
	enum page_newest where = PAGE_NEWEST_STORED;
	uint32_t slot = 0;
	struct taking taking = {newest, plane, posts};
	enum status status = STATUS_OK;
	if (newest->pages != NULL)
		status = page_cache_newest(newest->pages->cache, tile_key(tile), take_image, &taking, &where, &slot);
	if (status != STATUS_OK || where == PAGE_NEWEST_QUEUED)
		return status;
	if (where == PAGE_NEWEST_SLOT)
		return newest->pages->home->read_plane(newest->pages, slot, plane, posts);
	void *into[PLANES] = {NULL};
	unsigned present;
	into[plane] = posts;
	return store_read_deformed(resident_ground_reader(newest->base), tile, PLANE_BIT(plane), into, &present);
}

/* --- heights --- */

/* Interpolates the tile's posts from a level `shift` levels coarser, in the same memory. */
static void divide(struct newest *newest, struct tile tile, int shift, const int32_t *coarse, int32_t *posts)
{
	const uint32_t cells = newest->extent->cells, side = lattice_patch_posts(cells, shift);
	const uint64_t x = (uint64_t)tile.x * cells, y = (uint64_t)tile.y * cells, part = ((uint64_t)1 << shift) - 1;
	const size_t cx = (size_t)(x >> shift) & (cells - 1), cy = (size_t)(y >> shift) & (cells - 1);
	for (size_t row = 0; row < side; row++)
		memcpy(newest->patch + row * side, coarse + (cy + row) * (cells + 1) + cx, side * sizeof *coarse);
	lattice_subdivide(newest->patch, cells, shift, (uint32_t)(x & part), (uint32_t)(y & part), posts);
}

/* Gives the base posts of a tile. They are valid until the next call. */
static enum status find_base_posts(struct newest *newest, struct tile tile, const int32_t **out)
{
	const uint64_t key = tile_key(tile);
	uint32_t place = recent_find(&newest->recent_posts, key);
	if (place == RECENT_NONE) {
		place = recent_oldest(&newest->recent_posts, RECENT_NONE);
		recent_empty(&newest->recent_posts, place); /* has no tile until the read is complete */
		if (newest->base_posts[place] == NULL)
			TRY(mem_make(&newest->base_posts[place], posts_of(newest), sizeof **newest->base_posts, "a tile for queries"));
		TRY(resident_ground_posts(newest->base, tile, newest->base_posts[place]));
	}
	recent_use(&newest->recent_posts, place, key);
	*out = newest->base_posts[place];
	return STATUS_OK;
}

static enum status fill_base(struct newest *newest, struct tile tile, double *heights)
{
	const size_t count = posts_of(newest);
	const struct store_meta *meta = store_meta(newest->store);
	int32_t *posts = newest->posts;
	enum status status;
	if (!newest->fits) {
		status = store_read_base(resident_ground_reader(newest->base), tile, posts, NULL);
		for (size_t i = 0; i < count && status == STATUS_OK; i++)
			heights[i] = height_code_metres(posts[i], meta->step);
		return status;
	}
	const double reference = resident_ground_reference(newest->store);
	const int32_t *base;
	TRY(find_base_posts(newest, tile, &base));
	for (size_t i = 0; i < count; i++)
		heights[i] = base[i] == BASE_NODATA ? (double)NAN : reference + base[i] * (1.0 / (1 << BASE_BITS));
	return STATUS_OK;
}

static enum status add_offsets(struct newest *newest, struct tile tile, struct resident_newest_tile *into)
{
	const size_t count = posts_of(newest);
	int32_t *offsets = newest->posts, bits = 0;
	const int shift = newest->level - tile.level; /* 0, unless the offsets are of a coarser level */
	int32_t *fine = NULL;
	enum status status = resident_newest_plane(newest, tile_ancestor(tile, newest->level), PLANE_OFFSET, offsets);
	if (status == STATUS_OK && shift > 0) {
		TRY(mem_make(&fine, count, sizeof *fine, "a tile for queries"));
		divide(newest, tile, shift, offsets, fine);
		offsets = fine;
	}
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		bits |= offsets[i];
		into->heights[i] += offsets[i] * (1.0 / (1 << OFFSET_BITS));
	}
	into->offsets = bits != 0;
	mem_free(fine);
	return status;
}

static enum status make_room(const struct newest *newest, struct resident_newest_tile *tile)
{
	const size_t side = newest->extent->cells / RESIDENT_BLOCK;
	if (tile->heights == NULL)
		tile->heights = mem_alloc(posts_of(newest), sizeof *tile->heights);
	if (tile->blocks == NULL)
		tile->blocks = mem_alloc(side * side, sizeof *tile->blocks);
	return tile->heights != NULL && tile->blocks != NULL ? STATUS_OK : fail_memory("a tile for queries");
}

enum status resident_newest_tile(struct newest *newest, struct tile tile, const struct resident_newest_tile **out)
{
	const uint64_t key = tile_key(tile);
	uint32_t place = recent_find(&newest->recent, key);
	if (place == RECENT_NONE) {
		place = recent_oldest(&newest->recent, RECENT_NONE);
		recent_empty(&newest->recent, place); /* until it is whole */
		struct resident_newest_tile *found = &newest->tiles[place];
		found->offsets = false;
		TRY(make_room(newest, found));
		TRY(fill_base(newest, tile, found->heights));
		if (takes_offsets(newest, tile))
			TRY(add_offsets(newest, tile, found));
		resident_fill_blocks(newest->extent->cells, found->heights, found->blocks);
	}
	recent_use(&newest->recent, place, key);
	*out = &newest->tiles[place];
	return STATUS_OK;
}
