/* The model `sumner` over whole sweeps: nothing is lost, whatever the ground, the object and the windows. */
#include "conserve.h"
#include "../support/program.h"

static void every_quantum_stays(void **state)
{
	(void)state;
	need_gpu();
	conserve_every_quantum(DEFORM_SUMNER);
}

/* `compression` is the share that is lost, to a 2^31st. */
static void what_is_compacted_is_its_share(void **state)
{
	(void)state;
	need_gpu();
	for (int i = 0; i < 3; i++) {
		struct ground ground;
		struct deform_soil soil;
		struct deform_tally tally;
		assert_ok(deform_soil_named("snow", &soil)); /* stands however steep */
		soil.compression = 0.5 * i;
		ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .spacing = 0.125, .height = conserve_rough,
							     .model = DEFORM_SUMNER, .soils = &soil, .soil_count = 1});
		struct deform_shape ball = {.kind = DEFORM_SPHERE, .radius = 1};
		struct deform_contact sweep = {.shape = &ball, .from = ground_pose(&ground, 31, 32, 0.8), .to = ground_pose(&ground, 32, 32, 0.8)};
		ground_sweep(&ground, &sweep);
		int64_t sum = conserve_sum(&ground), low = 0, high = 0;
		assert_ok(deform_tally(ground.deform, &tally));
		assert_int_equal(sum, -tally.compacted);
		assert_int_equal(tally.confined, 0);
		for (int64_t k = 0; k < ground.posts * ground.posts; k++) {
			low += ground.offset[k] < 0 ? ground.offset[k] : 0;
			high += ground.offset[k] > 0 ? ground.offset[k] : 0;
		}
		assert_true(low < -1000000);
		/* All of it, the half of each post's rounded up, none. */
		if (i == 0)
			assert_true(tally.compacted == 0 && high == -low);
		else if (i == 1)
			assert_true(tally.compacted >= high && tally.compacted <= high + 400);
		else
			assert_true(tally.compacted == -low && high == 0);
		ground_finish(&ground);
	}
}

TEST_PROGRAM(sumner)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_quantum_stays),
		cmocka_unit_test(what_is_compacted_is_its_share),
	};
	return cmocka_run_group_tests_name("deform/sumner", tests, open_gpu, close_gpu);
}
