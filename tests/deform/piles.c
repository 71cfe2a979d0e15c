/* Piles, cliffs, pits and cuts slide to rest at the angle that their soil has, and within the range of an offset. */
#include "slab.h"
#include "../support/program.h"

static struct soil_numbers loose_sand(void)
{
	struct soil_numbers soil;
	assert_ok(soil_named("dry_sand", &soil));
	soil.cohesion = 0;
	return soil;
}

static int run_until_still(struct ground *ground, int most)
{
	wide sum = sum_of(&slab), energy = energy_of(&slab);
	for (int n = 0; n < most; n++) {
		slide_on_gpu(ground);
		wide now = energy_of(&slab);
		assert_true(now <= energy && sum_of(&slab) == sum);
		if (now == energy)
			return n;
		energy = now;
	}
	fail_msg("it still moves after %d calls", most);
	return most;
}

/* Returns the critical differences of a ground's soil, fixed-point units. */
static const int32_t *criticals(const struct ground *ground)
{
	const struct deform *deform = ground->deform;
	return ground->params.model == DEFORM_SUMNER ? deform->soils[0].critical : deform->sliding.classes[0].critical;
}

/* Returns by how much the steepest pair of posts exceeds its critical difference, fixed-point units. */
static int64_t steepest_over(const struct ground *ground)
{
	int64_t over = INT64_MIN;
	for (int i = 0; i < N * N; i++)
		for (int k = 0; k < 9; k++) {
			int px = i % N + k % 3 - 1, py = i / N + k / 3 - 1, j = py * N + px;
			if (k == 4 || px < 0 || py < 0 || px >= N || py >= N)
				continue;
			int64_t drop = height_of(&slab, i) - height_of(&slab, j) - criticals(ground)[k % 2 == 0];
			over = drop > over ? drop : over;
		}
	return over;
}

static void a_spike_and_a_cliff_of_1000_m_come_to_the_angle_of_repose(void **state)
{
	(void)state;
	need_gpu();
	for (int cliff = 0; cliff < 2; cliff++) {
		struct ground ground;
		struct soil_numbers soil = loose_sand();
		start(&ground, DEFORM_SLIPPAGE, 32, 8, 0, &soil, 1);
		flat_slab();
		for (int i = 0; i < N * N; i++)
			slab.offset[i] = cliff ? (i % N < N / 2 ? 500 : -500) * (1 << 20) : i == N / 2 * N + N / 2 ? 735 << 20 : 0;
		for (int i = 0; i < N * N && cliff == 0; i++) /* from 1,000 m: part of it in the base */
			slab.base[i] = i == N / 2 * N + N / 2 ? (40 + 272) << 18 : 40 << 18;
		run_until_still(&ground, 4000);
		/* It is stable, and no flatter than it must be. A pair gives at least a fixed-point unit while it is too steep. */
		int64_t over = steepest_over(&ground);
		assert_true(over <= 0);
		assert_true(over >= -criticals(&ground)[0] / 100);
		if (!cliff)
			assert_true(height_of(&slab, N / 2 * N + N / 2) < (int64_t)(200) << 20);
		ground_finish(&ground);
	}
}

/* A pile of sand that is too steep becomes a cone at its angle of repose. */
static void a_pile_of_sand_stands_at_its_angle(void **state)
{
	struct ground ground;
	struct soil_numbers soil = loose_sand();
	(void)state;
	need_gpu();
	soil.friction_angle = 30 * M_PI / 180;
	start(&ground, DEFORM_SLIPPAGE, 0.05, 8, 0, &soil, 1);
	flat_slab();
	for (int y = -3; y <= 3; y++)
		for (int x = -3; x <= 3; x++)
			slab.offset[(N / 2 + y) * N + N / 2 + x] = 1 << 20;
	run_until_still(&ground, 4000);
	/* Along a row the height falls by tan 30 a post, from near the top to near the foot. */
	int far = 0;
	for (int x = N / 2 + 1; x < N - 1 && slab.offset[N / 2 * N + x + 1] > 0; x++, far++) {
		double slope = (slab.offset[N / 2 * N + x] - slab.offset[N / 2 * N + x + 1]) / ldexp(0.05, 20);
		assert_true(slope <= tan(soil.friction_angle));
		if (x > N / 2 + 2 && slab.offset[N / 2 * N + x + 2] > 0)
			assert_true(slope > 0.9 * tan(soil.friction_angle));
	}
	assert_true(far >= 6);
	ground_finish(&ground);
}

static void what_is_tolerated_stays_to_the_last_quantum(void **state)
{
	struct soil_numbers soil = loose_sand();
	(void)state;
	need_gpu();
	soil.theta_stop = soil.theta_out;
	tolerance = 0.01;
	/* On level ground, and (the last two) on an undisturbed step that is steeper than soil stands. */
	for (int i = 0; i < 8; i++) {
		struct ground ground;
		bool sumner = i % 4 > 1;
		int more = i % 2;
		stands = i > 3;
		start(&ground, sumner ? DEFORM_SUMNER : DEFORM_SLIPPAGE, 0.05, 1, 0, &soil, 1);
		flat_slab();
		for (int k = 0; k < N * N && stands; k++)
			slab.base[k] += k % N < N / 2 ? 1 << 17 : 0;
		int32_t soil_stands = stands ? 0 : criticals(&ground)[0], tolerated = sumner && !stands ? 0 : 10485;
		for (int k = 0; k < N * N; k++)
			slab.offset[k] = k % N < N / 2 ? soil_stands + tolerated + more : 0;
		before = slab;
		slide_on_gpu(&ground);
		assert_int_equal(memcmp(slab.offset, before.offset, sizeof slab.offset) != 0, more);
		ground_finish(&ground);
	}
	tolerance = 0;
	stands = false;
}

/* Every pair is within the tolerance of a stable one. Some pairs use it, and the slide ends sooner. */
static void a_pile_stops_within_the_tolerance_beyond_its_angle(void **state)
{
	static const double tolerances[] = {0, 0.0001, 0.001, 0.01};
	struct soil_numbers soil = loose_sand();
	(void)state;
	need_gpu();
	soil.friction_angle = 30 * M_PI / 180;
	soil.theta_stop = soil.theta_out; /* or a slope between the two would stand anyway */
	for (int m = 0; m < 2; m++) {
		int calls_before = INT32_MAX;
		for (int t = 0; t < 4; t++) {
			struct ground ground;
			tolerance = tolerances[t];
			start(&ground, m == 0 ? DEFORM_SLIPPAGE : DEFORM_SUMNER, 0.05, 1, 0, &soil, 1);
			flat_slab();
			for (int y = -3; y <= 3; y++)
				for (int x = -3; x <= 3; x++)
					slab.offset[(N / 2 + y) * N + N / 2 + x] = 1 << 18;
			int calls = run_until_still(&ground, 8000);
			int64_t over = steepest_over(&ground), quanta = (int64_t)ldexp(tolerance, 20);
			quanta = m == 0 ? quanta : 0; /* it is in what stands */
			assert_true(over <= quanta);
			assert_true(t == 0 || m == 1 || over > quanta / 2);
			assert_true(m == 1 || calls < calls_before); /* a share of the mean comes to rest in steps */
			calls_before = calls;
			ground_finish(&ground);
		}
	}
	tolerance = 0;
}

/* The worst that a post can be given: all its neighbours shed into it, and nothing else. */
static void a_pit_is_filled_and_does_not_overflow(void **state)
{
	static const enum deform_model models[] = {DEFORM_SLIPPAGE, DEFORM_SUMNER};
	(void)state;
	need_gpu();
	for (int m = 0; m < 2; m++) {
		struct ground ground;
		struct soil_numbers soil = loose_sand();
		start(&ground, models[m], 0.0625, 1, 0, &soil, 1);
		flat_slab();
		int pit = N / 2 * N + N / 2;
		slab.offset[pit] = -(730 << 20);
		for (int n = 0; n < 8; n++) {
			int32_t was = slab.offset[pit];
			slide_on_gpu(&ground);
			/* As much as may pass at once; after that Sumner's neighbours shed to one another too. */
			int32_t most = 8 * (4 << 20), taken = slab.offset[pit] - was;
			assert_true(n == 0 || models[m] == DEFORM_SLIPPAGE ? taken == most : taken > 0 && taken <= most);
		}
		run_until_still(&ground, 4000);
		for (int i = 0; i < N * N; i++)
			assert_true(slab.offset[i] <= 0);
		assert_true(slab.offset[pit] > -(2 << 20));
		ground_finish(&ground);
	}
}

static void a_cohesive_cut_stands_to_culmanns_height_and_slips_above(void **state)
{
	const struct soil_numbers clay = {.cohesion = 4140, .friction_angle = 13 * M_PI / 180, .unit_weight = 16000};
	(void)state;
	need_gpu();
	struct ground ground;
	start(&ground, DEFORM_SLIPPAGE, 1.0 / 64, 4, 0, &clay, 1);
	for (int above = 0; above < 2; above++) {
		flat_slab();
		int32_t height = soil_critical_difference_cohesive(&clay, 1.0 / 64) + above;
		assert_true(fabs(ldexp(height, -20) - 1.301) < 0.02);
		for (int i = 0; i < N * N; i++)
			slab.offset[i] = i % N < N / 2 ? height : 0;
		before = slab;
		slide_on_gpu(&ground);
		assert_int_equal(memcmp(slab.offset, before.offset, sizeof slab.offset) != 0, above);
	}
	ground_finish(&ground);
}

static void what_would_leave_the_range_is_refused_and_counted(void **state)
{
	struct ground ground;
	struct deform_tally tally;
	(void)state;
	need_gpu();
	start(&ground, DEFORM_SLIPPAGE, 0.125, 8, 0, NULL, 0);
	/* Too deep to take part: what stands above it stays. */
	flat_slab();
	int at = N / 2 * N + N / 2;
	slab.offset[at] = -(800 << 20);
	before = slab;
	slide_on_gpu(&ground);
	assert_memory_equal(slab.offset, before.offset, sizeof slab.offset);
	assert_ok(deform_tally(ground.deform, &tally));
	assert_int_equal(tally.refused, 1);
	assert_int_equal(tally.compacted, 0);
	/* A deposit beyond the range is compacted; the sum over all still is what it was. */
	flat_slab();
	slab.offset[at] = 735 << 20;
	slab.deposit[at] = (int32_t)(3000u << 20);
	wide sum = sum_of(&slab);
	slide_on_gpu(&ground);
	assert_ok(deform_tally(ground.deform, &tally));
	assert_int_equal(tally.refused, 2);
	assert_true(tally.compacted == (int64_t)2999 << 20);
	assert_true(sum_of(&slab) + tally.compacted == sum);
	ground_finish(&ground);
}

TEST_PROGRAM(piles)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_spike_and_a_cliff_of_1000_m_come_to_the_angle_of_repose),
		cmocka_unit_test(a_pile_of_sand_stands_at_its_angle),
		cmocka_unit_test(what_is_tolerated_stays_to_the_last_quantum),
		cmocka_unit_test(a_pile_stops_within_the_tolerance_beyond_its_angle),
		cmocka_unit_test(a_pit_is_filled_and_does_not_overflow),
		cmocka_unit_test(a_cohesive_cut_stands_to_culmanns_height_and_slips_above),
		cmocka_unit_test(what_would_leave_the_range_is_refused_and_counted),
	};
	return cmocka_run_group_tests_name("deform/piles", tests, open_gpu, close_gpu);
}
