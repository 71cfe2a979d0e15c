/*
 * Every post whose planes have changed is told as touched, whenever what says so comes: after each sweep and each interval
 * all planes are read back, and asked about post by post.
 */
#include "late.h"
#include "sliding.h"
#include "../support/program.h"

struct trip {
	enum deform_model model;
	uint32_t cells, tiles;
	double spacing;
	int iterations;
	resident_ground_height height;
	bool dirt;
	int samples;
};

static int32_t slope(int64_t x, int64_t y)
{
	return (int32_t)(x * 900 - y * 500) + conserve_rough(x, y) / 16;
}

static void begin(struct ground *ground, const struct trip *trip)
{
	struct soil_numbers soil;
	assert_ok(soil_named("dry_sand", &soil));
	soil.cohesion = 0;
	soil.theta_stop = soil.theta_out + 0.1;
	ground_init(ground, &(struct ground_params){.cells = trip->cells, .tiles = trip->tiles, .spacing = trip->spacing,
						    .model = trip->model, .iterations = trip->iterations, .soils = &soil,
						    .soil_count = 1, .height = trip->height, .relief = 100,
						    .dirt = trip->dirt, .stands = true, .touched = true});
}

static bool is_touched(struct ground *ground, int64_t x, int64_t y)
{
	bool is;
	assert_ok(deform_is_touched(ground->deform, (struct post_rect){x, y, x + 1, y + 1}, &is));
	return is;
}

/* How many posts have changed. */
static size_t assert_all_are_told(struct ground *ground, int n)
{
	bool heaps = deform_planes(ground->params.model, false, 0) & PLANE_BIT(PLANE_DEPOSITED);
	int32_t *heaped = heaps ? ground_plane(ground, PLANE_DEPOSITED) : NULL;
	size_t changed = 0;
	ground_read(ground);
	for (int64_t i = 0; i < ground->posts * ground->posts; i++) {
		int64_t x = i % ground->posts, y = i / ground->posts;
		if (ground->offset[i] == 0 && ground->dirt[i] == 0 && (!heaps || heaped[i] == 0))
			continue;
		changed++;
		if (!is_touched(ground, x, y))
			fail_msg("%d: post %lld, %lld has changed by %d", n, (long long)x, (long long)y, ground->offset[i]);
	}
	mem_free(heaped);
	return changed;
}

static size_t told(struct ground *ground)
{
	size_t count = 0;
	for (int64_t i = 0; i < ground->posts * ground->posts; i++)
		count += is_touched(ground, i % ground->posts, i / ground->posts);
	return count;
}

static void sweep_and_wake(struct ground *ground, const struct deform_contact *sweep)
{
	ground_sweep(ground, sweep);
	for (size_t i = 0; i < ground->window_count; i++)
		assert_ok(deform_wake_swept(ground->deform, &ground->windows[i], (uint32_t)i));
}

static void pass_interval(struct ground *ground)
{
	(void)interval(ground, NULL, 0);
	late_pass();
}

/* Of the bases in the sweep's windows, metres. */
static double highest(struct ground *ground, const struct deform_contact *sweep)
{
	int32_t most = INT32_MIN;
	assert_ok(deform_windows(ground->deform, sweep, ground->windows, &ground->window_count));
	for (int64_t i = 0; i < ground->posts * ground->posts; i++)
		if (ground->base[i] != BASE_NODATA && ground->base[i] > most && ground_written(ground, i))
			most = ground->base[i];
	return ldexp(most, -BASE_BITS);
}

/* Presses, deep or hardly; or hangs in the air just above all bases, where rims reach. Large: of several windows. */
static void any_station(struct ground *ground, bool above, bool large, double at[2])
{
	double d = ground->params.spacing, radius = (5 + 7 * fabs(any_share())) * d, length = large ? 180 * d : 2 * radius;
	bool box = above || large, jumps = large || any_word() % 6 == 0;
	const struct soil_shape shape = {.kind = box ? SOIL_BOX : SOIL_SPHERE, .radius = radius,
					 .size = {length, large ? length / 3 : radius, 2 * d}};
	struct deform_contact sweep = {.shape = &shape, .seconds = 0.05, .above = above};
	sweep.from = ground_pose(ground, at[0], at[1], 0);
	for (int i = 0; i < 2; i++)
		at[i] = jumps ? (double)ground->posts / 2 * (1 + (large ? 0.1 : 1.04) * any_share()) : at[i] + 12 * any_share();
	sweep.to = ground_pose(ground, at[0], at[1], 0);
	if (jumps)
		sweep.from = sweep.to;
	sweep.to.yaw = large ? M_PI / 4 : 3 * any_share();
	double lowest = highest(ground, &sweep);
	if (above)
		lowest += 0.03 * d + d * fabs(any_share()) * (double)(any_word() % 2);
	else
		lowest -= (large ? d : 0.8 * radius) * fabs(any_share());
	sweep.from.z = sweep.to.z = lattice_offset(lowest + (box ? d : radius));
	sweep_and_wake(ground, &sweep);
	assert_true(!large || ground->window_count > 1);
}

static const struct trip trips[] = {
	{DEFORM_SLIPPAGE, 64, 3, 0.0625, 4, NULL, true, 30}, {DEFORM_SUMNER, 64, 3, 0.0625, 4, NULL, false, 30},
	{DEFORM_SLIPPAGE, 32, 4, 0.125, 1, slope, false, 30}, {DEFORM_SUMNER, 128, 1, 0.125, 1, slope, true, 30},
	{DEFORM_SLIPPAGE, 160, 2, 0.125, 8, NULL, true, 16}, {DEFORM_SUMNER, 160, 2, 0.125, 2, slope, false, 16},
};

static void make(const struct trip *trip, size_t seed)
{
	struct ground ground;
	bool wide = trip->cells * trip->tiles > 300;
	test_seed = (uint32_t)seed;
	begin(&ground, trip);
	double at[2] = {(double)ground.posts / 2, (double)ground.posts / 2};
	for (int n = 0; n < trip->samples; n++) {
		bool above = n > 0 && any_word() % 3 != 0;
		late_misses = any_word() % 4 == 0;
		any_station(&ground, above, wide && n == 9, at);
		assert_all_are_told(&ground, 2 * n);
		if (any_word() % 3 == 0)
			continue;
		pass_interval(&ground);
		assert_all_are_told(&ground, 2 * n + 1);
	}
	for (int n = 0; n < 6; n++)
		pass_interval(&ground);
	gpu_finish(test_gpu);
	size_t changed = assert_all_are_told(&ground, -1);
	/* And not all there is. */
	assert_true(changed > 400 && told(&ground) < (size_t)(ground.posts * ground.posts));
	ground_finish(&ground);
}

/* The guess is taken back when the flags are here: a window's corner is touched until then. */
static void what_comes_takes_back_the_guess(void **state)
{
	(void)state;
	need_gpu();
	for (int above = 0; above < 2; above++) {
		struct ground ground;
		begin(&ground, &(struct trip){DEFORM_SLIPPAGE, 64, 3, 0.0625, 4, NULL, false, 0});
		double d = ground.params.spacing;
		const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 24 * d};
		struct deform_contact sweep = {.shape = &ball, .above = above};
		assert_ok(deform_touch(ground.deform, (struct post_rect){96, 96, 97, 97}));
		sweep.from = sweep.to = ground_pose(&ground, 96, 96, (above ? 24.1 : 23.9) * d);
		late_by = LATE_UNTIL_WAITED;
		sweep_and_wake(&ground, &sweep);
		struct post_rect write = ground.windows[0].write;
		assert_true(is_touched(&ground, write.x0, write.y0) && is_touched(&ground, write.x1 - 1, write.y1 - 1));
		assert_true(!is_touched(&ground, write.x0 - 1, write.y0) && !is_touched(&ground, write.x1, write.y1 - 1));
		/* Soil may have slid on meanwhile, a post an iteration. */
		pass_interval(&ground);
		assert_true(is_touched(&ground, write.x0, write.y0) && is_touched(&ground, write.x0 - 4, write.y0 - 4));
		assert_true(is_touched(&ground, write.x1 + 3, write.y1 + 3) && !is_touched(&ground, write.x1 + 4, write.y1 - 1));
		assert_true(!is_touched(&ground, write.x0 - 5, write.y0) && !is_touched(&ground, write.x0, write.y0 - 5));
		gpu_finish(test_gpu);
		assert_true(!is_touched(&ground, write.x0, write.y0) && !is_touched(&ground, write.x1 - 1, write.y1 - 1));
		assert_true(is_touched(&ground, 96, 96) && is_touched(&ground, 97, 97) == !above);
		late_by = 0;
		ground_finish(&ground);
	}
}

/* What hangs over nothing that was touched leaves nothing, and is not thought to; over the last post of its window, it is. */
static void only_over_touched_ground_is_guessed(void **state)
{
	(void)state;
	need_gpu();
	struct ground ground;
	begin(&ground, &(struct trip){DEFORM_SUMNER, 64, 3, 0.0625, 4, NULL, false, 0});
	double d = ground.params.spacing;
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 12 * d};
	struct deform_contact sweep = {.shape = &ball, .above = true};
	sweep.from = sweep.to = ground_pose(&ground, 96, 96, 12.1 * d);
	late_by = LATE_UNTIL_WAITED;
	for (int over = 0; over < 2; over++) {
		sweep_and_wake(&ground, &sweep);
		struct post_rect write = ground.windows[0].write;
		assert_int_equal(is_touched(&ground, write.x0, write.y0), over);
		assert_int_equal(told(&ground), over ? (write.x1 - write.x0) * (write.y1 - write.y0) : 0);
		assert_ok(deform_touch(ground.deform, (struct post_rect){write.x1 - 1, write.y1 - 1, write.x1, write.y1}));
	}
	late_by = 0;
	ground_finish(&ground);
}

/* Over what is itself only thought to be touched, too. */
static void a_guess_leads_to_a_guess(void **state)
{
	(void)state;
	need_gpu();
	struct ground ground;
	begin(&ground, &(struct trip){DEFORM_SLIPPAGE, 64, 3, 0.0625, 4, NULL, false, 0});
	double d = ground.params.spacing;
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 12 * d};
	struct deform_contact press = {.shape = &ball}, over = {.shape = &ball, .above = true};
	press.from = press.to = ground_pose(&ground, 80, 80, 11 * d);
	over.from = over.to = ground_pose(&ground, 100, 100, 12.1 * d);
	late_by = LATE_UNTIL_WAITED;
	sweep_and_wake(&ground, &press);
	sweep_and_wake(&ground, &over);
	struct post_rect write = ground.windows[0].write;
	assert_true(is_touched(&ground, write.x1 - 1, write.y1 - 1));
	gpu_finish(test_gpu); /* none was sent for */
	assert_true(is_touched(&ground, write.x1 - 1, write.y1 - 1));
	pass_interval(&ground);
	gpu_finish(test_gpu);
	assert_true(is_touched(&ground, 80, 80) && !is_touched(&ground, write.x1 - 1, write.y1 - 1));
	late_by = 0;
	ground_finish(&ground);
}

/* The GPU may come to a visit between two looks: its flags are here, those of the sweeps before it were not yet. */
static void sweeps_nobody_looked_at_are_touched(void **state)
{
	(void)state;
	need_gpu();
	struct ground ground;
	begin(&ground, &(struct trip){DEFORM_SLIPPAGE, 64, 3, 0.0625, 4, NULL, false, 0});
	double d = ground.params.spacing;
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 12 * d};
	struct deform_contact sweep = {.shape = &ball};
	sweep.from = sweep.to = ground_pose(&ground, 80, 80, 11 * d);
	late_by = 1;
	sweep_and_wake(&ground, &sweep);
	pass_interval(&ground);
	late_misses = 1;
	assert_all_are_told(&ground, 0);
	assert_true(is_touched(&ground, ground.windows[0].write.x0, 80) && late_misses == 0);
	late_by = 0;
	ground_finish(&ground);
}

static void all_that_changed_is_told_whenever_flags_come(void **state)
{
	static const int64_t lates[] = {0, 1, 2, LATE_UNTIL_WAITED};
	(void)state;
	need_gpu();
	for (size_t t = 0; t < sizeof trips / sizeof *trips; t++)
		for (size_t k = 0; k < sizeof lates / sizeof *lates; k++) {
			late_by = lates[k];
			make(&trips[t], 3 * t / 2 + 1);
			late_by = 0;
		}
}

TEST_PROGRAM(touched_late)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_comes_takes_back_the_guess),
		cmocka_unit_test(only_over_touched_ground_is_guessed),
		cmocka_unit_test(a_guess_leads_to_a_guess),
		cmocka_unit_test(sweeps_nobody_looked_at_are_touched),
		cmocka_unit_test(all_that_changed_is_told_whenever_flags_come),
	};
	return cmocka_run_group_tests_name("deform/touched_late", tests, open_gpu, close_gpu);
}
