/* What tests of the picture share: hills with a hole and a rut, tiles that are loaded as a selection wants them, and a picture. */
#ifndef FURROW_TESTS_PICTURE_RIG_H
#define FURROW_TESTS_PICTURE_RIG_H

#include "gpu_rig.h"
#include "render/internal.h"

#define WIDTH 192
#define HEIGHT 108
#define CELLS 64
#define POSTS (CELLS + 1)
#define SLOTS 32

static const struct extent extent = {257, 257, 2, CELLS};
static struct gpu_slots *slots;
static struct render *render;
static struct render_selection selection;
static uint64_t resident[SLOTS];
static uint32_t resident_count;
static double tile_radius; /* small tiles: several levels in one picture */
static double pixel_error; /* 0: by radii */
static double said_errors[RENDER_STRIDES]; /* of every draw, of tiles by radius; 0: as selected */
static bool said_of_half; /* of every other tile; the rest is said to be without error */

/* --- a world: hills with a grain, and what each test adds --- */

static struct {
	double hole[4];  /* west, south, east, north: nodata inside; metres */
	double rut[4];   /* pressed by `deep` inside; raised, if that is below 0 */
	double deep, roughness;
	bool smooth; /* without grain */
} ground;

static inline double height_at(int64_t i, int64_t j)
{
	double x = (double)i * extent.spacing, y = (double)j * extent.spacing;
	if (x >= ground.hole[0] && x <= ground.hole[2] && y >= ground.hole[1] && y <= ground.hole[3])
		return (double)NAN;
	double grain = ground.smooth ? 0 : sin(x * 1.7 + sin(y * 0.9) * 2) * sin(y * 1.3);
	return 400 + ground.roughness * (12 * sin(x / 37) * cos(y / 29) + 0.8 * grain);
}

static inline int32_t offset_at(int64_t i, int64_t j)
{
	double x = (double)i * extent.spacing, y = (double)j * extent.spacing;
	bool in = x >= ground.rut[0] && x <= ground.rut[2] && y >= ground.rut[1] && y <= ground.rut[3];
	return in ? (int32_t)lattice_offset(-ground.deep) : 0;
}

static inline bool world_bounds(void *user, struct tile tile, double *low, double *high)
{
	*low = 400 - 14 * ground.roughness - fmax(ground.deep, 0);
	*high = 400 + 14 * ground.roughness + fmax(-ground.deep, 0);
	return tile.level >= 0;
}

static inline bool tile_resident(void *user, struct tile tile, uint32_t *slot)
{
	for (uint32_t i = 0; i < resident_count; i++)
		if (resident[i] == tile_key(tile)) {
			*slot = i;
			return true;
		}
	return false;
}

static inline bool world_divisible(void *user, struct tile tile)
{
	return tile.level > 0;
}

/* The most that the tile's bilinear surface is off a post it leaves out. */
static inline double world_error(void *user, struct tile tile)
{
	static double known[3][4];
	static bool of_smooth;
	if (of_smooth != ground.smooth)
		memset(known, 0, sizeof known);
	of_smooth = ground.smooth;
	double *error = &known[tile.level][tile.level > 0 ? 2 * tile.y + tile.x : 0];
	int64_t step = (int64_t)1 << tile.level, side = CELLS * step;
	for (int64_t j = tile.y * side; tile.level > 0 && *error == 0 && j < (tile.y + 1) * side; j++)
		for (int64_t i = tile.x * side; i < (tile.x + 1) * side; i++) {
			int64_t x = i / step * step, y = j / step * step;
			double u = (double)(i - x) / (double)step, v = (double)(j - y) / (double)step;
			double south = height_at(x, y) * (1 - u) + height_at(x + step, y) * u;
			double north = height_at(x, y + step) * (1 - u) + height_at(x + step, y + step) * u;
			*error = fmax(*error, fabs(south * (1 - v) + north * v - height_at(i, j)));
		}
	return *error;
}

static inline void load(struct tile tile)
{
	static int32_t base[POSTS * POSTS], offset[POSTS * POSTS];
	bool any = false;
	assert_true(resident_count < SLOTS);
	for (int64_t j = 0; j < POSTS; j++)
		for (int64_t i = 0; i < POSTS; i++) {
			int64_t x = (tile.x * CELLS + i) << tile.level, y = (tile.y * CELLS + j) << tile.level;
			bool in = x < extent.width && y < extent.height;
			base[j * POSTS + i] = lattice_base_relative(in ? height_at(x, y) : (double)NAN, 0);
			offset[j * POSTS + i] = in ? offset_at(x, y) : 0;
			any = any || offset[j * POSTS + i] != 0;
		}
	assert_ok(staged_upload_base(gpu, slots, CELLS, resident_count, base));
	gpu_slots_undeform(slots, resident_count);
	if (any)
		assert_ok(staged_upload_deform(gpu, slots, CELLS, resident_count, offset, NULL));
	resident[resident_count++] = tile_key(tile);
}

static inline void begin(uint64_t effects)
{
	struct render_params params = {
		.gpu = gpu, .extent = &extent, .low = 380, .high = 420, .width = WIDTH, .height = HEIGHT,
		.effects = effects, .pixel_error = pixel_error,
	};
	assert_ok(gpu_slots_create(gpu, CELLS, SLOTS, 0, &slots));
	params.slots = slots;
	assert_ok(render_create(&params, &render));
	resident_count = 0;
	tile_radius = 3;
}

static inline void end(void)
{
	render_destroy(render);
	gpu_slots_destroy(slots);
	render = NULL;
	slots = NULL;
}

/* Selects the tiles of a view, and loads them. */
static inline void select_tiles(struct render_view *view)
{
	const struct render_source source = {NULL, world_bounds, tile_resident, world_divisible, world_error, NULL};
	if (!view->by_error || said_errors[1] > 0) {
		view->by_error = false;
		view->radius = tile_radius;
	}
	for (;;) {
		render_select(&extent, view, &source, &selection);
		if (selection.wanted_count == 0)
			break;
		for (size_t i = 0; i < selection.wanted_count; i++)
			load(tile_from_key(selection.wanted[i]));
	}
	for (size_t i = 0; said_errors[1] > 0 && i < selection.draw_count; i++)
		for (int k = 0; k < RENDER_STRIDES; k++) {
			bool none = said_of_half && (selection.draws[i].tile.x + selection.draws[i].tile.y) % 2 > 0;
			selection.draws[i].errors[k] = none ? 0 : said_errors[k];
		}
}

static inline uint8_t *draw(double x, double y, double up, double tx, double ty, double tz)
{
	struct render_camera camera = {{x, y, 400 + up}, {tx, ty, 400 + tz}, 0.9, {0}};
	struct render_view view;
	render_shade_begin(render);
	for (int map = 0; map < RENDER_SHADE_MAPS; map++) {
		if (!render_shade_view(render, &camera, 400, map, &view))
			continue;
		select_tiles(&view);
		assert_ok(render_shade_draw(render, &camera, map, &view, &selection));
	}
	render_view(render, &camera, &view);
	select_tiles(&view);
	assert_ok(render_frame(render, &camera, &selection));
	uint8_t *pixels = test_malloc(4 * WIDTH * HEIGHT);
	gpu_texture_read(render->screen->colour, 0, (struct gpu_rect){0, 0, WIDTH, HEIGHT}, pixels);
	return pixels;
}

/* What is seen where nothing was drawn, without the sky. */
static inline void find_background(uint8_t background[4])
{
	uint8_t *pixels = draw(256, 256, 100, 256, 256.1, 900);
	memcpy(background, pixels, 4);
	test_free(pixels);
}

/* Mean difference of two pictures' pixels, 0 .. 255. */
static inline double difference(const uint8_t *a, const uint8_t *b)
{
	double sum = 0;
	for (int i = 0; i < 4 * WIDTH * HEIGHT; i++)
		sum += abs(a[i] - b[i]);
	return sum / (3.0 * WIDTH * HEIGHT);
}

#endif
