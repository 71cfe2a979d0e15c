#include "base/tile.h"

#include <assert.h>
#include <math.h>

#define LEVEL_BIAS 32
#define AXIS_BITS 28

static uint64_t spread(uint64_t v)
{
	v = (v | v << 16) & 0x0000ffff0000ffffull;
	v = (v | v << 8) & 0x00ff00ff00ff00ffull;
	v = (v | v << 4) & 0x0f0f0f0f0f0f0f0full;
	v = (v | v << 2) & 0x3333333333333333ull;
	return (v | v << 1) & 0x5555555555555555ull;
}

static uint32_t gather(uint64_t v)
{
	v &= 0x5555555555555555ull;
	v = (v | v >> 1) & 0x3333333333333333ull;
	v = (v | v >> 2) & 0x0f0f0f0f0f0f0f0full;
	v = (v | v >> 4) & 0x00ff00ff00ff00ffull;
	v = (v | v >> 8) & 0x0000ffff0000ffffull;
	return (uint32_t)(v | v >> 16);
}

uint64_t tile_key(struct tile tile)
{
	assert(tile.level >= -LEVEL_BIAS && tile.level < LEVEL_BIAS);
	assert(tile.x < 1u << AXIS_BITS && tile.y < 1u << AXIS_BITS);
	return (uint64_t)(tile.level + LEVEL_BIAS) << (2 * AXIS_BITS) | spread(tile.y) << 1 |
	       spread(tile.x);
}

struct tile tile_from_key(uint64_t key)
{
	uint64_t morton = key & ((1ull << (2 * AXIS_BITS)) - 1);
	return (struct tile){
		.level = (int)(key >> (2 * AXIS_BITS) & 63) - LEVEL_BIAS,
		.x = gather(morton),
		.y = gather(morton >> 1),
	};
}

bool tile_equal(struct tile a, struct tile b)
{
	return a.level == b.level && a.x == b.x && a.y == b.y;
}

struct tile tile_ancestor(struct tile tile, int level)
{
	assert(level >= tile.level);
	int up = level - tile.level;
	return (struct tile){level, up < 32 ? tile.x >> up : 0, up < 32 ? tile.y >> up : 0};
}

uint64_t tile_within(const struct extent *extent, struct tile tile, int level, int axis)
{
	assert(level >= tile.level && level - tile.level < 32);
	const uint64_t own = axis == 0 ? tile.x : tile.y;
	return (own & (((uint64_t)1 << (level - tile.level)) - 1)) * extent->cells;
}

void tile_descendants(struct tile tile, int level, uint64_t *first, uint64_t *last)
{
	assert(level <= tile.level);
	int down = tile.level - level;
	*first = tile_key((struct tile){level, tile.x << down, tile.y << down});
	*last = *first + ((1ull << (2 * down)) - 1);
}

double extent_spacing(const struct extent *extent, int level)
{
	return ldexp(extent->spacing, level);
}

int64_t extent_posts(int64_t posts, int level)
{
	return level >= 0 ? ((posts - 1) >> level) + 1 : ((posts - 1) << -level) + 1;
}

static uint32_t tiles_along(int64_t posts, uint32_t cells, int level)
{
	int64_t span = level < 0 ? (posts - 1) << -level : posts - 1;
	int64_t tiles = (span + cells - 1) / cells;
	/* Halved, rounding up, so that every tile has its parent. */
	for (int l = 0; l < level; l++)
		tiles = (tiles + 1) / 2;
	return tiles > 0 ? (uint32_t)tiles : 1;
}

uint32_t extent_tiles_x(const struct extent *extent, int level)
{
	return tiles_along(extent->width, extent->cells, level);
}

uint32_t extent_tiles_y(const struct extent *extent, int level)
{
	return tiles_along(extent->height, extent->cells, level);
}

int extent_coarsest(const struct extent *extent)
{
	int level = 0;
	while (extent_tiles_x(extent, level) > 1 || extent_tiles_y(extent, level) > 1)
		level++;
	return level;
}

int extent_level_for(const struct extent *extent, double spacing)
{
	int level = extent_coarsest(extent);
	while (level >= TILE_LEVEL_MIN && extent_spacing(extent, level) > spacing * (1 + SPACING_PRINTED))
		level--;
	return level;
}

bool extent_has(const struct extent *extent, struct tile tile)
{
	return tile.level >= TILE_LEVEL_MIN && tile.level <= extent_coarsest(extent) &&
	       tile.x < extent_tiles_x(extent, tile.level) && tile.y < extent_tiles_y(extent, tile.level);
}

const char *extent_problem(const struct extent *extent)
{
	if (extent->cells < TILE_CELLS_MIN || extent->cells > TILE_CELLS_MAX ||
	    (extent->cells & (extent->cells - 1)) != 0)
		return "a tile's side must be a power of two from 8 to 1024 cells";
	if (extent->width < 2 || extent->height < 2)
		return "a terrain needs at least 2 x 2 posts";
	if (!(extent->spacing > 0) || !isfinite(extent->spacing) || extent->spacing > 1e6)
		return "the spacing must be above 0 and at most 1000 km";
	/* So that tile x and y fit 28 bits down to TILE_LEVEL_MIN. */
	int64_t limit = ((int64_t)extent->cells << AXIS_BITS) >> -TILE_LEVEL_MIN;
	if (extent->width > limit || extent->height > limit)
		return "too many posts along a side for this tile size";
	return 0;
}

struct post_rect post_rect_around(struct post_rect a, struct post_rect b)
{
	return (struct post_rect){
		.x0 = a.x0 < b.x0 ? a.x0 : b.x0,
		.y0 = a.y0 < b.y0 ? a.y0 : b.y0,
		.x1 = a.x1 > b.x1 ? a.x1 : b.x1,
		.y1 = a.y1 > b.y1 ? a.y1 : b.y1,
	};
}

struct post_rect post_rect_intersect(struct post_rect a, struct post_rect b)
{
	return (struct post_rect){
		.x0 = a.x0 > b.x0 ? a.x0 : b.x0,
		.y0 = a.y0 > b.y0 ? a.y0 : b.y0,
		.x1 = a.x1 < b.x1 ? a.x1 : b.x1,
		.y1 = a.y1 < b.y1 ? a.y1 : b.y1,
	};
}

bool post_rect_empty(struct post_rect rect)
{
	return rect.x1 <= rect.x0 || rect.y1 <= rect.y0;
}

struct post_rect post_rect_joined(struct post_rect a, struct post_rect b)
{
	return post_rect_empty(a) ? b : post_rect_empty(b) ? a : post_rect_around(a, b);
}

struct post_rect post_rect_grown(struct post_rect rect, int64_t by)
{
	return (struct post_rect){rect.x0 - by, rect.y0 - by, rect.x1 + by, rect.y1 + by};
}

struct post_rect tile_post_rect(const struct extent *extent, struct tile tile)
{
	int64_t n = extent->cells;
	return (struct post_rect){
		.x0 = tile.x * n,
		.y0 = tile.y * n,
		.x1 = tile.x * n + n + 1,
		.y1 = tile.y * n + n + 1,
	};
}

bool tile_range_of(const struct extent *extent, int level, struct post_rect rect, struct tile *first,
		   struct tile *last)
{
	int64_t n = extent->cells;
	struct post_rect all = {0, 0, extent_tiles_x(extent, level) * n + 1,
				extent_tiles_y(extent, level) * n + 1};
	rect = post_rect_intersect(rect, all);
	if (post_rect_empty(rect))
		return false;
	/* Post p lies in tiles floor(p / n) and, on an edge, also the one before it. */
	int64_t fx = rect.x0 > 0 ? (rect.x0 - 1) / n : 0;
	int64_t fy = rect.y0 > 0 ? (rect.y0 - 1) / n : 0;
	int64_t lx = (rect.x1 - 1) / n, ly = (rect.y1 - 1) / n;
	int64_t mx = (int64_t)extent_tiles_x(extent, level) - 1, my = (int64_t)extent_tiles_y(extent, level) - 1;
	*first = (struct tile){level, (uint32_t)fx, (uint32_t)fy};
	*last = (struct tile){level, (uint32_t)(lx < mx ? lx : mx), (uint32_t)(ly < my ? ly : my)};
	return true;
}
