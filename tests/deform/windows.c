/* The laws a window must keep: what it makes of the ground depends on no tile, no cut and no place. */
#include "ground.h"
#include "../support/program.h"


static int64_t shift_x, shift_y; /* of `hilly`, posts */

static int32_t hilly(int64_t x, int64_t y)
{
	double u = (double)(x - shift_x), v = (double)(y - shift_y);
	if ((x - shift_x + 2 * (y - shift_y)) % 37 == 0)
		return BASE_NODATA;
	return (int32_t)lattice_base(0.4 * sin(u * 0.21) * cos(v * 0.17));
}

static int32_t summit(int64_t x, int64_t y)
{
	int32_t height = hilly(x, y);
	return height == BASE_NODATA ? height : height + (int32_t)lattice_base(7900);
}

static const struct soil_shape shapes[] = {
	{.kind = SOIL_WHEEL, .radius = 2.1, .width = 1.3},
	{.kind = SOIL_SPHERE, .radius = 3.3},
	{.kind = SOIL_BOX, .size = {5.2, 2.9, 1.7}},
	{.kind = SOIL_WHEEL, .radius = 1.7, .width = 1.1, .grousers = 11, .grouser_height = 0.3, .grouser_thickness = 0.2},
	{.kind = SOIL_CYLINDER, .radius = 1.4, .length = 3.5},
	{.kind = SOIL_CAPSULE, .radius = 1.2, .length = 2.5},
	{.kind = SOIL_ELLIPSOID, .size = {2.3, 1.2, 0.9}},
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

/* A few objects across the middle, by stations; all coordinates in posts and metres from there. */
static void drive(struct ground *ground, double height)
{
	double middle = (double)(ground->posts - 1) / 2;
	for (int k = 0; k < SHAPES; k++) {
		struct soil_pose last = {0};
		for (int i = 0; i < 12; i++) {
			double x = middle - 7 + i * 1.25 - k % 3, y = middle - 5 + i * 0.875 + k % 3 * 2;
			struct soil_pose pose = ground_pose(ground, x, y, height + 0.75 - 0.015625 * i + k % 3 * 0.5);
			pose.yaw = 0.3 * i;
			pose.pitch = k >= 2 ? 0.11 * i : 0;
			pose.roll = k >= 2 ? -0.17 * i : 0;
			struct deform_contact sweep = {.shape = &shapes[k], .from = i == 0 ? pose : last, .to = pose, .turned = 0.2};
			ground_sweep(ground, &sweep);
			last = pose;
		}
	}
	ground_read(ground);
}

static struct ground_params usual(void)
{
	return (struct ground_params){.cells = 256, .tiles = 1, .spacing = 0.25, .height = hilly, .model = DEFORM_BOX_FILTER,
				      .radius = 2, .repetitions = 2, .dirt = true};
}

static void assert_same_ground(const struct ground *a, const struct ground *b)
{
	size_t posts = (size_t)(a->posts * a->posts);
	int changed = 0;
	assert_int_equal(a->posts, b->posts);
	for (size_t i = 0; i < posts; i++)
		changed += a->offset[i] != 0 && a->dirt[i] != 0;
	assert_true(changed > 500);
	assert_memory_equal(a->offset, b->offset, posts * sizeof *a->offset);
	assert_memory_equal(a->dirt, b->dirt, posts);
}

static void tiles_of_any_size_hold_the_same_bits(void **state)
{
	struct ground_params params = usual();
	struct ground one, cut;
	(void)state;
	need_gpu();
	ground_init(&one, &params);
	drive(&one, 0);
	for (uint32_t cells = 8; cells < 256; cells *= 2) {
		params.cells = cells;
		params.tiles = 256 / cells;
		ground_init(&cut, &params);
		drive(&cut, 0); /* ground_read compares what tiles share, the four-corner in the middle too */
		assert_same_ground(&one, &cut);
		ground_finish(&cut);
	}
	ground_finish(&one);
}

static void ten_thousand_kilometres_away_are_the_same_bits(void **state)
{
	static const double spacing[] = {0.25, 0.140625, 0.0009765625 * 93};
	struct ground near, far;
	(void)state;
	need_gpu();
	for (size_t i = 0; i < 3; i++) {
		struct ground_params params = usual();
		params.spacing = spacing[i];
		ground_init(&near, &params);
		drive(&near, 0);
		params.first = (int64_t)(1e7 / spacing[i] / 256);
		ground_init(&far, &params);
		drive(&far, 0);
		assert_same_ground(&near, &far);
		ground_finish(&near);
		ground_finish(&far);
	}
}

static void heights_do_not_matter(void **state)
{
	struct ground_params params = usual();
	struct ground sea, high;
	(void)state;
	need_gpu();
	ground_init(&sea, &params);
	drive(&sea, 0);
	params.height = summit; /* all within one reference */
	ground_init(&high, &params);
	drive(&high, 7900);
	assert_same_ground(&sea, &high);
	ground_finish(&high);
	for (int i = 0; i < 2; i++) {
		params.height = i == 0 ? hilly : summit;
		params.reference = i == 0 ? 8192 : -11 * 1024 - 7 * 1024;
		ground_init(&high, &params);
		drive(&high, params.reference + (i == 0 ? 0 : 7900));
		assert_same_ground(&sea, &high);
		ground_finish(&high);
	}
	ground_finish(&sea);
}

/* One sweep of a shape too large for a window, moved by whole posts with the ground under it. */
static void sweep_large(struct ground *ground, const struct soil_shape *shape, int64_t dx, int64_t dy)
{
	double x = 500 + (double)dx, y = 520 + (double)dy;
	struct deform_contact sweep = {.shape = shape, .from = ground_pose(ground, x, y, shape->radius - 1), .to = ground_pose(ground, x + 3.25, y + 2.5, shape->radius - 1.25)};
	sweep.to.yaw = 0.7;
	sweep.to.pitch = shape->kind != SOIL_SPHERE ? 0.05 : 0;
	sweep.to.roll = shape->kind != SOIL_SPHERE ? -0.03 : 0;
	ground_sweep(ground, &sweep);
	ground_read(ground);
}

static void cuts_between_windows_leave_no_trace(void **state)
{
	static const struct soil_shape large[] = {
		{.kind = SOIL_SPHERE, .radius = 60}, {.kind = SOIL_BOX, .size = {90, 70, 3}}, {.kind = SOIL_CYLINDER, .radius = 40, .length = 90},
		{.kind = SOIL_CAPSULE, .radius = 45, .length = 40}, {.kind = SOIL_ELLIPSOID, .size = {50, 40, 30}}};
	static const int64_t moved[][2] = {{37, 0}, {-101, 59}, {128, -20}};
	(void)state;
	need_gpu();
	for (int k = 0; k < 5; k++) {
		struct ground_params params = {.cells = 1024, .tiles = 1, .spacing = 0.25, .height = hilly,
					       .model = DEFORM_BOX_FILTER, .radius = 3, .repetitions = 3};
		struct ground first, other;
		ground_init(&first, &params);
		sweep_large(&first, &large[k], 0, 0);
		assert_true(first.window_count >= 4);
		for (size_t i = 0; i < first.window_count; i++)
			assert_true(first.windows[i].read.x1 - first.windows[i].read.x0 <= DEFORM_WINDOW_POSTS &&
				    first.windows[i].read.y1 - first.windows[i].read.y0 <= DEFORM_WINDOW_POSTS);
		for (int m = 0; m < 3; m++) {
			shift_x = moved[m][0];
			shift_y = moved[m][1];
			ground_init(&other, &params);
			sweep_large(&other, &large[k], shift_x, shift_y);
			int differ = 0, changed = 0;
			for (int64_t y = 150; y < 850; y++)
				for (int64_t x = 150; x < 850; x++) {
					int32_t a = first.offset[y * first.posts + x];
					differ += a != other.offset[(y + shift_y) * first.posts + x + shift_x];
					changed += a != 0;
				}
			assert_true(changed > 1000);
			assert_int_equal(differ, 0);
			ground_finish(&other);
			shift_x = shift_y = 0;
		}
		ground_finish(&first);
	}
}

static void a_large_sphere_is_that_of_the_reference_in_every_window(void **state)
{
	struct ground ground;
	int posts = 0;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 1024, .tiles = 1, .spacing = 0.25});
	struct soil_shape shape = {.kind = SOIL_SPHERE, .radius = 60};
	struct deform_contact sweep = {.shape = &shape, .from = ground_pose(&ground, 510.3, 511.8, -10), .to = ground_pose(&ground, 512.9, 512.1, -10.4)};
	ground_sweep(&ground, &sweep);
	ground_read(&ground);
	for (int64_t i = 0; i < ground.posts * ground.posts; i += 5) {
		long double z, x = ground_from(&ground, i % ground.posts, sweep.from.x);
		long double y = ground_from(&ground, i / ground.posts, sweep.from.y);
		if (!reference_underside(&sweep, x, y, &z)) {
			assert_int_equal(ground.offset[i], 0);
			continue;
		}
		/* Nearer to its edge, so large an object is too steep for its own coordinates. */
		if (hypotl(x, y) < 59.8L && ldexpl(z, OFFSET_BITS) + sweep.from.z < 0) {
			assert_true(fabsl(ldexpl(ground.offset[i] - sweep.from.z, -OFFSET_BITS) - z) < 4e-6L);
			posts++;
		}
	}
	assert_true(posts > 30000);
	ground_finish(&ground);
}

static void a_sweep_holds_its_own_halves(void **state)
{
	struct ground whole, halves;
	(void)state;
	need_gpu();
	for (int k = 0; k < SHAPES; k++) {
		if (shapes[k].grousers > 0)
			continue; /* they turn in between */
		struct ground_params params = {.cells = 64, .tiles = 1, .spacing = 0.25};
		ground_init(&whole, &params);
		ground_init(&halves, &params);
		struct soil_pose a = ground_pose(&whole, 30, 31, -4), c = ground_pose(&whole, 32, 32, -4.25), b = a;
		b.x = (a.x + c.x) / 2;
		b.y = (a.y + c.y) / 2;
		b.z = (a.z + c.z) / 2;
		a.yaw = b.yaw = c.yaw = 0.6;
		a.pitch = b.pitch = c.pitch = k > 2 ? 0.4 : 0;
		a.roll = b.roll = c.roll = k > 2 ? -0.3 : 0;
		ground_sweep(&whole, &(struct deform_contact){.shape = &shapes[k], .from = a, .to = c});
		ground_sweep(&halves, &(struct deform_contact){.shape = &shapes[k], .from = a, .to = b});
		ground_sweep(&halves, &(struct deform_contact){.shape = &shapes[k], .from = b, .to = c});
		ground_read(&whole);
		ground_read(&halves);
		int pressed = 0;
		for (int64_t i = 0; i < whole.posts * whole.posts; i++) {
			assert_in_range(whole.offset[i] - halves.offset[i] + 4, 0, 8);
			pressed += whole.offset[i] != 0;
		}
		assert_true(pressed > 50);
		ground_finish(&whole);
		ground_finish(&halves);
	}
}

static void nothing_that_was_not_asked_for_is_made_or_run(void **state)
{
	static const uint32_t planes[2] = {4, 6}; /* of scratch without dirt, by model */
	(void)state;
	need_gpu();
	for (int i = 0; i < 4; i++) {
		struct ground_params params = usual();
		struct gpu_stats before, after;
		struct ground ground;
		params.model = i / 2 == 0 ? DEFORM_NONE : DEFORM_BOX_FILTER;
		params.dirt = i % 2 == 1;
		gpu_stats(test_gpu, &before);
		ground_init(&ground, &params);
		gpu_stats(test_gpu, &after);
		uint32_t expected = params.dirt ? 8 : planes[i / 2];
		assert_int_equal(after.textures - before.textures, 1 + expected);
		before = after;
		struct deform_contact sweep = {.shape = &shapes[0], .from = ground_pose(&ground, 100, 100, 1), .to = ground_pose(&ground, 101, 100, 1)};
		ground_sweep(&ground, &sweep);
		gpu_stats(test_gpu, &after);
		assert_int_equal(gpu_group_passes(&after, GPU_DISPLACE) - gpu_group_passes(&before, GPU_DISPLACE), 2);
		assert_int_equal(gpu_group_passes(&after, GPU_REDISTRIBUTE) - gpu_group_passes(&before, GPU_REDISTRIBUTE),
				 params.model == DEFORM_BOX_FILTER ? 2 : 0);
		assert_int_equal(gpu_group_passes(&after, GPU_ATTRIBUTES) - gpu_group_passes(&before, GPU_ATTRIBUTES), params.dirt ? 1 : 0);
		before = after;
		sweep.from = sweep.to; /* a contact smooths nothing */
		ground_sweep(&ground, &sweep);
		gpu_stats(test_gpu, &after);
		assert_int_equal(gpu_group_passes(&after, GPU_REDISTRIBUTE) - gpu_group_passes(&before, GPU_REDISTRIBUTE), 0);
		ground_finish(&ground);
	}
}

TEST_PROGRAM(windows)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(tiles_of_any_size_hold_the_same_bits),
		cmocka_unit_test(ten_thousand_kilometres_away_are_the_same_bits),
		cmocka_unit_test(heights_do_not_matter),
		cmocka_unit_test(cuts_between_windows_leave_no_trace),
		cmocka_unit_test(a_large_sphere_is_that_of_the_reference_in_every_window),
		cmocka_unit_test(a_sweep_holds_its_own_halves),
		cmocka_unit_test(nothing_that_was_not_asked_for_is_made_or_run),
	};
	return cmocka_run_group_tests_name("deform/windows", tests, open_gpu, close_gpu);
}
