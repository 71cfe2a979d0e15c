/* The picture itself: holes, ruts, seams, repeatability, variants. Skipped without GL. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../gpu/staged.h"
#include "../pairs.h"
#include "render/internal.h"

#define WIDTH 192
#define HEIGHT 108
#define CELLS 64
#define POSTS (CELLS + 1)
#define SLOTS 32
#define ALL (EFFECT_BIT(EFFECT_TEXTURE) | EFFECT_BIT(EFFECT_DETAIL) | EFFECT_BIT(EFFECT_FOG) | EFFECT_BIT(EFFECT_SKY) | EFFECT_BIT(EFFECT_GEOMORPH) | EFFECT_BIT(EFFECT_SKIRTS))

static const struct extent extent = {257, 257, 2, CELLS};
static struct gpu *gpu; /* NULL: no GL */
static struct gpu_slots *slots;
static struct render *render;
static struct terrain_selection selection;
static uint64_t resident[SLOTS];
static uint32_t resident_count;
static double tile_radius; /* small tiles: several levels in one picture */
static double pixel_error; /* 0: by radii */
static double said_errors[TERRAIN_STRIDES]; /* of every draw, of tiles by radius; 0: as selected */
static bool said_of_half; /* of every other tile; the rest is said to be without error */

#define need_gpu()                                                                                 \
	do {                                                                                       \
		if (gpu == NULL)                                                                   \
			skip();                                                                    \
	} while (0)

#define assert_ok(call)                                                                            \
	do {                                                                                       \
		if ((call) != STATUS_OK)                                                           \
			fail_msg("%s", failure_message());                                         \
	} while (0)

static int open_gpu(void **state)
{
	enum status status = gpu_create(&(struct gpu_params){.draws = true}, &gpu);
	if (status == STATUS_NO_GL) {
		print_message("%s\n", failure_message());
		gpu = NULL;
		return 0;
	}
	return status == STATUS_OK ? 0 : -1;
}

static int close_gpu(void **state)
{
	gpu_destroy(gpu);
	return 0;
}

/* --- a world: hills with a grain, and what each test adds --- */

static struct {
	double hole[4];  /* west, south, east, north: nodata inside; metres */
	double rut[4];   /* pressed by `deep` inside */
	double deep, roughness;
	bool smooth; /* without grain */
} ground;

static double height_at(int64_t i, int64_t j)
{
	double x = (double)i * extent.spacing, y = (double)j * extent.spacing;
	if (x >= ground.hole[0] && x <= ground.hole[2] && y >= ground.hole[1] && y <= ground.hole[3])
		return (double)NAN;
	double grain = ground.smooth ? 0 : sin(x * 1.7 + sin(y * 0.9) * 2) * sin(y * 1.3);
	return 400 + ground.roughness * (12 * sin(x / 37) * cos(y / 29) + 0.8 * grain);
}

static int32_t offset_at(int64_t i, int64_t j)
{
	double x = (double)i * extent.spacing, y = (double)j * extent.spacing;
	bool in = x >= ground.rut[0] && x <= ground.rut[2] && y >= ground.rut[1] && y <= ground.rut[3];
	return in ? (int32_t)lattice_offset(-ground.deep) : 0;
}

static bool world_bounds(void *user, struct tile tile, double *low, double *high)
{
	*low = 400 - 14 * ground.roughness - ground.deep;
	*high = 400 + 14 * ground.roughness;
	return tile.level >= 0;
}

static bool world_resident(void *user, struct tile tile, uint32_t *slot)
{
	for (uint32_t i = 0; i < resident_count; i++)
		if (resident[i] == tile_key(tile)) {
			*slot = i;
			return true;
		}
	return false;
}

static bool world_divisible(void *user, struct tile tile)
{
	return tile.level > 0;
}

/* The most that the tile's bilinear surface is off a post it leaves out. */
static double world_error(void *user, struct tile tile)
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

static void load(struct tile tile)
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

static void begin(uint64_t effects)
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

static void end(void)
{
	render_destroy(render);
	gpu_slots_destroy(slots);
	render = NULL;
	slots = NULL;
}

static uint8_t *draw(double x, double y, double up, double tx, double ty, double tz)
{
	const struct terrain_source source = {NULL, world_bounds, world_resident, world_divisible, world_error};
	struct render_camera camera = {{x, y, 400 + up}, {tx, ty, 400 + tz}, 0.9, {0}};
	struct terrain_view view;
	render_view(render, &camera, &view);
	if (!view.by_error || said_errors[1] > 0) {
		view.by_error = false;
		view.radius = tile_radius;
	}
	for (;;) {
		terrain_select(&extent, &view, &source, &selection);
		if (selection.wanted_count == 0)
			break;
		for (size_t i = 0; i < selection.wanted_count; i++)
			load(tile_from_key(selection.wanted[i]));
	}
	for (size_t i = 0; said_errors[1] > 0 && i < selection.draw_count; i++)
		for (int k = 0; k < TERRAIN_STRIDES; k++) {
			bool none = said_of_half && (selection.draws[i].tile.x + selection.draws[i].tile.y) % 2 > 0;
			selection.draws[i].errors[k] = none ? 0 : said_errors[k];
		}
	assert_ok(render_frame(render, &camera, &selection));
	uint8_t *pixels = test_malloc(4 * WIDTH * HEIGHT);
	gpu_texture_read(render->colour, 0, (struct gpu_rect){0, 0, WIDTH, HEIGHT}, pixels);
	return pixels;
}

static const uint8_t *pixel(const uint8_t *pixels, int x, int y)
{
	return pixels + 4 * (WIDTH * y + x);
}

/* What is seen where nothing was drawn, without the sky. */
static void find_background(uint8_t background[4])
{
	uint8_t *pixels = draw(256, 256, 100, 256, 256.1, 900);
	memcpy(background, pixels, 4);
	test_free(pixels);
}

static int count_background(const uint8_t *pixels, const uint8_t background[4])
{
	int count = 0;
	for (int i = 0; i < WIDTH * HEIGHT; i++)
		count += memcmp(pixels + 4 * i, background, 4) == 0;
	return count;
}

/* What is drawn before the first frame leaves no trace in it. */
static void what_is_drawn_unseen_is_not_seen(void **state)
{
	need_gpu();
	memset(&ground, 0, sizeof ground);
	ground.roughness = 1;
	begin(ALL);
	uint8_t *before = draw(60, 60, 20, 300, 300, 0);
	uint64_t triangles = render_triangles(render);
	assert_ok(render_draw_unseen(render, true, true));
	uint8_t *after = draw(60, 60, 20, 300, 300, 0);
	assert_memory_equal(before, after, 4 * WIDTH * HEIGHT);
	assert_true(render_triangles(render) == triangles);
	test_free(before);
	test_free(after);
	end();
}

static int luminance(const uint8_t *p)
{
	return 2 * p[0] + 5 * p[1] + p[2];
}

static void no_sky_is_seen_through_the_ground(void **state)
{
	need_gpu();
	const uint64_t effects[] = {EFFECT_BIT(EFFECT_SKIRTS), EFFECT_BIT(EFFECT_SKIRTS) | EFFECT_BIT(EFFECT_GEOMORPH)};
	memset(&ground, 0, sizeof ground);
	ground.roughness = 1;
	for (size_t e = 0; e < 2; e++) {
		begin(effects[e]);
		uint8_t background[4];
		find_background(background);
		size_t most = 0;
		for (int i = 0; i < 40; i++) {
			/* Straight down, then as far ahead as the world's ground fills the picture. */
			bool ahead = i % 2;
			double x = 40 + 3.1 * i, y = 130 - 2.3 * i, turn = 0.5 + 0.015 * i;
			tile_radius = 0.3 + 0.01 * i;
			uint8_t *pixels = ahead ? draw(x, y, 40, x + 85 * cos(turn), y + 85 * sin(turn), -31) :
						  draw(x + 90, y + 90, 16 + i, x + 90 + cos(i), y + 90 + sin(i), 0);
			assert_int_equal(count_background(pixels, background), 0);
			test_free(pixels);
			most = selection.draw_count > most ? selection.draw_count : most;
		}
		assert_true(most >= 4);
		end();
	}
}

static void no_sky_is_seen_through_the_ground_by_pixel_error(void **state)
{
	need_gpu();
	const uint64_t effects[] = {EFFECT_BIT(EFFECT_SKIRTS), EFFECT_BIT(EFFECT_SKIRTS) | EFFECT_BIT(EFFECT_GEOMORPH)};
	uint64_t random = 7;
	size_t levels = 0;
	memset(&ground, 0, sizeof ground);
	ground.roughness = 1;
	for (int i = 0; i < 60; i++) {
		double dice[2];
		for (int k = 0; k < 2; k++) {
			random = random * 6364136223846793005u + 1442695040888963407u;
			dice[k] = (double)(random >> 11) * 0x1p-53;
		}
		pixel_error = 0.05 * pow(100, dice[0]);
		begin(effects[i % 2]);
		uint8_t background[4];
		find_background(background);
		double x = 40 + 121 * dice[1], y = 130 - 90 * dice[1], turn = 0.5 + 0.58 * dice[1];
		uint8_t *pixels = i % 3 > 0 ? draw(x, y, 40, x + 85 * cos(turn), y + 85 * sin(turn), -31) :
					      draw(x + 90, y + 90, 16 + i, x + 90 + cos(i), y + 90 + sin(i), 0);
		assert_int_equal(count_background(pixels, background), 0);
		test_free(pixels);
		for (size_t k = 1; k < selection.draw_count; k++)
			levels += selection.draws[k].tile.level != selection.draws[k - 1].tile.level;
		end();
	}
	pixel_error = 0;
	assert_true(levels > 10);
}

static void nodata_shows_what_is_behind_and_nothing_else_does(void **state)
{
	need_gpu();
	memset(&ground, 0, sizeof ground);
	ground.hole[0] = 190;
	ground.hole[1] = 190;
	ground.hole[2] = 210;
	ground.hole[3] = 210;
	begin(0);
	uint8_t background[4];
	find_background(background);
	uint8_t *pixels = draw(200, 200, 100, 200, 200.001, 0);
	/* Triangles from 188 to 212 touch a hole; a metre is this many pixels from 100 m above. */
	double scale = HEIGHT / 2.0 / tan(0.45) / 100;
	for (int y = 0; y < HEIGHT; y++)
		for (int x = 0; x < WIDTH; x++) {
			double dx = fabs(x + 0.5 - WIDTH / 2.0) / scale, dy = fabs(y + 0.5 - HEIGHT / 2.0) / scale;
			double far = fmax(dx, dy);
			bool corner = dx > 7 && dx < 13 && dy > 7 && dy < 13; /* half of it may be drawn */
			if (fabs(far - 12) < 1 || corner)
				continue;
			assert_int_equal(memcmp(pixel(pixels, x, y), background, 4) == 0, far < 12);
		}
	test_free(pixels);
	end();
}

static void a_rut_is_darker_than_the_ground_beside_it(void **state)
{
	need_gpu();
	const uint64_t effects[] = {0, EFFECT_BIT(EFFECT_TEXTURE), ALL};
	memset(&ground, 0, sizeof ground);
	ground.rut[0] = 194;
	ground.rut[1] = 0;
	ground.rut[2] = 206;
	ground.rut[3] = 512;
	ground.deep = 0.2;
	for (size_t e = 0; e < 3; e++) {
		begin(effects[e]);
		uint8_t *pixels = draw(200, 200, 60, 200, 200.001, 0);
		long in = 0, beside = 0;
		for (int y = 0; y < HEIGHT; y++) {
			in += luminance(pixel(pixels, WIDTH / 2, y));
			beside += luminance(pixel(pixels, WIDTH / 2 + 30, y));
		}
		assert_true(in * 10 < beside * 9);
		test_free(pixels);
		end();
	}
}

static void an_untouched_tile_has_a_program_without_offsets(void **state)
{
	need_gpu();
	memset(&ground, 0, sizeof ground);
	begin(EFFECT_BIT(EFFECT_FOG));
	struct gpu_stats before, after;
	gpu_stats(gpu, &before);
	test_free(draw(200, 200, 60, 200, 200.001, 0));
	gpu_stats(gpu, &after);
	assert_int_equal(after.programs - before.programs, 1);
	assert_int_equal(after.passes[GPU_TERRAIN] - before.passes[GPU_TERRAIN], selection.draw_count);
	end();
}

static void the_same_view_gives_the_same_bits(void **state)
{
	need_gpu();
	memset(&ground, 0, sizeof ground);
	ground.roughness = 1;
	begin(ALL);
	uint8_t *first = draw(100, 90, 25, 250, 260, -10), *other = draw(300, 90, 25, 250, 260, -10);
	uint8_t *again = draw(100, 90, 25, 250, 260, -10);
	assert_memory_equal(first, again, 4 * WIDTH * HEIGHT);
	assert_memory_not_equal(first, other, 4 * WIDTH * HEIGHT);
	test_free(first);
	test_free(other);
	test_free(again);
	end();
}

/* Mean difference of two pictures' pixels, 0 .. 255. */
static double difference(const uint8_t *a, const uint8_t *b)
{
	double sum = 0;
	for (int i = 0; i < 4 * WIDTH * HEIGHT; i++)
		sum += abs(a[i] - b[i]);
	return sum / (3.0 * WIDTH * HEIGHT);
}

/* The largest jump between pictures five centimetres apart where the mesh changed: by how much more
 * they differ than the pair before them, where only the eye had moved. */
static double largest_jump(uint64_t effects)
{
	double largest = 0, usual = 0;
	int changes = 0;
	begin(effects);
	uint8_t *before = draw(60, 60, 20, 300, 300, 0);
	uint64_t triangles = render_triangles(render);
	for (int i = 1; i < 240; i++) {
		uint8_t *now = draw(60 + 0.05 * i, 60, 20, 300, 300, 0);
		double apart = difference(before, now);
		if (render_triangles(render) != triangles) {
			largest = fmax(largest, apart - usual);
			changes++;
		} else {
			usual = apart;
		}
		triangles = render_triangles(render);
		test_free(before);
		before = now;
	}
	test_free(before);
	end();
	assert_true(changes > 3);
	return largest;
}

static void geomorphing_takes_the_jumps_out_of_the_mesh(void **state)
{
	need_gpu();
	memset(&ground, 0, sizeof ground);
	ground.roughness = 1;
	double without = largest_jump(0), with = largest_jump(EFFECT_BIT(EFFECT_GEOMORPH));
	print_message("largest jump: %g without, %g with\n", without, with);
	assert_true(with < without / 3);
}

static void say_reaches(double of_2, double of_4, double of_more)
{
	for (int k = 0; k < TERRAIN_STRIDES; k++)
		said_errors[k] = (k == 0 ? 0 : k == 1 ? of_2 : k == 2 ? of_4 : of_more) / (HEIGHT / 2.0 / tan(0.45));
}

/* Tiles all of one level, so that nothing but the mesh changes: light is computed from posts. */
static void geomorphing_takes_the_jumps_out_by_pixel_error(void **state)
{
	need_gpu();
	/* Strides of 2 from 96 m on, of 4 from twice that; then both from 96 m. */
	const double reaches[2][2] = {{96, 192}, {96, 96}};
	memset(&ground, 0, sizeof ground);
	ground.roughness = 1;
	for (int i = 0; i < 2; i++) {
		pixel_error = 1;
		say_reaches(reaches[i][0], reaches[i][1], 1000);
		double without = largest_jump(0), with = largest_jump(EFFECT_BIT(EFFECT_GEOMORPH));
		memset(said_errors, 0, sizeof said_errors);
		pixel_error = 0;
		print_message("largest jump: %g without, %g with\n", without, with);
		assert_true(with < without / 3);
	}
}

/* The middle of what is seen from 85 m above, where all distances are about the same. */
static uint8_t *draw_middle(double of_2, double of_4)
{
	pixel_error = 1;
	say_reaches(of_2, of_4, 5000);
	begin(EFFECT_BIT(EFFECT_GEOMORPH));
	uint8_t *pixels = draw(200, 200, 85, 200, 200.001, 0);
	end();
	memset(said_errors, 0, sizeof said_errors);
	pixel_error = 0;
	for (int y = 0; y < HEIGHT; y++)
		for (int x = 0; x < WIDTH; x++)
			if (abs(x - WIDTH / 2) > WIDTH / 6 || abs(y - HEIGHT / 2) > HEIGHT / 4)
				memset(pixels + 4 * (WIDTH * y + x), 0, 4);
	return pixels;
}

static void half_way_to_a_stride_the_ground_is_half_way_there(void **state)
{
	need_gpu();
	memset(&ground, 0, sizeof ground);
	ground.roughness = 0.3;
	/* Strides of 1, of 2, between; of 4, and all but there from 2. */
	uint8_t *fine = draw_middle(4000, 5000), *two = draw_middle(20, 5000), *between = draw_middle(98, 5000);
	uint8_t *four = draw_middle(20, 20), *nearly = draw_middle(20, 90);
	double apart = difference(fine, two);
	assert_true(apart > 0 && difference(fine, between) < 0.8 * apart && difference(between, two) < 0.8 * apart);
	assert_true(difference(nearly, four) < 0.5 * difference(two, four));
	test_free(fine);
	test_free(two);
	test_free(between);
	test_free(four);
	test_free(nearly);
}

static void however_coarse_a_neighbour_no_sky_is_between(void **state)
{
	need_gpu();
	memset(&ground, 0, sizeof ground);
	ground.roughness = 1;
	/* All relief, 25 m, is allowed from 60 m on: every other tile is drawn as coarsely as can be. */
	pixel_error = 25 / 60.0 * (HEIGHT / 2.0 / tan(0.45));
	said_of_half = true;
	for (int k = 0; k < TERRAIN_STRIDES; k++)
		said_errors[k] = k > 0 ? 1e6 : 0;
	begin(EFFECT_BIT(EFFECT_SKIRTS) | EFFECT_BIT(EFFECT_GEOMORPH));
	uint8_t background[4];
	find_background(background);
	for (int i = 0; i < 30; i++) {
		double x = 40 + 4.1 * i, y = 130 - 3.0 * i, turn = 0.5 + 0.02 * i;
		uint8_t *pixels = draw(x, y, 40, x + 85 * cos(turn), y + 85 * sin(turn), -31);
		assert_int_equal(count_background(pixels, background), 0);
		test_free(pixels);
	}
	end();
	memset(said_errors, 0, sizeof said_errors);
	said_of_half = false;
	pixel_error = 0;
}

/* The more pixels are allowed, the fewer triangles, and the further from the picture of all of them. */
static void a_pixel_error_trades_triangles_for_truth(void **state)
{
	need_gpu();
	const double errors[] = {1e-6, 0.01, 0.03, 0.1};
	uint8_t *truth = NULL;
	uint64_t triangles = UINT64_MAX;
	double apart = -1;
	memset(&ground, 0, sizeof ground);
	ground.smooth = true;
	ground.roughness = 1;
	for (size_t i = 0; i < sizeof errors / sizeof *errors; i++) {
		pixel_error = errors[i];
		begin(EFFECT_BIT(EFFECT_SKIRTS) | EFFECT_BIT(EFFECT_GEOMORPH));
		uint8_t *pixels = draw(60, 60, 20, 300, 300, 0);
		if (truth == NULL)
			truth = pixels;
		double now = difference(truth, pixels);
		print_message("%g pixels: %d triangles, %zu tiles, %g off\n", errors[i], (int)render_triangles(render),
			      selection.draw_count, now);
		assert_true(render_triangles(render) < triangles && now > apart);
		triangles = render_triangles(render);
		apart = now;
		if (pixels != truth)
			test_free(pixels);
		end();
	}
	test_free(truth);
	pixel_error = 0;
}

/* Blocks of the last selection's draws, and edges of them with skirts, found anew. */
static void count_blocks(const struct render_camera *camera, uint64_t *count, uint64_t *skirts)
{
	struct render_axes axes;
	struct terrain_view view;
	struct render_blocks blocks = {NULL, 0, 0};
	render_axes(render, camera, &axes);
	render_view(render, camera, &view);
	*skirts = 0;
	for (size_t i = 0; i < selection.draw_count; i++) {
		double reaches[TERRAIN_STRIDES];
		render_reaches(render, &axes, &selection.draws[i], reaches);
		assert_ok(render_blocks_add(&blocks, &extent, &view, reaches, &selection.draws[i]));
	}
	*count = blocks.count;
	for (size_t i = 0; i < blocks.count; i++)
		for (int edge = 24; edge < 28; edge++)
			*skirts += blocks.blocks[i] >> edge & 1;
	mem_free(blocks.blocks);
}

/* Hills behind hills: tiles and blocks are drawn near to far, so little is drawn twice. */
static void hills_are_drawn_near_to_far_and_triangles_are_those_of_blocks(void **state)
{
	need_gpu();
	const uint64_t effects[] = {0, EFFECT_BIT(EFFECT_SKIRTS)};
	memset(&ground, 0, sizeof ground);
	ground.roughness = 1;
	for (size_t e = 0; e < 2; e++) {
		double most = 0, least = 9, reversed = 0, sum;
		begin(effects[e]);
		for (int i = 0; i < 12; i++) {
			double x = 256 + 200 * cos(i * 0.52), y = 256 + 200 * sin(i * 0.52);
			const struct render_camera camera = {{x, y, 400 + 18}, {256, 256, 400}, 0.9, {0}};
			test_free(draw(x, y, 18, 256, 256, 0));
			uint64_t blocks, skirts, cells = render_block_cells(&extent);
			count_blocks(&camera, &blocks, &skirts);
			assert_true(blocks > 50 && (effects[e] == 0 || skirts > 0));
			assert_true(render_triangles(render) == 2 * cells * cells * blocks + (effects[e] != 0 ? 2 * cells * skirts : 0));
			gpu_finish(gpu);
			uint64_t frames = render_take_overdraw(render, &sum);
			assert_true(frames == 1);
			most = fmax(most, sum);
			least = fmin(least, sum);
			/* The same from far to near. */
			for (size_t k = 0; k < selection.draw_count / 2; k++) {
				struct terrain_draw kept = selection.draws[k];
				selection.draws[k] = selection.draws[selection.draw_count - 1 - k];
				selection.draws[selection.draw_count - 1 - k] = kept;
			}
			assert_ok(render_frame(render, &camera, &selection));
			gpu_finish(gpu);
			assert_true(render_take_overdraw(render, &sum) == 1);
			reversed = fmax(reversed, sum);
		}
		print_message("overdraw %.3f to %.3f; at most %.3f where the farthest tiles are drawn first\n", least, most, reversed);
		assert_true(least > 0.2 && most < 0.68 && reversed > 0.68);
		end();
	}
}

static void a_tile_looks_the_same_ten_thousand_kilometres_away(void **state)
{
	need_gpu();
	static const struct extent wide = {40000001, 40000001, 0.25, CELLS};
	static int32_t base[POSTS * POSTS];
	uint8_t *pixels[2];
	for (int j = 0; j < POSTS; j++)
		for (int i = 0; i < POSTS; i++)
			base[j * POSTS + i] = lattice_base_relative(8000 + sin(i * 0.4) * cos(j * 0.3), 8192);
	for (int far = 0; far < 2; far++) {
		/* Moved by a whole number of the ground pattern's periods. */
		uint32_t shift = far ? 600 * 16384 / 16 : 0;
		struct render_params params = {
			.gpu = gpu, .extent = &wide, .reference = 8192, .low = 7999, .high = 8001, .width = WIDTH,
			.height = HEIGHT, .effects = ALL & ~(EFFECT_BIT(EFFECT_SKY)),
		};
		struct render_camera camera = {{shift * 16.0 + 18, shift * 16.0 + 17, 8006}, {shift * 16.0 + 25, shift * 16.0 + 25, 8000}, 0.9, {0}};
		assert_ok(gpu_slots_create(gpu, CELLS, 1, 0, &slots));
		params.slots = slots;
		assert_ok(render_create(&params, &render));
		assert_ok(staged_upload_base(gpu, slots, CELLS, 0, base));
		selection.draw_count = 1;
		selection.draws[0] = (struct terrain_draw){
			.tile = {0, shift + 1, shift + 1}, .quadrants = 15, .finest = true, .low = 7999, .high = 8001,
		};
		assert_ok(render_frame(render, &camera, &selection));
		pixels[far] = test_malloc(4 * WIDTH * HEIGHT);
		gpu_texture_read(render->colour, 0, (struct gpu_rect){0, 0, WIDTH, HEIGHT}, pixels[far]);
		end();
	}
	assert_true(difference(pixels[0], pixels[1]) < 0.02);
	test_free(pixels[0]);
	test_free(pixels[1]);
}

/* Of texture, detail, fog, sky, geomorphing and skirts: none, all, and any two in all four ways. */
static void any_two_effects_draw_together(void **state)
{
	enum { EFFECTS = EFFECT_SKIRTS - EFFECT_TEXTURE + 1 };
	need_gpu();
	for (int one = 0; one < EFFECTS; one++)
		for (int other = 0; other < one; other++)
			assert_int_equal(pairs_met(one, other), 15);
	memset(&ground, 0, sizeof ground);
	ground.roughness = 1;
	static int32_t posts[POSTS * POSTS];
	static uint8_t dirt[POSTS * POSTS];
	for (int i = 0; i < PAIRS_CHOICES; i++) {
		uint64_t chosen = pairs_choices[i] & ((1u << EFFECTS) - 1); /* the first: all */
		struct render_params params = {
			.gpu = gpu, .extent = &extent, .low = -1, .high = 1, .width = 32, .height = 16,
			.effects = chosen << EFFECT_TEXTURE, .dirt = true,
		};
		assert_ok(gpu_slots_create(gpu, CELLS, 3, PLANE_BIT(PLANE_DISTURBANCE), &slots));
		params.slots = slots;
		assert_ok(render_create(&params, &render));
		for (uint32_t k = 0; k < 3; k++)
			assert_ok(staged_upload_base(gpu, slots, CELLS, k, posts));
		assert_ok(staged_upload_deform(gpu, slots, CELLS, 1, posts, dirt));
		assert_ok(staged_upload_deform(gpu, slots, CELLS, 2, posts, dirt));
		selection.draw_count = 3;
		for (uint32_t k = 0; k < 3; k++)
			selection.draws[k] = (struct terrain_draw){
				.tile = {k == 2 ? -1 : 0, k, 0}, .slot = k, .ground = k == 2 ? 0 : k, .quadrants = 15,
				.low = -1, .high = 1,
			};
		struct render_camera camera = {{100, -30, 60}, {100, 64, 0}, 0.9, {0}};
		assert_ok(render_frame(render, &camera, &selection));
		assert_true(render_triangles(render) > 0);
		end();
	}
}

static void what_cannot_be_allocated_is_told(void **state)
{
	need_gpu();
	struct render_params params = {
		.gpu = gpu, .extent = &extent, .low = 0, .high = 1, .width = 32, .height = 16, .effects = ALL,
	};
	assert_ok(gpu_slots_create(gpu, CELLS, 1, 0, &slots));
	params.slots = slots;
	enum status status = STATUS_FAILED;
	int failed = 0;
	for (uint64_t nth = 1; status != STATUS_OK; nth++) {
		mem_fail_nth(nth, 0);
		status = render_create(&params, &render);
		mem_fail_nth(0, 0);
		failed += status != STATUS_OK;
		assert_true(nth < 100);
	}
	assert_true(failed >= 5);
	end();
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(no_sky_is_seen_through_the_ground),
		cmocka_unit_test(no_sky_is_seen_through_the_ground_by_pixel_error),
		cmocka_unit_test(nodata_shows_what_is_behind_and_nothing_else_does),
		cmocka_unit_test(a_rut_is_darker_than_the_ground_beside_it),
		cmocka_unit_test(an_untouched_tile_has_a_program_without_offsets),
		cmocka_unit_test(what_is_drawn_unseen_is_not_seen),
		cmocka_unit_test(the_same_view_gives_the_same_bits),
		cmocka_unit_test(geomorphing_takes_the_jumps_out_of_the_mesh),
		cmocka_unit_test(geomorphing_takes_the_jumps_out_by_pixel_error),
		cmocka_unit_test(half_way_to_a_stride_the_ground_is_half_way_there),
		cmocka_unit_test(however_coarse_a_neighbour_no_sky_is_between),
		cmocka_unit_test(a_pixel_error_trades_triangles_for_truth),
		cmocka_unit_test(hills_are_drawn_near_to_far_and_triangles_are_those_of_blocks),
		cmocka_unit_test(a_tile_looks_the_same_ten_thousand_kilometres_away),
		cmocka_unit_test(any_two_effects_draw_together),
		cmocka_unit_test(what_cannot_be_allocated_is_told),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
