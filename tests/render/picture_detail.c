/* Detail that changes with the distance: geomorphing hides the change, and a pixel error bounds what is lost. Skipped without GL. */
#include "../support/near.h"
#include "picture_rig.h"
#include "../support/program.h"

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
			largest = support_most(largest, apart - usual);
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
	for (int k = 0; k < RENDER_STRIDES; k++)
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

TEST_PROGRAM(picture_detail)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(geomorphing_takes_the_jumps_out_of_the_mesh),
		cmocka_unit_test(geomorphing_takes_the_jumps_out_by_pixel_error),
		cmocka_unit_test(half_way_to_a_stride_the_ground_is_half_way_there),
		cmocka_unit_test(a_pixel_error_trades_triangles_for_truth),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
