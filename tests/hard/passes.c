/*
 * Many passes over one rut: what the ground becomes stays bounded, and settles.
 *
 * HARD_PASSES says how many (80); a million by hand:
 *   HARD_PASSES=1000000 build-test/tests/test_hard passes
 */
#include "../support/near.h"
#include "hard.h"
#include "../support/program.h"

static int passes_wanted(void)
{
	const char *text = getenv("HARD_PASSES");
	return text != NULL && atoi(text) > 0 ? atoi(text) : 80;
}

struct rut {
	double low, high; /* metres */
	double *quanta;
};

#define SIDE 96

static struct rut rut_after(const struct hard_model *model, int passes)
{
	/* Out and back, 1.5 m each way at 3 m/s: two passes a second, and it ends where it began. */
	char rest[512];
	snprintf(rest, sizeof rest, "time_step: 0.5\nend_time: %d\nspacing: 0.25\nobjects:\n"
		 "  - {name: wheel, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.15,\n"
		 "     path: {points: [[40, 40.3], [41.5, 40.3]], speed: 3, loop: true}}\n", (passes + 1) / 2);
	const char *store = hard_store("passes.furrow");
	mem_free(hard_drive(model, rest, store, NULL));
	struct rut rut = {0, 0, support_quanta(store, -2, (struct post_rect){112, 112, 112 + SIDE, 112 + SIDE})};
	for (int i = 0; i < SIDE * SIDE; i++) {
		rut.low = support_least(rut.low, rut.quanta[i] / (1 << OFFSET_BITS));
		rut.high = support_most(rut.high, rut.quanta[i] / (1 << OFFSET_BITS));
	}
	return rut;
}

static double difference(const struct rut *a, const struct rut *b)
{
	double most = 0;
	for (int i = 0; i < SIDE * SIDE; i++)
		most = support_most(most, fabs(a->quanta[i] - b->quanta[i]) / (1 << OFFSET_BITS));
	return most;
}

static void many_passes_over_one_rut_stay_bounded_and_converge(void **state)
{
	int passes = passes_wanted();
	for (size_t m = 0; m < HARD_MODELS; m++) {
		struct rut first = rut_after(&hard_models[m], 2), half = rut_after(&hard_models[m], passes / 2),
			   all = rut_after(&hard_models[m], passes);
		double early = difference(&first, &half), late = difference(&half, &all);
		print_message("%s: %d passes: %.4f to %.4f m; from 2 to %d passes %.6f m, then %.6f m\n", hard_models[m].name, passes,
			      all.low, all.high, passes / 2, early, late);
		/* Prescribed 0.15 m below the path's ground, which is rough by some decimetres under the wheel's width. */
		assert_true(all.low > -1 && all.high < 0.5);
		assert_true(late <= early && late < 0.02);
		free(first.quanta);
		free(half.quanta);
		free(all.quanta);
	}
}

TEST_PROGRAM(passes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(many_passes_over_one_rut_stay_bounded_and_converge),
	};
	return cmocka_run_group_tests_name("hard passes", tests, support_enter, support_leave);
}
