#include "run/ground.h"

#include <assert.h>
#include <math.h>
#include <string.h>

struct entry {
	uint64_t key;
	uint64_t used; /* 0: empty */
	int32_t *posts;
};

struct ground {
	struct store_reader *reader;
	const struct store_meta *meta;
	int32_t reference;
	struct entry *entries;
	uint32_t count;
	uint64_t clock;
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
	store_reader_destroy(ground->reader);
	mem_free(ground);
}

struct store_reader *ground_reader(struct ground *ground)
{
	return ground->reader;
}

enum status ground_posts(struct ground *ground, struct tile tile, const int32_t **posts)
{
	assert(tile.level >= 0);
	uint64_t key = tile_key(tile);
	struct entry *oldest = &ground->entries[0];
	for (uint32_t i = 0; i < ground->count; i++) {
		struct entry *entry = &ground->entries[i];
		if (entry->used != 0 && entry->key == key) {
			entry->used = ++ground->clock;
			*posts = entry->posts;
			return STATUS_OK;
		}
		if (entry->used < oldest->used)
			oldest = entry;
	}
	size_t side = tile_posts(&ground->meta->world), count = side * side;
	if (oldest->posts == NULL && (oldest->posts = mem_alloc(count, sizeof *oldest->posts)) == NULL)
		return fail_memory("a base tile");
	oldest->used = 0; /* until it is whole */
	struct store_range range;
	enum status status = store_read_base(ground->reader, tile, oldest->posts, &range);
	if (status != STATUS_OK)
		return status;
	for (size_t i = 0; i < count; i++)
		oldest->posts[i] = lattice_base_relative(height_code_metres(oldest->posts[i], ground->meta->step),
							 ground->reference);
	oldest->key = key;
	oldest->used = ++ground->clock;
	*posts = oldest->posts;
	return STATUS_OK;
}

enum status ground_patch(struct ground *ground, struct tile tile, int32_t *patch, int *shift, uint32_t *sub_x,
			 uint32_t *sub_y)
{
	assert(tile.level < 0);
	uint32_t cells = ground->meta->world.cells, mask = cells - 1, stride = cells + 1;
	*shift = -tile.level;
	/* The tile's first post, in 2^-shift cells of level 0, parted into tile, cell and rest. */
	uint64_t x = (uint64_t)tile.x * cells, y = (uint64_t)tile.y * cells, part = ((uint64_t)1 << *shift) - 1;
	uint32_t cx = (uint32_t)(x >> *shift) & mask, cy = (uint32_t)(y >> *shift) & mask;
	*sub_x = (uint32_t)(x & part);
	*sub_y = (uint32_t)(y & part);
	const int32_t *posts;
	enum status status = ground_posts(ground, tile_ancestor(tile, 0), &posts);
	if (status != STATUS_OK)
		return status;
	uint32_t side = lattice_patch_posts(cells, *shift);
	for (uint32_t row = 0; row < side; row++)
		memcpy(patch + (size_t)row * side, posts + (size_t)(cy + row) * stride + cx, side * sizeof *patch);
	return STATUS_OK;
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

enum status ground_range(struct ground *ground, struct tile tile, double *low, double *high, bool *any)
{
	if (tile.level >= 0) {
		struct store_range range;
		enum status status = store_read_base_range(ground->reader, tile, &range);
		*low = range.low;
		*high = range.high;
		*any = status == STATUS_OK && !isnan(range.low);
		return status;
	}
	uint32_t cells = ground->meta->world.cells;
	uint64_t x = (uint64_t)tile.x * cells >> -tile.level, y = (uint64_t)tile.y * cells >> -tile.level;
	const int32_t *posts;
	enum status status = ground_posts(ground, tile_ancestor(tile, 0), &posts);
	if (status != STATUS_OK)
		return status;
	uint32_t side = lattice_patch_posts(cells, -tile.level);
	int32_t lowest = INT32_MAX, highest = INT32_MIN;
	widen(posts + (size_t)(y & (cells - 1)) * (cells + 1) + (x & (cells - 1)), side, side, cells + 1, &lowest,
	      &highest);
	*any = lowest <= highest;
	*low = ground->reference + lattice_base_metres(lowest);
	*high = ground->reference + lattice_base_metres(highest);
	return STATUS_OK;
}

enum status ground_height(struct ground *ground, int64_t x, int64_t y, int64_t *height, bool *any)
{
	const struct world *world = &ground->meta->world;
	double px = lattice_offset_metres(x) / world->spacing, py = lattice_offset_metres(y) / world->spacing;
	*any = false;
	if (px < 0 || py < 0 || px > (double)(world->width - 1) || py > (double)(world->height - 1))
		return STATUS_OK;
	int64_t cx = (int64_t)px, cy = (int64_t)py;
	cx = cx < world->width - 1 ? cx : world->width - 2;
	cy = cy < world->height - 1 ? cy : world->height - 2;
	double u = px - (double)cx, v = py - (double)cy;
	int64_t cells = world->cells;
	const int32_t *posts;
	struct tile tile = {0, (uint32_t)(cx / cells), (uint32_t)(cy / cells)};
	enum status status = ground_posts(ground, tile, &posts);
	if (status != STATUS_OK)
		return status;
	const int32_t *post = posts + (cy % cells) * (cells + 1) + cx % cells;
	const int32_t corner[4] = {post[0], post[1], post[cells + 1], post[cells + 2]};
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
