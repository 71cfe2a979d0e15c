/*
 * Invariants, of what the mutex guards:
 * 1. An entry with `used` 0 is empty; else its posts are whole, and no two have the same key.
 * 2. `latest` is the entry the owner used last, NULL before. Only the owner's own misses take it.
 * 3. Posts are read and changed under the mutex. Reading a tile is long: a warming thread does it without, into
 *    posts no entry refers to, and then trades them for an entry's. Only the owner reads with the mutex held:
 *    nobody is more urgent.
 */
#include "resident/ground.h"

#include <assert.h>
#include <math.h>
#include <string.h>

struct entry {
	uint64_t key;
	uint64_t used; /* by the clock */
	int32_t *posts;
};

struct ground {
	struct store_reader *reader; /* the owner's */
	const struct store_meta *meta;
	int32_t reference;
	uint32_t count;
	struct mutex mutex; /* guards the rest */
	struct entry *entries;
	struct entry *latest;
	int32_t *spare; /* left over from a trade; may be NULL */
	uint64_t clock;
	struct ground_figures figures;
};

int32_t ground_reference(const struct store *store)
{
	const struct store_meta *meta = store_meta(store);
	return isnan(meta->low) ? 0 : lattice_reference(meta->low, meta->high);
}

enum status ground_create(struct store *store, uint32_t tiles, struct ground **out)
{
	struct ground *ground = mem_calloc(1, sizeof *ground);
	if (ground == NULL)
		return fail_memory("the ground");
	assert(tiles >= 1);
	mutex_init(&ground->mutex);
	ground->meta = store_meta(store);
	ground->reference = ground_reference(store);
	ground->count = tiles;
	ground->entries = mem_calloc(tiles, sizeof *ground->entries);
	enum status status = ground->entries != NULL ? STATUS_OK : fail_memory("the ground");
	if (status == STATUS_OK)
		status = store_reader_create(store, &ground->reader);
	if (status != STATUS_OK) {
		ground_destroy(ground);
		return status;
	}
	*out = ground;
	return STATUS_OK;
}

void ground_destroy(struct ground *ground)
{
	if (ground == NULL)
		return;
	for (uint32_t i = 0; ground->entries != NULL && i < ground->count; i++)
		mem_free(ground->entries[i].posts);
	mem_free(ground->entries);
	mem_free(ground->spare);
	mutex_finish(&ground->mutex);
	store_reader_destroy(ground->reader);
	mem_free(ground);
}

struct store_reader *ground_reader(struct ground *ground)
{
	return ground->reader;
}

static struct entry *find(struct ground *ground, uint64_t key)
{
	for (uint32_t i = 0; i < ground->count; i++)
		if (ground->entries[i].used != 0 && ground->entries[i].key == key)
			return &ground->entries[i];
	return NULL;
}

/* The one used longest ago but for `spared`; NULL if there is no other. */
static struct entry *oldest(struct ground *ground, const struct entry *spared)
{
	struct entry *oldest = NULL;
	for (uint32_t i = 0; i < ground->count; i++) {
		struct entry *entry = &ground->entries[i];
		if (entry != spared && (oldest == NULL || entry->used < oldest->used))
			oldest = entry;
	}
	return oldest;
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

/* For the owner; the posts are there while the mutex is held. */
static enum status posts_locked(struct ground *ground, struct tile tile, const int32_t **posts)
{
	assert(tile.level >= 0);
	uint64_t key = tile_key(tile);
	struct entry *entry = find(ground, key);
	if (entry == NULL) {
		double began = clock_seconds();
		entry = oldest(ground, NULL);
		if (entry->posts == NULL && (entry->posts = alloc_posts(ground)) == NULL)
			return fail_memory("a base tile");
		entry->used = 0; /* until it is whole */
		enum status status = read_posts(ground, ground->reader, tile, entry->posts);
		if (status != STATUS_OK)
			return status;
		entry->key = key;
		ground->figures.reads++;
		ground->figures.waits++;
		ground->figures.wait_ms += (clock_seconds() - began) * 1e3;
	}
	entry->used = ++ground->clock;
	ground->latest = entry;
	*posts = entry->posts;
	return STATUS_OK;
}

enum status ground_posts(struct ground *ground, struct tile tile, int32_t *posts)
{
	size_t side = tile_posts(&ground->meta->extent);
	const int32_t *there;
	mutex_lock(&ground->mutex);
	enum status status = posts_locked(ground, tile, &there);
	if (status == STATUS_OK)
		memcpy(posts, there, side * side * sizeof *posts);
	mutex_unlock(&ground->mutex);
	return status;
}

enum status ground_patch(struct ground *ground, struct tile tile, int32_t *patch, int *shift, uint32_t *sub_x,
			 uint32_t *sub_y)
{
	assert(tile.level < 0);
	uint32_t cells = ground->meta->extent.cells, mask = cells - 1, stride = cells + 1;
	*shift = -tile.level;
	/* The tile's first post, in 2^-shift cells of level 0, parted into tile, cell and rest. */
	uint64_t x = (uint64_t)tile.x * cells, y = (uint64_t)tile.y * cells, part = ((uint64_t)1 << *shift) - 1;
	uint32_t cx = (uint32_t)(x >> *shift) & mask, cy = (uint32_t)(y >> *shift) & mask;
	*sub_x = (uint32_t)(x & part);
	*sub_y = (uint32_t)(y & part);
	uint32_t side = lattice_patch_posts(cells, *shift);
	const int32_t *posts;
	mutex_lock(&ground->mutex);
	enum status status = posts_locked(ground, tile_ancestor(tile, 0), &posts);
	for (uint32_t row = 0; row < side && status == STATUS_OK; row++)
		memcpy(patch + (size_t)row * side, posts + (size_t)(cy + row) * stride + cx, side * sizeof *patch);
	mutex_unlock(&ground->mutex);
	return status;
}

static void widen(const int32_t *posts, uint32_t width, uint32_t height, uint32_t stride, int32_t *low,
		  int32_t *high)
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

enum status ground_base_range(struct ground *ground, struct tile tile, struct store_range *range)
{
	mutex_lock(&ground->mutex);
	ground->figures.ranges++;
	mutex_unlock(&ground->mutex);
	return store_read_base_range(ground->reader, tile, range);
}

enum status ground_offset_range(struct ground *ground, struct tile tile, double *low, double *high, bool *found)
{
	mutex_lock(&ground->mutex);
	ground->figures.offset_ranges++;
	mutex_unlock(&ground->mutex);
	return store_read_offset_range(ground->reader, tile, low, high, found);
}

enum status ground_range(struct ground *ground, struct tile tile, double *low, double *high, bool *any)
{
	if (tile.level >= 0) {
		struct store_range range;
		enum status status = ground_base_range(ground, tile, &range);
		*low = range.low;
		*high = range.high;
		*any = status == STATUS_OK && !isnan(range.low);
		return status;
	}
	uint32_t cells = ground->meta->extent.cells;
	uint64_t x = (uint64_t)tile.x * cells >> -tile.level, y = (uint64_t)tile.y * cells >> -tile.level;
	uint32_t side = lattice_patch_posts(cells, -tile.level);
	int32_t lowest = INT32_MAX, highest = INT32_MIN;
	const int32_t *posts;
	mutex_lock(&ground->mutex);
	enum status status = posts_locked(ground, tile_ancestor(tile, 0), &posts);
	if (status == STATUS_OK)
		widen(posts + (size_t)(y & (cells - 1)) * (cells + 1) + (x & (cells - 1)), side, side, cells + 1, &lowest,
		      &highest);
	mutex_unlock(&ground->mutex);
	if (status != STATUS_OK)
		return status;
	*any = lowest <= highest;
	*low = ground->reference + lattice_base_metres(lowest);
	*high = ground->reference + lattice_base_metres(highest);
	return STATUS_OK;
}

/* The posts of level 0 that those of a level below it are interpolated from. */
static struct post_rect around(struct post_rect rect, int shift)
{
	int64_t up = ((int64_t)1 << shift) - 1;
	return (struct post_rect){rect.x0 >> shift, rect.y0 >> shift, ((rect.x1 - 1 + up) >> shift) + 1,
				  ((rect.y1 - 1 + up) >> shift) + 1};
}

/* As few tiles as hold all posts from one to one behind another: those of an edge are in two. */
static void tiles_over(int64_t first, int64_t end, int64_t cells, int64_t tiles, uint32_t range[2])
{
	int64_t low = first / cells, high = end - first > 1 ? (end - 2) / cells : low;
	range[0] = (uint32_t)(low < tiles ? low : tiles - 1);
	range[1] = (uint32_t)(high < tiles ? high : tiles - 1);
}

enum status ground_highest(struct ground *ground, int level, struct post_rect rect, int32_t *highest, bool *any)
{
	const struct extent *extent = &ground->meta->extent;
	const int from = level > 0 ? level : 0;
	const int64_t cells = extent->cells;
	int32_t lowest = INT32_MAX;
	*highest = INT32_MIN;
	*any = false;
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
			status = posts_locked(ground, tile, &posts);
			if (status == STATUS_OK)
				widen(posts + (size_t)(in.y0 - own.y0) * (size_t)(cells + 1) + (size_t)(in.x0 - own.x0),
				      (uint32_t)(in.x1 - in.x0), (uint32_t)(in.y1 - in.y0), (uint32_t)cells + 1, &lowest, highest);
			mutex_unlock(&ground->mutex);
		}
	*any = lowest <= *highest;
	return status;
}

/* The level-0 cell a height at (x, y) comes from, within the world: the last one reaches to its edge. */
static void cell_of(const struct extent *extent, double x, double y, int64_t *cx, int64_t *cy)
{
	*cx = (int64_t)x < extent->width - 1 ? (int64_t)x : extent->width - 2;
	*cy = (int64_t)y < extent->height - 1 ? (int64_t)y : extent->height - 2;
}

struct tile ground_tile(const struct extent *extent, double x, double y)
{
	int64_t cx, cy;
	cell_of(extent, x, y, &cx, &cy);
	return (struct tile){0, (uint32_t)(cx / extent->cells), (uint32_t)(cy / extent->cells)};
}

enum status ground_height(struct ground *ground, int64_t x, int64_t y, int64_t *height, bool *any)
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
	int32_t corner[4] = {0};
	mutex_lock(&ground->mutex);
	enum status status = posts_locked(ground, ground_tile(extent, px, py), &posts);
	for (int i = 0; i < 4 && status == STATUS_OK; i++)
		corner[i] = posts[(cy % cells + i / 2) * (cells + 1) + cx % cells + i % 2];
	mutex_unlock(&ground->mutex);
	if (status != STATUS_OK)
		return status;
	const double weight[4] = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
	double sum = 0;
	for (int i = 0; i < 4; i++) {
		if (weight[i] == 0)
			continue;
		if (corner[i] == BASE_NODATA)
			return STATUS_OK;
		sum += weight[i] * (double)corner[i];
	}
	*height = (int64_t)floor(sum * (1 << (OFFSET_BITS - BASE_BITS)) + 0.5) + (int64_t)ground->reference * (1 << OFFSET_BITS);
	*any = true;
	return STATUS_OK;
}

void ground_figures(struct ground *ground, struct ground_figures *figures)
{
	mutex_lock(&ground->mutex);
	*figures = ground->figures;
	mutex_unlock(&ground->mutex);
}

bool ground_touch(struct ground *ground, struct tile tile)
{
	mutex_lock(&ground->mutex);
	struct entry *entry = find(ground, tile_key(tile));
	if (entry != NULL)
		entry->used = ++ground->clock;
	mutex_unlock(&ground->mutex);
	return entry != NULL;
}

enum status ground_warm(struct ground *ground, struct store_reader *reader, struct tile tile)
{
	assert(tile.level >= 0);
	if (ground_touch(ground, tile))
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
	/* The owner may have read it meanwhile: one copy is enough. */
	struct entry *entry = find(ground, tile_key(tile));
	if (status == STATUS_OK && entry == NULL && (entry = oldest(ground, ground->latest)) != NULL) {
		int32_t *old = entry->posts;
		*entry = (struct entry){tile_key(tile), ++ground->clock, posts};
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
