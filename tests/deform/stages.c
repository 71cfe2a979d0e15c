/* What the stages do at each post: press, refuse, touch, smooth, dirty; and what they leave alone. */
#include "ground.h"
#include "../support/program.h"

#define NEAR 16 /* a bit of contacts: the object was less than two spacings above the post */

static int32_t rough(int64_t x, int64_t y)
{
	uint32_t h = (uint32_t)x * 2654435761u ^ (uint32_t)y * 2246822519u;
	h ^= h >> 15;
	h *= 2654435761u;
	return (int32_t)(h >> 17); /* 0 .. 0.125 m */
}

static int32_t holed(int64_t x, int64_t y)
{
	return (x * 5 + y * 3) % 11 == 0 ? BASE_NODATA : rough(x, y);
}

static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4};
static const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.7};

static struct deform_contact roll(const struct ground *ground, const struct soil_shape *shape, double x, double y,
				double depth)
{
	double z = shape->radius - depth;
	struct deform_contact sweep = {.shape = shape, .from = ground_pose(ground, x, y, z), .to = ground_pose(ground, x + 1.7, y + 0.9, z)};
	sweep.to.yaw = atan2(0.9, 1.7);
	return sweep;
}

static int32_t *copy_of(const struct ground *ground)
{
	int32_t *copy = ground_room(ground->posts * ground->posts, sizeof *copy);
	memcpy(copy, ground->offset, (size_t)(ground->posts * ground->posts) * sizeof *copy);
	return copy;
}

static void only_ground_above_the_object_is_pressed(void **state)
{
	struct ground ground;
	int pressed = 0, spared = 0;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .first = 2, .spacing = 0.0625, .height = holed});
	struct deform_contact sweep = roll(&ground, &wheel, 31.3, 30.8, 0.05);
	ground_sweep(&ground, &sweep);
	ground_read(&ground);
	for (int64_t i = 0; i < ground.posts * ground.posts; i++) {
		long double z, x = ground_from(&ground, i % ground.posts, sweep.from.x);
		long double y = ground_from(&ground, i / ground.posts, sweep.from.y);
		long double under = 0, before = ldexpl(ground.base[i], 2);
		bool covered = reference_underside(&sweep, x, y, &z);
		if (covered)
			under = ldexpl(z, OFFSET_BITS) + sweep.from.z;
		if (ground.base[i] == BASE_NODATA || !covered || under > before + 4) {
			assert_int_equal(ground.offset[i], 0);
			spared += covered;
		} else if (under < before - 4) {
			assert_true(fabsl(before + ground.offset[i] - under) < 4);
			pressed++;
		}
	}
	assert_true(pressed > 20 && spared > 20);
	ground_finish(&ground);
}

static void contacts_tell_what_was_pressed_and_what_is_held(void **state)
{
	struct ground ground;
	int swept = 0, held = 0, left = 0;
	(void)state;
	need_gpu();
	for (int round = 0; round < 6; round++) {
		ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .first = 2, .spacing = 0.125,
							     .height = holed, .model = DEFORM_NONE, .dirt = true});
		struct deform_contact sweep = roll(&ground, round % 2 ? &ball : &wheel, 30 + any_share(), 29 + any_share(), 0.05);
		struct deform_contact end = {.shape = sweep.shape, .from = sweep.to, .to = sweep.to};
		ground_sweep(&ground, &sweep);
		ground_read(&ground);
		uint8_t *contacts = ground_contacts(&ground);
		for (int64_t i = 0; i < ground.posts * ground.posts; i++) {
			long double z, x = ground_from(&ground, i % ground.posts, sweep.from.x);
			long double y = ground_from(&ground, i / ground.posts, sweep.from.y);
			bool none = ground.base[i] == BASE_NODATA;
			bool covered = reference_underside(&sweep, x, y, &z);
			long double above = ldexpl(z, OFFSET_BITS) + sweep.from.z - 4 * (long double)ground.base[i];
			if (none || !covered || above > 4)
				assert_int_equal(contacts[i] & REFERENCE_SWEPT, 0);
			else if (above < -4)
				assert_int_equal(contacts[i] & REFERENCE_SWEPT, REFERENCE_SWEPT);
			above = covered ? above - ldexpl(0.25L, OFFSET_BITS) : 1e30L; /* two spacings */
			if (none || !covered || above > 4)
				assert_int_equal(contacts[i] & NEAR, 0);
			else if (above < -4)
				assert_int_equal(contacts[i] & NEAR, NEAR);
			x = ground_from(&ground, i % ground.posts, end.from.x);
			y = ground_from(&ground, i / ground.posts, end.from.y);
			covered = reference_underside(&end, x, y, &z);
			above = ldexpl(z, OFFSET_BITS) + end.from.z - 4 * (long double)ground.base[i] - ground.offset[i];
			if (none || !covered || above > 8)
				assert_int_equal(contacts[i] & REFERENCE_HELD, 0);
			else if (above < 2)
				assert_int_equal(contacts[i] & REFERENCE_HELD, REFERENCE_HELD);
			swept += contacts[i] & 1;
			held += (contacts[i] & REFERENCE_HELD) != 0;
			left += (contacts[i] & (REFERENCE_SWEPT | REFERENCE_HELD)) == REFERENCE_SWEPT;
		}
		mem_free(contacts);
		ground_finish(&ground);
	}
	assert_true(swept > 100 && held > 50 && left > 50);
}

static void an_object_at_rest_changes_nothing_more(void **state)
{
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .first = 2, .spacing = 0.125, .height = rough,
						     .model = DEFORM_BOX_FILTER, .radius = 2, .repetitions = 3});
	struct deform_contact sweep = roll(&ground, &wheel, 31.3, 30.8, 0.1);
	struct deform_contact rest = {.shape = &wheel, .from = sweep.to, .to = sweep.to};
	ground_sweep(&ground, &sweep);
	ground_sweep(&ground, &rest); /* presses again what smoothing raised within its reach */
	ground_read(&ground);
	int32_t *before = copy_of(&ground);
	for (int i = 0; i < 3; i++)
		ground_sweep(&ground, &rest);
	ground_read(&ground);
	assert_memory_equal(ground.offset, before, (size_t)(ground.posts * ground.posts) * sizeof *before);
	mem_free(before);
	ground_finish(&ground);
}

static void what_an_object_rests_on_is_not_smoothed(void **state)
{
	struct ground pressed, smoothed;
	int held = 0;
	(void)state;
	need_gpu();
	struct ground_params params = {.cells = 32, .tiles = 2, .first = 2, .spacing = 0.0625};
	ground_init(&pressed, &params);
	params.model = DEFORM_BOX_FILTER;
	ground_init(&smoothed, &params);
	struct deform_contact sweep = roll(&smoothed, &ball, 31.3, 30.8, 0.2);
	ground_sweep(&pressed, &sweep);
	ground_sweep(&smoothed, &sweep);
	ground_read(&pressed);
	ground_read(&smoothed);
	struct deform_contact end = {.shape = &ball, .from = sweep.to, .to = sweep.to};
	for (int64_t i = 0; i < pressed.posts * pressed.posts; i++) {
		long double z, x = ground_from(&pressed, i % pressed.posts, end.from.x);
		long double y = ground_from(&pressed, i / pressed.posts, end.from.y);
		if (!reference_underside(&end, x, y, &z) || ldexpl(z, OFFSET_BITS) + end.from.z > pressed.offset[i] + 1.5L)
			continue;
		assert_int_equal(smoothed.offset[i], pressed.offset[i]);
		held++;
	}
	assert_true(held > 40);
	ground_finish(&pressed);
	ground_finish(&smoothed);
}

static void depths_beyond_the_range_are_refused_and_counted(void **state)
{
	struct ground ground;
	struct deform_tally tally;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .first = 2, .spacing = 0.25});
	struct soil_shape box = {.kind = SOIL_BOX, .size = {1.9, 0.9, 1}};
	struct deform_contact sweep = {.shape = &box, .from = ground_pose(&ground, 32.5, 32.5, -1023.4), .to = ground_pose(&ground, 32.5, 32.5, -1023.4)};
	ground_sweep(&ground, &sweep);
	ground_read(&ground);
	assert_ok(deform_tally(ground.deform, &tally));
	assert_int_equal(tally.refused, 0);
	assert_int_equal(ground.offset[32 * 65 + 32], lattice_offset(-1023.9));
	ground_reset(&ground);
	for (int i = 1; i <= 3; i++) { /* 8 x 4 posts each time */
		sweep.from.z = sweep.to.z = lattice_offset(-1024 - i * 1000);
		ground_sweep(&ground, &sweep);
		assert_ok(deform_tally(ground.deform, &tally));
		assert_int_equal(tally.refused, i * 32);
	}
	ground_read(&ground);
	for (int64_t i = 0; i < ground.posts * ground.posts; i++)
		assert_int_equal(ground.offset[i], 0);
	ground_finish(&ground);
}

static void dirt_grows_with_depth_where_the_sweep_touches(void **state)
{
	struct ground ground;
	int dirty = 0;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .first = 2, .spacing = 0.125, .height = holed,
						     .model = DEFORM_BOX_FILTER, .dirt = true});
	uint8_t *expected = ground_room(ground.posts * ground.posts, 1);
	for (int round = 0; round < 3; round++) {
		struct deform_contact sweep = roll(&ground, &wheel, 28 + 2 * round, 30, 0.15 - 0.04 * round);
		ground_sweep(&ground, &sweep);
		ground_read(&ground);
		uint8_t *contacts = ground_contacts(&ground);
		for (int64_t i = 0; i < ground.posts * ground.posts; i++) {
			int depth = ground.offset[i] < 0 ? -ground.offset[i] : 0, dirt = 96 + depth / 1024;
			dirt = dirt < 255 ? dirt : 255;
			if ((contacts[i] & REFERENCE_SWEPT) != 0 && dirt > expected[i])
				expected[i] = (uint8_t)dirt;
			dirty += expected[i] > 96;
		}
		assert_memory_equal(ground.dirt, expected, (size_t)(ground.posts * ground.posts));
		mem_free(contacts);
	}
	assert_true(dirty > 40);
	mem_free(expected);
	ground_finish(&ground);
}

static void poses_beyond_limits_are_refused(void **state)
{
	struct ground ground;
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 1, .spacing = 0.25});
	struct deform_contact sweep = roll(&ground, &wheel, 16, 16, 0.1);
	sweep.to.roll = 0.1; /* camber */
	assert_ok(deform_windows(ground.deform, &sweep, windows, &count));
	assert_int_equal(count, 1);
	sweep = roll(&ground, &wheel, -16, 16, 0.1);
	assert_ok(deform_windows(ground.deform, &sweep, windows, &count));
	assert_int_equal(count, 0);
	ground_finish(&ground);
}

TEST_PROGRAM(stages)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(only_ground_above_the_object_is_pressed),
		cmocka_unit_test(contacts_tell_what_was_pressed_and_what_is_held),
		cmocka_unit_test(an_object_at_rest_changes_nothing_more),
		cmocka_unit_test(what_an_object_rests_on_is_not_smoothed),
		cmocka_unit_test(depths_beyond_the_range_are_refused_and_counted),
		cmocka_unit_test(dirt_grows_with_depth_where_the_sweep_touches),
		cmocka_unit_test(poses_beyond_limits_are_refused),
	};
	return cmocka_run_group_tests_name("deform/stages", tests, open_gpu, close_gpu);
}
