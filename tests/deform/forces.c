/* Forces on their way: each sweep's own, in order, however many are asked for before one is taken. */
#include "ground.h"
#include "../support/program.h"

static const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.4, 0.4, 0.5}};

static struct deform_contact press(const struct ground *ground, int i)
{
	struct soil_pose pose = ground_pose(ground, 20 + i % 30, 20 + i / 30 % 30, 0.25 - 0.001 * (1 + i % 7));
	return (struct deform_contact){.shape = &plate, .from = pose, .to = pose, .tag = 100 + (uint64_t)i};
}

static void open_ground(struct ground *ground)
{
	ground_init(ground, &(struct ground_params){.cells = 64, .tiles = 1, .first = 2, .spacing = 0.0625, .model = DEFORM_SCM});
}

/* More than there are records, and batches of any size. */
static void every_sweep_that_asks_is_told_once_and_in_order(void **state)
{
	struct ground ground;
	double expected[700];
	(void)state;
	need_gpu();
	for (int round = 0; round < 3; round++) {
		int next = 0;
		bool taken = true;
		struct deform_forces forces;
		open_ground(&ground);
		for (int i = 0; i < 700; i++) {
			struct deform_contact sweep = press(&ground, i);
			ground_sweep(&ground, &sweep);
			if (round == 1 && i % 7 == 0)
				assert_ok(deform_forces_begin(ground.deform));
			if (round == 2 && any_word() % 5 == 0) {
				assert_ok(deform_forces_begin(ground.deform));
				assert_ok(deform_forces_take(ground.deform, any_word() % 2, &forces, &taken));
				assert_true(!taken || (forces.tag == 100 + (uint64_t)next && forces.force[2] == expected[next]));
				next += taken;
			}
		}
		assert_ok(deform_forces_begin(ground.deform));
		for (taken = true; taken;) {
			assert_ok(deform_forces_take(ground.deform, true, &forces, &taken));
			if (!taken)
				break;
			assert_int_equal(forces.tag, 100 + next);
			assert_true(forces.force[2] > 0);
			if (round == 0)
				expected[next] = forces.force[2];
			assert_true(forces.force[2] == expected[next]);
			next++;
		}
		assert_int_equal(next, 700);
		ground_finish(&ground);
	}
}

static void who_does_not_ask_is_not_told(void **state)
{
	struct ground ground;
	struct deform_forces forces;
	bool taken = true;
	(void)state;
	need_gpu();
	open_ground(&ground);
	struct deform_contact sweep = press(&ground, 3);
	sweep.tag = 0;
	ground_sweep(&ground, &sweep);
	assert_ok(deform_forces_begin(ground.deform));
	assert_ok(deform_forces_take(ground.deform, true, &forces, &taken));
	assert_false(taken);
	assert_null(ground.deform->forces);
	ground_finish(&ground);
}

/* Holes to the west of a plate's middle. */
static int32_t eastern(int64_t x, int64_t y)
{
	(void)y;
	return x < 24 ? BASE_NODATA : 0;
}

static void moments_are_about_the_centre(void **state)
{
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 1, .first = 2, .spacing = 0.0625, .model = DEFORM_SCM, .height = eastern});
	struct soil_pose pose = ground_pose(&ground, 23.8, 23.8, 0.25 - 0.004);
	struct deform_contact sweep = {.shape = &plate, .from = pose, .to = pose};
	struct deform_forces forces = ground_forces(&ground, &sweep);
	/* The ground is there from half a post before post 24 to the plate's eastern side. */
	double west = -0.3 * 0.0625, area = (0.2 - west) * 0.4;
	assert_true(fabs(forces.area / area - 1) < 1e-4 && forces.force[2] > 0);
	assert_true(fabs(forces.moment[1] / forces.force[2] + (0.2 + west) / 2) < 1e-4 && fabs(forces.moment[0]) < 1e-5 * forces.force[2]);
	assert_true(forces.moment[2] == 0);
	/* The whole plate on flat ground, wherever it lies between posts. */
	ground_finish(&ground);
	open_ground(&ground);
	for (int i = 0; i < 5; i++) {
		ground_reset(&ground);
		sweep = press(&ground, 3);
		sweep.from.x = sweep.to.x += lattice_offset(0.2 * i * 0.0625);
		sweep.from.y = sweep.to.y += lattice_offset(0.13 * i * 0.0625);
		forces = ground_forces(&ground, &sweep);
		assert_true(fabs(forces.area / 0.16 - 1) < 1e-4 && forces.moment[2] == 0);
		assert_true(fabs(forces.moment[0]) < 1e-5 * forces.force[2] && fabs(forces.moment[1]) < 1e-5 * forces.force[2]);
		double pressure = reference_bekker(&ground.deform->params.soils[0], 0.4, forces.sinkage);
		assert_true(fabs(forces.force[2] / (0.16 * pressure) - 1) < 1e-5);
	}
	ground_finish(&ground);
}

/* A large one takes several windows: it is told once, of all of them. */
static void windows_of_one_sweep_add_up(void **state)
{
	const struct soil_shape large = {.kind = SOIL_BOX, .size = {16, 12, 1}};
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 512, .tiles = 1, .first = 1, .spacing = 0.03125, .model = DEFORM_SCM});
	struct soil_pose pose = ground_pose(&ground, 256.3, 256.3, 0.5 - 0.01);
	struct deform_contact sweep = {.shape = &large, .from = pose, .to = pose};
	struct soil_numbers soil = ground.deform->params.soils[0];
	struct deform_forces forces = ground_forces(&ground, &sweep);
	assert_true(ground.window_count > 1);
	assert_true(fabs(forces.area - 16 * 12) < 0.6);
	double pressure = (soil.bekker_kc / 12 + soil.bekker_kphi) * pow(forces.sinkage, soil.bekker_n);
	assert_true(fabs(forces.force[2] / forces.area / pressure - 1) < 1e-5);
	sweep.load = 1000;
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count;
	assert_int_equal(deform_windows(ground.deform, &sweep, windows, &count), STATUS_INPUT);
	ground_finish(&ground);
}

TEST_PROGRAM(forces)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_sweep_that_asks_is_told_once_and_in_order),
		cmocka_unit_test(who_does_not_ask_is_not_told),
		cmocka_unit_test(moments_are_about_the_centre),
		cmocka_unit_test(windows_of_one_sweep_add_up),
	};
	return cmocka_run_group_tests_name("deform/forces", tests, open_gpu, close_gpu);
}
