/* Tiles and blocks of several levels in one picture: no sky is seen between them, what closes the gaps looks like the ground, and blocks
 * are drawn near to far. Shadows of the ground go on from map to map. Skipped without GL. */
#include "../support/near.h"
#include "picture_rig.h"
#include "../support/program.h"

static int count_background(const uint8_t *pixels, const uint8_t background[4])
{
	int count = 0;
	for (int i = 0; i < WIDTH * HEIGHT; i++)
		count += memcmp(pixels + 4 * i, background, 4) == 0;
	return count;
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

static void however_coarse_a_neighbour_no_sky_is_between(void **state)
{
	need_gpu();
	memset(&ground, 0, sizeof ground);
	ground.roughness = 1;
	/* All relief, 25 m, is allowed from 60 m on: every other tile is drawn as coarsely as can be. */
	pixel_error = 25 / 60.0 * (HEIGHT / 2.0 / tan(0.45));
	said_of_half = true;
	for (int k = 0; k < RENDER_STRIDES; k++)
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

#define LUMINANCE(pixels, i) ((pixels)[4 * (i)] + 2 * (pixels)[4 * (i) + 1] + (pixels)[4 * (i) + 2])
#define DEGREES (M_PI / 180)

/* A rut crosses tiles that are too coarse to have it. There skirts are seen. The sun is behind them, high above the rut's other end, so that
 * nothing has a shadow. */
static void a_skirt_is_as_bright_as_the_ground_above_it(void **state)
{
	need_gpu();
	uint8_t *pixels[2];
	memset(&ground, 0, sizeof ground);
	memcpy(ground.rut, (const double[4]){201, 0, 203, 512}, sizeof ground.rut);
	ground.deep = 3;
	pixel_error = 25 / 60.0 * (HEIGHT / 2.0 / tan(0.45));
	said_of_half = true;
	for (int k = 1; k < RENDER_STRIDES; k++)
		said_errors[k] = 1e6;
	for (int e = 0; e < 2; e++) {
		begin(EFFECT_BIT(EFFECT_SKIRTS) | (e > 0 ? EFFECT_BIT(EFFECT_TERRAIN_SHADOW) : 0));
		render_move_sun(render, 0, 60 * DEGREES);
		pixels[e] = draw(202, 226, 2, 202, 256, -1);
		end();
	}
	memset(said_errors, 0, sizeof said_errors);
	said_of_half = false;
	pixel_error = 0;
	int darkest = 0;
	for (int i = 0; i < WIDTH * HEIGHT; i++) {
		const int darker = LUMINANCE(pixels[0], i) - LUMINANCE(pixels[1], i);
		darkest = darker > darkest ? darker : darkest;
	}
	test_free(pixels[0]);
	test_free(pixels[1]);
	if (!(darkest <= 40))
		fail_msg("some of it is darker by %d of 1020", darkest);
}

/* Where a row of the picture meets level ground at 400 m, north of the eye: metres ahead of it; and the width of a pixel there. */
static double ahead_of(const struct render_camera *camera, int row, double *pixel)
{
	struct render_axes axes;
	render_axes(render, camera, &axes);
	const double up = (row + 0.5 - HEIGHT / 2.0) / axes.focal;
	const double part = (400 - camera->eye[2]) / (axes.forward[2] + up * axes.up[2]);
	*pixel = part / axes.focal;
	return part * (axes.forward[1] + up * axes.up[1]);
}

/* A straight bank, 1.5 m high, and the sun 6 degrees high beside it. The edge of its shadow is a straight line 14 m beside the bank. It passes
 * from one map of shadows to the next, 67 m ahead. */
static void a_shadow_has_no_step_where_maps_meet(void **state)
{
	need_gpu();
	const struct render_camera camera = {{190, 40, 420}, {190, 140, 400}, 0.9, {0}};
	memset(&ground, 0, sizeof ground);
	memcpy(ground.rut, (const double[4]){200, 0, 204, 512}, sizeof ground.rut);
	ground.deep = -1.5;
	begin(EFFECT_BIT(EFFECT_SKIRTS) | EFFECT_BIT(EFFECT_TERRAIN_SHADOW));
	tile_radius = 9;
	render_move_sun(render, 90 * DEGREES, 6 * DEGREES);
	uint8_t *pixels = draw(190, 40, 20, 190, 140, 0);
	const double beside = 200 - 1.5 / tan(6 * DEGREES);
	double before = NAN, most = 0, worst = 0;
	int rows = 0;
	for (int row = 0; row < HEIGHT; row++) {
		double pixel, ahead = ahead_of(&camera, row, &pixel);
		if (!(ahead > 30 && ahead < 110))
			continue;
		/* In the shadow is 194 m east, in the sun 176 m. */
		const int dark = (int)(WIDTH / 2 + 4 / pixel) + row * WIDTH, bright = (int)(WIDTH / 2 - 14 / pixel) + row * WIDTH;
		const int middle = (LUMINANCE(pixels, dark) + LUMINANCE(pixels, bright)) / 2;
		assert_true(LUMINANCE(pixels, bright) > LUMINANCE(pixels, dark) + 20);
		int at = bright;
		while (LUMINANCE(pixels, at) > middle)
			at++;
		const double edge = 190 + (at % WIDTH - WIDTH / 2) * pixel;
		worst = support_most(worst, fabs(edge - beside));
		most = isnan(before) ? most : fmax(most, fabs(edge - before) - pixel);
		before = edge;
		rows++;
	}
	print_message("%d rows: the edge is up to %.2f m off, and steps by %.2f m\n", rows, worst, most);
	assert_true(rows > 30 && most < 1.5 && worst < 4);
	test_free(pixels);
	end();
}

/* Blocks of the last selection's draws, and edges of them with skirts, found anew. */
static void count_blocks(const struct render_camera *camera, uint64_t *count, uint64_t *skirts)
{
	struct render_axes axes;
	struct render_view view;
	struct render_blocks blocks = {NULL, 0, 0};
	render_axes(render, camera, &axes);
	render_view(render, camera, &view);
	*skirts = 0;
	for (size_t i = 0; i < selection.draw_count; i++) {
		double reaches[RENDER_STRIDES];
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
			most = support_most(most, sum);
			least = support_least(least, sum);
			/* The same from far to near. */
			for (size_t k = 0; k < selection.draw_count / 2; k++) {
				struct render_draw kept = selection.draws[k];
				selection.draws[k] = selection.draws[selection.draw_count - 1 - k];
				selection.draws[selection.draw_count - 1 - k] = kept;
			}
			assert_ok(render_frame(render, &camera, &selection));
			gpu_finish(gpu);
			assert_true(render_take_overdraw(render, &sum) == 1);
			reversed = support_most(reversed, sum);
		}
		print_message("overdraw %.3f to %.3f; at most %.3f where the farthest tiles are drawn first\n", least, most, reversed);
		assert_true(least > 0.2 && most < 0.68 && reversed > 0.68);
		end();
	}
}

TEST_PROGRAM(picture_seams)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(no_sky_is_seen_through_the_ground),
		cmocka_unit_test(no_sky_is_seen_through_the_ground_by_pixel_error),
		cmocka_unit_test(however_coarse_a_neighbour_no_sky_is_between),
		cmocka_unit_test(a_skirt_is_as_bright_as_the_ground_above_it),
		cmocka_unit_test(a_shadow_has_no_step_where_maps_meet),
		cmocka_unit_test(hills_are_drawn_near_to_far_and_triangles_are_those_of_blocks),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
