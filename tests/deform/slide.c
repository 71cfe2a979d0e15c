/* The rules of sliding: sumner is post by post the same as a plain version of it, and no rule raises the potential energy. The rule of excess is
 * compared with the CPU's: tests/soil/sliding.c. */
#include "slab.h"
#include "../support/program.h"

/* --- the same, obviously --- */

static bool still_at(const struct slab *of, int x, int y)
{
	int i = y * N + x;
	if (of->base[i] == BASE_NODATA || abs(of->offset[i]) > 736 << 20)
		return true;
	for (int k = 0; k < 9; k++) { /* 1536 m from any of them: around the slab lie 40 m */
		int px = x + k % 3 - 1, py = y + k / 3 - 1;
		bool inside = px >= 0 && py >= 0 && px < N && py < N;
		int64_t other = inside ? of->base[py * N + px] : 40 << 18, offset = inside ? of->offset[py * N + px] : 0;
		if (relief == 0 && other != BASE_NODATA && llabs(of->base[i] - other + ((of->offset[i] - offset) >> 2)) >= 1536 << 18)
			return true;
	}
	return false;
}

static int64_t least(int64_t a, int64_t b)
{
	return a < b ? a : b;
}

struct flow {
	int64_t share;
	bool to[9];
};

static struct flow sumner(const struct ground *ground, const struct slab *of, const bool *still, int x, int y)
{
	struct flow flow = {.share = 0};
	int i = y * N + x, count = 0;
	int64_t sum = 0;
	bool starts = false;
	const struct shed_soil *soil = &ground->deform->soils[of->classes[i]];
	for (int k = 0; k < 9 && !still[i]; k++) {
		int px = x + k % 3 - 1, py = y + k / 3 - 1, j = py * N + px;
		if (k == 4 || px < 0 || py < 0 || px >= N || py >= N || still[j])
			continue;
		bool diagonal = k % 2 == 0, held = ((of->contacts[i] | of->contacts[j]) & HELD) != 0;
		int64_t drop = height_of(of, i) - height_of(of, j);
		if (stands && drop - 4 * ((int64_t)of->base[i] - of->base[j]) <= (int64_t)ldexp(tolerance, 20))
			continue;
		starts |= drop > soil->stop[diagonal];
		if (drop > (held ? soil->held : soil->critical)[diagonal]) {
			flow.to[k] = true;
			count++;
			sum += least(drop, 64 << 20);
		}
	}
	if (starts && count > 0)
		flow.share = least((int64_t)((wide)sum * soil->share[count - 1] >> 32), 4 << 20);
	return flow;
}

static void slide(const struct ground *ground, struct slab *of)
{
	static bool still[N * N];
	static struct flow flows[N * N];
	for (int i = 0; i < N * N; i++) {
		int64_t room = (736 << 20) - (int64_t)of->offset[i];
		of->offset[i] += (int32_t)least(of->deposit[i], room > 0 ? room : 0);
	}
	memset(of->deposit, 0, sizeof of->deposit);
	for (int i = 0; i < N * N; i++)
		still[i] = still_at(of, i % N, i / N);
	for (int n = 0; n < ground->deform->params.iterations; n++) {
		struct slab was = *of;
		for (int i = 0; i < N * N; i++)
			flows[i] = sumner(ground, &was, still, i % N, i / N);
		for (int i = 0; i < N * N; i++)
			for (int k = 0; k < 9; k++) {
				int px = i % N + k % 3 - 1, py = i / N + k / 3 - 1, j = py * N + px;
				if (k == 4 || px < 0 || py < 0 || px >= N || py >= N || still[i] || still[j])
					continue;
				int64_t amount = flows[i].to[k] ? flows[i].share : 0;
				of->offset[i] -= (int32_t)amount;
				of->offset[j] += (int32_t)amount;
			}
	}
}

/* --- tests --- */

/* Ground of every kind: from smooth to rough beyond reason. */
static void any_ground(struct ground *ground, int round)
{
	int32_t rough = (int32_t)(1u << (round % 27)); /* quanta / 4: up to 256 m from post to post */
	for (int i = 0; i < N * N; i++) {
		slab.base[i] = (40 << 18) + (int32_t)(any_share() * rough);
		/* One cliff from end to end of what a base may be: as differences wrap, a metre or two. */
		if (round == 154)
			slab.base[i] = i % N < N / 2 ? INT32_MAX - (int32_t)(any_word() >> 14) : INT32_MIN + 1 + (int32_t)(any_word() >> 14);
		slab.offset[i] = (int32_t)(any_share() * rough);
		slab.deposit[i] = any_word() % 4 == 0 ? (int32_t)(any_word() % (1u << 20)) : 0;
		slab.contacts[i] = any_word() % 8 == 0 ? (uint8_t)(any_word() % 4) : 0;
		slab.classes[i] = (uint8_t)(any_word() % (uint32_t)ground->deform->params.soil_count);
		if (any_word() % 16 == 0) {
			slab.base[i] = BASE_NODATA;
			slab.offset[i] = slab.deposit[i] = 0;
			slab.contacts[i] |= 4;
		} else if (round % 5 == 4 && round != 154 && any_word() % 16 == 0) {
			slab.base[i] += (int32_t)(any_word() % 3 * 900 - 900) * (1 << 18); /* cliffs of more than 1536 m too */
		} else if (round % 5 == 3 && any_word() % 16 == 0) {
			slab.offset[i] = (int32_t)(any_share() * (1 << 30)); /* beyond 736 m */
		}
	}
}

static void sumner_is_the_obvious_rule_bit_for_bit(void **state)
{
	static const char *const names[] = {"sand", "mud", "snow"};
	struct soil_numbers soils[3];
	(void)state;
	need_gpu();
	for (int i = 0; i < 3; i++)
		assert_ok(soil_named(names[i], &soils[i]));
	for (int round = 0; round < 160; round++) {
		struct ground ground;
		stands = round >= 100 && round % 2;
		tolerance = round >= 100 ? ldexp(1 + any_word() % 1024, -(int)(round % 21)) : 0;
		tolerance = tolerance > 1 ? 1 : tolerance;
		/* Where there are no cliffs, now and then known beforehand: then no post looks for one. */
		relief = round % 5 != 4 && round % 27 < 25 && round % 2 ? 300 : 0;
		start(&ground, DEFORM_SUMNER, round % 2 ? 0.0625 : 1, 1 + round % 8, 0, soils + round % 3, round % 3 == 0 ? 3 : 1);
		any_ground(&ground, round);
		before = slab;
		slide(&ground, &before);
		slide_on_gpu(&ground);
		for (int i = 0; i < N * N; i++)
			if (slab.offset[i] != before.offset[i])
				fail_msg("round %d, post %d, %d: %d, not %d", round, i % N, i / N, slab.offset[i], before.offset[i]);
		ground_finish(&ground);
	}
	relief = tolerance = 0;
	stands = false;
}

static void a_tolerance_is_whole_quanta_on_every_difference(void **state)
{
	struct soil_numbers soil;
	(void)state;
	need_gpu();
	assert_ok(soil_named("sand", &soil));
	for (int i = 0; i < 3; i++) {
		struct ground ground;
		tolerance = i == 0 ? 0 : i == 1 ? ldexp(3.5, -20) : 1;
		int32_t quanta = i == 0 ? 0 : i == 1 ? 3 : 1 << 20;
		start(&ground, DEFORM_SUMNER, 0.5, 1, 0, &soil, 1);
		for (int k = 0; k < 2; k++) {
			const struct shed_soil *is = &ground.deform->soils[0];
			double apart = k == 0 ? 0.5 : 0.5 * M_SQRT2;
			assert_int_equal(is->critical[k], soil_critical_difference(soil.theta_out, apart) + quanta);
			assert_int_equal(is->held[k], soil_critical_difference(soil.theta_in, apart) + quanta);
			assert_int_equal(is->stop[k], soil_critical_difference(soil.theta_stop, apart) + quanta);
		}
		ground_finish(&ground);
	}
	/* What stands however steep still does. */
	struct ground ground;
	soil.theta_in = soil.theta_out = soil.theta_stop = 90 * M_PI / 180;
	start(&ground, DEFORM_SUMNER, 0.5, 1, 0, &soil, 1);
	assert_int_equal(ground.deform->soils[0].critical[0], INT32_MAX);
	assert_int_equal(ground.deform->soils[0].stop[1], INT32_MAX);
	ground_finish(&ground);
	tolerance = 0;
}

static void no_iteration_raises_the_potential_energy(void **state)
{
	static const char *const names[] = {"dry_sand", "sand", "mud"};
	int still = 0;
	(void)state;
	need_gpu();
	for (int round = 0; round < 54; round++) {
		struct ground ground;
		struct soil_numbers soil;
		assert_ok(soil_named(names[round % 3], &soil));
		soil.cohesion = round % 2 ? 0 : soil.cohesion;
		soil.friction_angle = round % 4 == 3 ? 0 : soil.friction_angle;
		start(&ground, round % 3 ? DEFORM_SUMNER : DEFORM_SLIPPAGE, 0.125, 1, 0, &soil, 1);
		any_ground(&ground, round);
		memset(slab.deposit, 0, sizeof slab.deposit);
		wide sum = sum_of(&slab), energy = energy_of(&slab);
		for (int n = 0; n < 60; n++) {
			slide_on_gpu(&ground);
			wide now = energy_of(&slab);
			assert_true(now <= energy);
			assert_true(sum_of(&slab) == sum);
			still += now == energy;
			energy = now;
		}
		ground_finish(&ground);
	}
	assert_true(still < 54 * 60 / 2);
}

TEST_PROGRAM(slide)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(sumner_is_the_obvious_rule_bit_for_bit),
		cmocka_unit_test(a_tolerance_is_whole_quanta_on_every_difference),
		cmocka_unit_test(no_iteration_raises_the_potential_energy),
	};
	return cmocka_run_group_tests_name("deform/slide", tests, open_gpu, close_gpu);
}
