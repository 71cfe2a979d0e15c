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
		struct soil_numbers soil;
		struct deform_tally tally;
		assert_ok(soil_named("snow", &soil)); /* stands however steep */
		soil.compression = 0.5 * i;
		ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .spacing = 0.125, .height = conserve_rough,
							     .model = DEFORM_SUMNER, .soils = &soil, .soil_count = 1});
		struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 1};
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

/* Of each material, what lies around a print is the share of the print that Sumner's alpha displaces: 1 - compression. The print is the sphere's
 * cap, summed here post by post; it stays whole while the sphere is in it, however the rim slides. */
static void rims_have_what_is_not_lost(void **state)
{
	(void)state;
	need_gpu();
	static const struct {
		const char *name;
		double alpha;
	} materials[] = {{"sand", 0.3}, {"dry_sand", 0.3}, {"mud", 0.41}, {"snow", 0}};
	for (int round = 0; round < 12; round++) {
		const double spacing = 0.25 / (1 << round % 3), radius = 1.2, deep = 0.3;
		struct ground ground;
		struct soil_numbers soil;
		assert_ok(soil_named(materials[round / 3].name, &soil));
		ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 4, .spacing = spacing, .model = DEFORM_SUMNER, .soils = &soil, .soil_count = 1});
		const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = radius};
		const struct deform_contact stand = ground_stand(&ground, &ball, 64, 64, radius - deep);
		ground_sweep(&ground, &stand);
		double print = 0;
		for (int64_t y = 0; y < ground.posts; y++)
			for (int64_t x = 0; x < ground.posts; x++) {
				const double far = hypot((double)x - 64, (double)y - 64) * spacing;
				print += far < radius ? fmax(sqrt(radius * radius - far * far) - (radius - deep), 0) : 0;
			}
		const double rim = print + (double)conserve_sum(&ground) * 0x1p-20;
		if (!(fabs(rim / print - materials[round / 3].alpha) < 1e-4))
			fail_msg("%s at %g m: rim / print is %g", materials[round / 3].name, spacing, rim / print);
		assert_true(fabs(1 - soil.compression - materials[round / 3].alpha) < 1e-12);
		ground_finish(&ground);
	}
}

TEST_PROGRAM(sumner)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_quantum_stays),
		cmocka_unit_test(what_is_compacted_is_its_share),
		cmocka_unit_test(rims_have_what_is_not_lost),
	};
	return cmocka_run_group_tests_name("deform/sumner", tests, open_gpu, close_gpu);
}
