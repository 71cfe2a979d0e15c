/* A wheel with grousers: the lower of the smooth wheel and its bars, turned as the pose says. */
#include "ground.h"
#include "../support/program.h"

#define BELOW 250 /* how deep in the ground the wheels run */

static const struct soil_shape lugged = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4, .grousers = 12, .grouser_height = 0.05, .grouser_thickness = 0.06};

/* Lowest and highest of the reference around a post, and how many of eight places are under the wheel. */
static int around(const struct deform_contact *sweep, long double x, long double y, long double radius, long double *low,
		  long double *high)
{
	int covered = 0;
	*low = 1e30L;
	*high = -1e30L;
	for (int i = 0; i < 8; i++) {
		long double z, angle = (long double)i * 0.78539816L;
		if (!reference_underside(sweep, x + radius * cosl(angle), y + radius * sinl(angle), &z))
			continue;
		*low = fminl(*low, z);
		*high = fmaxl(*high, z);
		covered++;
	}
	return covered;
}

/* Within `near`, or within what lies no farther than `beside` metres from the post. Returns the posts compared. */
static int compare(struct ground *ground, const struct deform_contact *sweep, long double near, long double beside)
{
	int posts = 0;
	int32_t *offset = ground_swept(ground, sweep);
	for (int64_t i = 0; i < ground->posts * ground->posts; i++) {
		if (!ground_written(ground, i)) {
			assert_int_equal(offset[i], 0);
			continue;
		}
		long double x = ground_from(ground, i % ground->posts, sweep->from.x), y = ground_from(ground, i / ground->posts, sweep->from.y);
		long double z = 0, low, high, pressed = ldexpl((int64_t)offset[i] - sweep->from.z, -OFFSET_BITS);
		bool covered = reference_underside(sweep, x, y, &z);
		posts += covered;
		if (covered == (offset[i] != 0) && (!covered || fabsl(pressed - z) <= near))
			continue;
		int covers = around(sweep, x, y, beside, &low, &high);
		if (covered != (offset[i] != 0) ? covers > 0 && covers < 8 : pressed > low - near && (covers < 8 || pressed < high + near))
			continue;
		fail_msg("post %lld, %lld: %.1Lf um from the reference, %d covered, %d pressed", (long long)(i % ground->posts),
			 (long long)(i / ground->posts), (pressed - z) * 1e6L, covered, offset[i] != 0);
	}
	mem_free(offset);
	return posts;
}

static void a_standing_wheel_is_that_of_the_reference(void **state)
{
	static const double spacings[] = {0.25, 0.0625, 0.0278};
	int posts = 0;
	(void)state;
	need_gpu();
	for (int s = 0; s < 3; s++) {
		struct ground ground;
		ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .first = 3, .spacing = spacings[s]});
		for (int i = 0; i < 24; i++) {
			struct soil_shape shape = {.kind = SOIL_WHEEL, .radius = 0.4 + 0.1 * any_share(), .width = 0.3 + 0.2 * any_share(),
						   .grousers = 1 + i % 24, .grouser_height = 0.02 + 0.1 * fabs(any_share()), .grouser_thickness = 0.01 + 0.04 * fabs(any_share())};
			assert_ok(soil_shape_check(&shape, spacings[s]));
			struct soil_pose pose = ground_pose(&ground, 32 + any_share(), 32 + any_share(), -BELOW);
			pose.yaw = i % 4 == 0 ? M_PI / 2 * i / 4 : any_share() * 4;
			pose.turn = i % 5 == 0 ? 0 : any_share() * 20;
			pose.roll = i % 3 == 0 ? 0 : i % 3 == 1 ? any_share() * 0.4 : any_share() * 4;
			struct deform_contact sweep = {.shape = &shape, .from = pose, .to = pose};
			posts += compare(&ground, &sweep, 4e-6L, 2e-5L * spacings[s]);
		}
		ground_finish(&ground);
	}
	assert_true(posts > 8000);
}

/* From slipping wholly to braked wholly; a wheel that rolls leaves its lugs' own prints. */
static void a_rolling_wheel_is_nearly_that_of_the_reference(void **state)
{
	static const double slips[] = {0, 0.2, 0.8, 1, -10};
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .spacing = 0.05});
	for (int i = 0; i < 15; i++) {
		struct deform_contact sweep = {.shape = &lugged, .from = ground_pose(&ground, 32 + any_share(), 32 + any_share(), -BELOW)};
		double heading = i < 5 ? 0 : any_share() * 4, way = slips[i % 5] == 1 ? 0 : 0.05;
		sweep.to = sweep.from;
		sweep.to.x += lattice_offset(way * cos(heading));
		sweep.to.y += lattice_offset(way * sin(heading));
		sweep.to.z -= lattice_offset(0.004);
		sweep.from.yaw = sweep.to.yaw = heading;
		sweep.from.roll = sweep.to.roll = i < 10 ? 0 : any_share() * 0.5; /* camber */
		sweep.from.turn = any_share() * 9;
		sweep.turned = slips[i % 5] == 1 ? 0.3 : 0.05 / 0.5 / (1 - slips[i % 5]);
		sweep.to.turn = remainder(sweep.from.turn + sweep.turned, 2 * M_PI);
		/* A bar's half diagonal times half the turn of a step; and what the arc bulges from its chord. */
		double step = sweep.turned / ceil(sweep.turned / 0.2);
		double off = hypot(0.03, 0.05) * step / 2 + 0.5 * step * step / 8;
		assert_true(compare(&ground, &sweep, off + 1e-5, off + 0.05 / 100) > 80);
	}
	ground_finish(&ground);
}

static void turned_by_one_lug_it_is_the_same(void **state)
{
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .spacing = 0.0625});
	for (int i = 0; i < 30; i++) {
		struct soil_shape shape = lugged;
		shape.grousers = 1 + i;
		shape.grouser_thickness = 0.03;
		struct deform_contact sweep = {.shape = &shape, .from = ground_pose(&ground, 31.3, 31.8, -1), .to = ground_pose(&ground, 32.1, 32.2, -1)};
		sweep.to.yaw = 0.3 * i;
		sweep.turned = 0.1;
		sweep.to.turn = 0.37 * i - 4;
		int32_t *a = ground_swept(&ground, &sweep);
		double by = 2 * M_PI / shape.grousers * (i % 3 == 0 ? 1 : i % 3 == 1 ? -7 : 1000);
		sweep.to.turn += by;
		int32_t *b = ground_swept(&ground, &sweep);
		assert_memory_equal(a, b, (size_t)(ground.posts * ground.posts) * sizeof *a);
		sweep.from = sweep.to;
		mem_free(a);
		a = ground_swept(&ground, &sweep);
		sweep.to.turn += by;
		mem_free(b);
		b = ground_swept(&ground, &sweep);
		assert_memory_equal(a, b, (size_t)(ground.posts * ground.posts) * sizeof *a);
		mem_free(a);
		mem_free(b);
	}
	ground_finish(&ground);
}

static void without_lugs_it_is_the_smooth_wheel(void **state)
{
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .spacing = 0.0625, .model = DEFORM_BOX_FILTER, .radius = 1});
	struct soil_shape smooth = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4}, none = lugged;
	none.grousers = 0;
	struct deform_contact sweep = {.shape = &smooth, .from = ground_pose(&ground, 31.3, 31.8, 0.4), .to = ground_pose(&ground, 32.1, 32.2, 0.4)};
	sweep.to.turn = 1;
	int32_t *a = ground_swept(&ground, &sweep);
	sweep.shape = &none;
	int32_t *b = ground_swept(&ground, &sweep);
	assert_memory_equal(a, b, (size_t)(ground.posts * ground.posts) * sizeof *a);
	mem_free(b);
	sweep.shape = &lugged;
	sweep.turned = 0.1;
	assert_rests_where_it_ends(&ground, &sweep);
	mem_free(a);
	ground_finish(&ground);
}

/* A smooth track with a print in it every lug: rolled without slip, as far apart as the lugs on the rim. */
static void a_track_shows_every_lug(void **state)
{
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 256, .tiles = 1, .spacing = 0.015625});
	struct soil_shape shape = lugged;
	struct soil_pose pose = ground_pose(&ground, 60, 128, 0.5);
	for (int i = 0; i < 140; i++) {
		struct soil_pose next = pose;
		next.x += lattice_offset(0.015625);
		struct deform_contact sweep = {.shape = &shape, .from = pose, .to = next, .turned = 0.015625 / 0.55}; /* on its lugs */
		next.turn = sweep.to.turn = remainder(pose.turn + sweep.turned, 2 * M_PI);
		ground_sweep(&ground, &sweep);
		pose = next;
	}
	ground_read(&ground);
	int prints = 0;
	for (int64_t x = 61; x < 200; x++) {
		int32_t at = ground.offset[128 * ground.posts + x], before = ground.offset[128 * ground.posts + x - 1];
		prints += at < lattice_offset(-0.03) && before >= lattice_offset(-0.03);
	}
	/* 139 posts of 1/64 m, a lug every 2 pi 0.55 / 12 m: 7.5 of them. */
	assert_in_range(prints, 7, 8);
	ground_finish(&ground);
}

static void lugs_that_cannot_be_are_refused(void **state)
{
	struct soil_shape shape = lugged;
	(void)state;
	assert_int_equal(soil_shape_check(&shape, 0.1), STATUS_OK);
	assert_true(fabs(soil_shape_reach(&shape, 1, 0) - 0.55) < 1e-12);
	assert_true(soil_shape_bound(&shape) >= hypot(0.55, 0.2));
	shape.grouser_height = 0;
	assert_int_equal(soil_shape_check(&shape, 0.1), STATUS_INPUT);
	shape = lugged;
	shape.grouser_thickness = 0.3;
	assert_int_equal(soil_shape_check(&shape, 0.1), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "do not fit"));
	shape = lugged;
	shape.grousers = 361;
	assert_int_equal(soil_shape_check(&shape, 0.1), STATUS_INPUT);
	shape.grousers = -1;
	assert_int_equal(soil_shape_check(&shape, 0.1), STATUS_INPUT);
	shape = lugged;
	shape.grouser_height = 300;
	assert_int_equal(soil_shape_check(&shape, 0.1), STATUS_INPUT);
}

TEST_PROGRAM(grousers)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_standing_wheel_is_that_of_the_reference),
		cmocka_unit_test(a_rolling_wheel_is_nearly_that_of_the_reference),
		cmocka_unit_test(turned_by_one_lug_it_is_the_same),
		cmocka_unit_test(without_lugs_it_is_the_smooth_wheel),
		cmocka_unit_test(a_track_shows_every_lug),
		cmocka_unit_test(lugs_that_cannot_be_are_refused),
	};
	return cmocka_run_group_tests_name("deform/grousers", tests, open_gpu, close_gpu);
}
