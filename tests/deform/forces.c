/* Forces on their way: each sweep's own, in order, however many are asked for before one is taken. */
#include "ground.h"

static const struct deform_shape plate = {.kind = DEFORM_BOX, .size = {0.4, 0.4, 0.5}};

static struct deform_contact press(const struct ground *ground, int i)
{
	struct deform_pose pose = ground_pose(ground, 20 + i % 30, 20 + i / 30 % 30, 0.25 - 0.001 * (1 + i % 7));
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

/* A plate that stands aslant to nothing: its moments are those of its pressure about its centre. */
static void moments_are_about_the_centre(void **state)
{
	struct ground ground;
	(void)state;
	need_gpu();
	open_ground(&ground);
	struct deform_contact sweep = press(&ground, 3);
	/* 0.3 of a post off: the posts under it lie to one side. */
	sweep.from.x = sweep.to.x += lattice_offset(0.3 * 0.0625);
	struct deform_forces forces = ground_forces(&ground, &sweep);
	double x = 0, y = 0;
	int count = 0;
	uint8_t *contacts = ground_contacts(&ground);
	for (int64_t i = 0; i < ground.posts * ground.posts; i++)
		if (contacts[i] != 0) {
			x += (double)ground_from(&ground, i % ground.posts, sweep.to.x);
			y += (double)ground_from(&ground, i / ground.posts, sweep.to.y);
			count++;
		}
	mem_free(contacts);
	assert_true(count > 20 && fabs(forces.area - count * 0.0625 * 0.0625) < 1e-12);
	assert_true(fabs(forces.moment[0] - forces.force[2] * y / count) < 1e-4 * forces.force[2] &&
		    fabs(forces.moment[1] + forces.force[2] * x / count) < 1e-4 * forces.force[2]);
	assert_true(fabs(x / count) > 0.01 && forces.moment[2] == 0);
	ground_finish(&ground);
}

/* A large one takes several windows: it is told once, of all of them. */
static void windows_of_one_sweep_add_up(void **state)
{
	const struct deform_shape large = {.kind = DEFORM_BOX, .size = {16, 12, 1}};
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 512, .tiles = 1, .first = 1, .spacing = 0.03125, .model = DEFORM_SCM});
	struct deform_pose pose = ground_pose(&ground, 256.3, 256.3, 0.5 - 0.01);
	struct deform_contact sweep = {.shape = &large, .from = pose, .to = pose};
	struct deform_soil soil = ground.deform->params.soils[0];
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

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_sweep_that_asks_is_told_once_and_in_order),
		cmocka_unit_test(who_does_not_ask_is_not_told),
		cmocka_unit_test(moments_are_about_the_centre),
		cmocka_unit_test(windows_of_one_sweep_add_up),
	};
	return cmocka_run_group_tests_name("deform/forces", tests, open_gpu, close_gpu);
}
