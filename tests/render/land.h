/*
 * A ground for tests of meshes: 513 x 513 ridged posts in tiles of 32 cells, five levels of them, and a pair of ruts
 * through the corner where the world's four quarters meet, at an eighth of the spacing, with what coarser tiles know of
 * them. All of it lies in slots; what a selection is told to be resident is the test's to say. And its true heights,
 * for rays.
 */
#ifndef FURROW_TESTS_RENDER_LAND_H
#define FURROW_TESTS_RENDER_LAND_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../gpu/staged.h"
#include "../support/skip.h"
#include "dem/dem.h"
#include "render/internal.h"

#define LAND_CELLS 32
#define LAND_POSTS (LAND_CELLS + 1)
#define LAND_AREA (LAND_POSTS * LAND_POSTS)
#define LAND_SIDE 513
#define LAND_FINEST (-3)
#define LAND_TILES 512
#define LAND_LEVELS 8 /* from LAND_FINEST up */

#define assert_ok(call)                                                                            \
	do {                                                                                       \
		if ((call) != STATUS_OK)                                                           \
			fail_msg("%s", failure_message());                                         \
	} while (0)

static const struct extent land_world = {LAND_SIDE, LAND_SIDE, 1, LAND_CELLS};

struct land_tile {
	struct tile tile; /* its slot is its number */
	bool deformed;
	double low, high; /* of its subtree */
	double error;     /* its triangles off the posts of its subtree; no less than of one below it */
	double heights[LAND_AREA];
	double blocks[(LAND_CELLS / RESIDENT_BLOCK) * (LAND_CELLS / RESIDENT_BLOCK)][2];
};

static struct {
	struct gpu *gpu; /* NULL: no GL */
	struct gpu_slots *slots;
	int32_t posts[LAND_SIDE * LAND_SIDE]; /* of level 0, without offsets */
	struct land_tile *tiles;
	uint32_t count;
	int32_t places[4 * LAND_TILES]; /* by key; -1: free */
	/* What a selection is told: of 100 tiles so many are resident, which ones by the seed. The coarsest always is. */
	unsigned resident_of;
	uint64_t seed;
	bool unruffled; /* there is nothing below level 0; there the ruts are in level 0's posts alone */
} land;

static inline uint64_t land_mix(uint64_t v)
{
	v = (v ^ v >> 31) * 0x7fb5d329728ea185ull;
	v = (v ^ v >> 27) * 0x81dadef4bc2dd44dull;
	return v ^ v >> 33;
}

static inline double land_dice(uint64_t *state, double low, double high)
{
	*state = land_mix(*state + 0x9e3779b97f4a7c15ull);
	return low + (double)(*state >> 11) * 0x1p-53 * (high - low);
}

/* --- heights --- */

/* Where the ruts run: y at x, and how far from their middle line a place is. */
static inline double land_way(double x)
{
	return 256 + 5 * sin((x - 256) / 6);
}

/* Quanta at a post of the finest level: two ruts with steep sides, and a little soil beside them. */
static inline int32_t land_offset(int64_t i, int64_t j)
{
	double x = (double)i * 0.125, y = (double)j * 0.125;
	if (x < 238 || x > 274)
		return 0;
	double slant = 5 / 6.0 * cos((x - 256) / 6);
	double off = fabs(fabs(y - land_way(x)) / sqrt(1 + slant * slant) - 0.8);
	double deep = off < 0.16 ? -0.2 : off < 0.3 ? -0.2 + 0.26 * (off - 0.16) / 0.14 : off < 0.5 ? 0.06 * (0.5 - off) / 0.2 : 0;
	return (int32_t)lattice_offset(deep);
}

static inline int32_t land_base(int level, int64_t i, int64_t j)
{
	if (level >= 0)
		return land.posts[(j << level) * LAND_SIDE + (i << level)];
	int shift = -level;
	uint32_t fx = (uint32_t)(i & ((1 << shift) - 1)), fy = (uint32_t)(j & ((1 << shift) - 1));
	const int32_t *at = land.posts + (j >> shift) * LAND_SIDE + (i >> shift);
	const int32_t *north = fy > 0 ? at + LAND_SIDE : at;
	return lattice_interpolate(at[0], at[fx > 0], north[0], north[fx > 0], fx, fy, shift);
}

static inline double land_height(int level, int64_t i, int64_t j)
{
	int steps = level - LAND_FINEST;
	return lattice_base_metres(land_base(level, i, j)) + lattice_offset_metres(land_offset(i << steps, j << steps));
}

/* Of a level's triangles at a place. */
static inline double land_surface(int level, double x, double y)
{
	double spacing = extent_spacing(&land_world, level);
	int64_t most = extent_posts(LAND_SIDE, level) - 2;
	if (level < 0)
		most = (((int64_t)LAND_SIDE - 1) << -level) - 1;
	int64_t i = (int64_t)(x / spacing), j = (int64_t)(y / spacing);
	i = i > most ? most : i;
	j = j > most ? most : j;
	double u = x / spacing - (double)i, v = y / spacing - (double)j;
	double a = land_height(level, i, j), d = land_height(level, i + 1, j + 1);
	double b = u >= v ? land_height(level, i + 1, j) : land_height(level, i, j + 1);
	return a + (b - a) * fmax(u, v) + (d - b) * fmin(u, v);
}

/* --- tiles --- */

static inline struct land_tile *land_find(struct tile tile)
{
	uint64_t key = tile_key(tile);
	if (land.unruffled && tile.level < 0)
		return NULL;
	for (size_t at = land_mix(key) % (4 * LAND_TILES);; at = (at + 1) % (4 * LAND_TILES)) {
		if (land.places[at] < 0)
			return NULL;
		if (tile_equal(land.tiles[land.places[at]].tile, tile))
			return &land.tiles[land.places[at]];
	}
}

static inline bool land_touched(struct tile tile)
{
	int64_t x = (int64_t)tile.x * LAND_CELLS, y = (int64_t)tile.y * LAND_CELLS;
	for (int64_t j = y; j <= y + LAND_CELLS; j++)
		for (int64_t i = x; i <= x + LAND_CELLS; i++)
			if (land_offset(i, j) != 0)
				return true;
	return false;
}

static inline struct land_tile *land_add(struct tile tile)
{
	struct land_tile *had = land_find(tile);
	if (had != NULL)
		return had;
	assert_true(land.count < LAND_TILES);
	size_t at = land_mix(tile_key(tile)) % (4 * LAND_TILES);
	while (land.places[at] >= 0)
		at = (at + 1) % (4 * LAND_TILES);
	land.places[at] = (int32_t)land.count;
	land.tiles[land.count] = (struct land_tile){.tile = tile, .low = INFINITY, .high = -INFINITY};
	return &land.tiles[land.count++];
}

/* From the finest up: ranges and errors are those below it, too. */
static inline void land_measure(struct land_tile *own)
{
	struct tile tile = own->tile;
	double spacing = extent_spacing(&land_world, tile.level);
	for (int64_t j = 0; j <= LAND_CELLS; j++)
		for (int64_t i = 0; i <= LAND_CELLS; i++) {
			double height = land_height(tile.level, (int64_t)tile.x * LAND_CELLS + i, (int64_t)tile.y * LAND_CELLS + j);
			own->heights[j * LAND_POSTS + i] = height;
			own->low = fmin(own->low, height);
			own->high = fmax(own->high, height);
		}
	resident_fill_blocks(LAND_CELLS, own->heights, own->blocks);
	for (unsigned q = 0; q < 4; q++) {
		struct tile child = {tile.level - 1, 2 * tile.x + (q & 1), 2 * tile.y + (q >> 1)};
		const struct land_tile *below = land_find(child);
		if (below == NULL)
			continue;
		own->low = fmin(own->low, below->low);
		own->high = fmax(own->high, below->high);
		own->error = fmax(own->error, below->error);
		for (int k = 0; k < LAND_AREA; k++) {
			double x = (child.x * LAND_CELLS + k % LAND_POSTS) * spacing / 2;
			double y = (child.y * LAND_CELLS + k / LAND_POSTS) * spacing / 2;
			own->error = fmax(own->error, fabs(land_surface(tile.level, x, y) - below->heights[k]) + below->error);
		}
	}
}

static inline void land_upload(uint32_t slot)
{
	static int32_t base[LAND_AREA], offset[LAND_AREA];
	struct land_tile *own = &land.tiles[slot];
	int steps = own->tile.level - LAND_FINEST;
	for (int64_t j = 0; j <= LAND_CELLS; j++)
		for (int64_t i = 0; i <= LAND_CELLS; i++) {
			int64_t x = (int64_t)own->tile.x * LAND_CELLS + i, y = (int64_t)own->tile.y * LAND_CELLS + j;
			base[j * LAND_POSTS + i] = land_base(own->tile.level, x, y);
			offset[j * LAND_POSTS + i] = land_offset(x << steps, y << steps);
		}
	assert_ok(staged_upload_base(land.gpu, land.slots, LAND_CELLS, slot, base));
	if (own->deformed)
		assert_ok(staged_upload_deform(land.gpu, land.slots, LAND_CELLS, slot, offset, NULL));
}

static inline void land_add_base(int level)
{
	uint32_t across = extent_tiles_x(&land_world, level);
	for (uint32_t i = 0; i < across * across; i++)
		land_add((struct tile){level, i % across, i / across});
}

/* A group's setup. */
static inline int land_open(void **state)
{
	enum status status = gpu_create(&(struct gpu_params){.draws = true}, &land.gpu);
	if (status == STATUS_NO_GL) {
		print_message("%s\n", failure_message());
		land.gpu = NULL;
		return 0;
	}
	if (status != STATUS_OK)
		return -1;
	const struct dem_synth synth = {DEM_SYNTH_RIDGED, LAND_SIDE, LAND_SIDE, 1, 90, 7};
	double *heights = malloc(sizeof(double) * LAND_SIDE * LAND_SIDE);
	land.tiles = calloc(LAND_TILES, sizeof *land.tiles);
	if (heights == NULL || land.tiles == NULL)
		return -1;
	dem_synth_posts(&synth, (struct post_rect){0, 0, LAND_SIDE, LAND_SIDE}, heights);
	for (int i = 0; i < LAND_SIDE * LAND_SIDE; i++)
		land.posts[i] = lattice_base_relative(heights[i], 0);
	free(heights);
	memset(land.places, 0xff, sizeof land.places);
	int coarsest = extent_coarsest(&land_world), cells = LAND_SIDE - 1;
	uint32_t across = (uint32_t)((cells << -LAND_FINEST) / LAND_CELLS);
	for (uint32_t y = across / 2 - 3; y < across / 2 + 3; y++)
		for (uint32_t x = across / 2 - 6; x < across / 2 + 6; x++)
			for (int level = LAND_FINEST; land_touched((struct tile){LAND_FINEST, x, y}) && level <= coarsest; level++)
				land_add(tile_ancestor((struct tile){LAND_FINEST, x, y}, level))->deformed = true;
	for (int level = 0; level <= coarsest; level++)
		land_add_base(level);
	assert_ok(gpu_slots_create(land.gpu, LAND_CELLS, land.count, 0, &land.slots));
	for (int level = LAND_FINEST; level <= coarsest; level++)
		for (uint32_t i = 0; i < land.count; i++)
			if (land.tiles[i].tile.level == level) {
				land_measure(&land.tiles[i]);
				land_upload(i);
			}
	land.resident_of = 100;
	return 0;
}

static inline int land_close(void **state)
{
	gpu_slots_destroy(land.slots);
	gpu_destroy(land.gpu);
	free(land.tiles);
	return 0;
}

#define need_land()                                                                                \
	do {                                                                                       \
		if (land.gpu == NULL)                                                              \
			skip_since("no GL");                                                       \
	} while (0)

/* --- what a selection asks --- */

static inline bool land_bounds(void *user, struct tile tile, double *low, double *high)
{
	const struct land_tile *own = land_find(tile);
	if (own == NULL)
		return false;
	*low = own->low;
	*high = own->high;
	return true;
}

static inline bool land_resident(void *user, struct tile tile, uint32_t *slot)
{
	const struct land_tile *own = land_find(tile);
	*slot = (uint32_t)(own - land.tiles);
	return tile.level == extent_coarsest(&land_world) || land_mix(tile_key(tile) * 3 + land.seed) % 100 < land.resident_of;
}

static inline bool land_divisible(void *user, struct tile tile)
{
	return tile.level > (land_find(tile)->deformed && !land.unruffled ? LAND_FINEST : 0);
}

static inline double land_error(void *user, struct tile tile)
{
	return land_find(tile)->error;
}

static const struct render_source land_source = {NULL, land_bounds, land_resident, land_divisible, land_error, NULL};

/* --- what rays ask --- */

static inline enum status land_ask_posts(void *user, struct tile tile, struct resident_posts *posts)
{
	const struct land_tile *own = land_find(tile);
	*posts = (struct resident_posts){own->heights, (const double(*)[2])own->blocks};
	return STATUS_OK;
}

static inline enum status land_ask_present(void *user, struct tile tile, bool *present)
{
	*present = land_find(tile) != NULL;
	return STATUS_OK;
}

static inline enum status land_ask_bounds(void *user, struct tile tile, double *low, double *high, bool *any)
{
	while (land_find(tile) == NULL)
		tile = tile_ancestor(tile, tile.level + 1);
	*any = land_bounds(NULL, tile, low, high);
	return STATUS_OK;
}

static const struct resident_source land_ground = {
	NULL, &land_world, LAND_FINEST, land_ask_posts, land_ask_present, land_ask_bounds,
};

/* --- pictures --- */

static inline struct render *land_render(int width, int height, uint64_t effects, double pixel_error)
{
	const struct land_tile *all = land_find((struct tile){extent_coarsest(&land_world), 0, 0});
	struct render_params params = {
		.gpu = land.gpu, .slots = land.slots, .extent = &land_world, .low = all->low, .high = all->high, .width = width,
		.height = height, .effects = effects, .pixel_error = pixel_error,
	};
	struct render *render;
	assert_ok(render_create(&params, &render));
	return render;
}

/* Reversed: 0 where nothing was drawn. */
static inline void land_depth(const struct render *render, float *depth)
{
	gpu_texture_read(render->screen->depth, 0, (struct gpu_rect){0, 0, render->screen->width, render->screen->height}, depth);
	assert_ok(gpu_check(land.gpu, "reading depth"));
}

/* From the eye through a place of the picture, in pixels from its lower left corner; its part forward is 1. */
static inline void land_ray(const struct render *render, const struct render_axes *axes, double px, double py, double ray[3])
{
	for (int i = 0; i < 3; i++)
		ray[i] = axes->forward[i] + (px - render->screen->width / 2.0) / axes->focal * axes->right[i] +
			 (py - render->screen->height / 2.0) / axes->focal * axes->up[i];
}

#endif
