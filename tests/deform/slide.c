/* The sliding rules post by post against the obvious ones, bit for bit, and the hard cases of the laws. */
#include "ground.h"
#include "deform/soil/stability.h"

#define N 40 /* posts a side of what is written */
#define HELD 2

__extension__ typedef __int128 wide;

struct slab {
	int32_t base[N * N], offset[N * N], deposit[N * N];
	uint8_t contacts[N * N], classes[N * N];
};

static struct slab slab, before;

static wide sum_of(const struct slab *of)
{
	wide sum = 0;
	for (int i = 0; i < N * N; i++)
		sum += (wide)of->offset[i] + (uint32_t)of->deposit[i];
	return sum;
}

/* Twice the potential energy but for a factor: the sum of squared heights, exactly, holes left out. */
static wide energy_of(const struct slab *of)
{
	wide sum = 0;
	for (int i = 0; i < N * N; i++) {
		int64_t height = 4 * (int64_t)of->base[i] + of->offset[i];
		if (of->base[i] != BASE_NODATA)
			sum += (wide)height * height;
	}
	return sum;
}

static double relief; /* of the world, m; 0: not known */
static double tolerance; /* m */
static bool stands;   /* undisturbed ground does */

static void start(struct ground *ground, enum deform_model model, double spacing, int iterations, double depth,
		  const struct deform_soil *soils, int count)
{
	ground_init(ground, &(struct ground_params){.cells = 32, .tiles = 1, .spacing = spacing, .model = model, .soils = soils,
						    .soil_count = count, .iterations = iterations, .depth = depth, .relief = relief, .tolerance = tolerance,
						    .stands = stands});
}

/* Into the scratch, with a rim of other ground around it, and what comes of it. The deposits are laid down. */
static void slide_on_gpu(struct ground *ground)
{
	struct deform *deform = ground->deform;
	const uint32_t rim = 2;
	struct gpu_rect rect = rect_of(rim, rim, N, N), around = rect_of(0, 0, N + 2 * rim, N + 2 * rim);
	struct deform_window window = {.read = {0, 0, N + 2 * rim, N + 2 * rim}, .write = {rim, rim, N + rim, N + rim}};
	gpu_texture_clear(deform->bases, 0, around, 40 << 18);
	gpu_texture_clear(deform->planes_of[1][PLANE_OFFSET], 0, around, 1 << 20);
	gpu_texture_clear(deform->contacts, 0, around, 0);
	gpu_texture_clear(deform->deposits, 0, around, 99);
	gpu_texture_upload(deform->bases, 0, rect, slab.base);
	gpu_texture_upload(deform->planes_of[1][PLANE_OFFSET], 0, rect, slab.offset);
	gpu_texture_upload(deform->contacts, 0, rect, slab.contacts);
	gpu_texture_upload(deform->deposits, 0, rect, slab.deposit);
	if (deform->classes != NULL)
		gpu_texture_upload(deform->classes, 0, rect, slab.classes);
	deform->scratch[0].now[PLANE_OFFSET] = 1;
	assert_ok(deform_slide(deform, &window, 0));
	assert_ok(gpu_check(test_gpu, "sliding"));
	gpu_texture_read(deform->planes_of[1][PLANE_OFFSET], 0, rect, slab.offset);
	memset(slab.deposit, 0, sizeof slab.deposit);
}

/* --- the same, obviously --- */

static int64_t height_of(const struct slab *of, int i)
{
	return 4 * (int64_t)of->base[i] + of->offset[i];
}

static bool still_at(const struct slab *of, int x, int y, bool held_too)
{
	int i = y * N + x;
	if (of->base[i] == BASE_NODATA || (held_too && (of->contacts[i] & HELD)) || abs(of->offset[i]) > 768 << 20)
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

/* What slides from post `i` to `j` in one iteration of the excess rule. */
static int64_t excess(const struct ground *ground, const struct slab *of, int i, int j, bool diagonal)
{
	int64_t drop = height_of(of, i) - height_of(of, j);
	int64_t over = drop - ground->deform->soils[of->classes[i]].critical[diagonal];
	int64_t more = stands ? drop - 4 * ((int64_t)of->base[i] - of->base[j]) : INT64_MAX;
	if (least(over, more) <= (int64_t)ldexp(tolerance, 20))
		return 0;
	int64_t amount = least(least(least((over + 7) / 8, drop / 8), 4 << 20), more);
	int64_t loose = of->offset[i] + (int64_t)floor(ldexp(fmin(ground->deform->params.depth, 2048), 20));
	return isfinite(ground->deform->params.depth) ? least(amount, loose > 0 ? loose / 8 : 0) : amount;
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
	const struct slide_soil *soil = &ground->deform->soils[of->classes[i]];
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
	bool is_sumner = ground->params.model == DEFORM_SUMNER;
	for (int i = 0; i < N * N; i++) {
		int64_t room = (768 << 20) - (int64_t)of->offset[i];
		of->offset[i] += (int32_t)least(of->deposit[i], room > 0 ? room : 0);
	}
	memset(of->deposit, 0, sizeof of->deposit);
	for (int i = 0; i < N * N; i++)
		still[i] = still_at(of, i % N, i / N, !is_sumner);
	for (int n = 0; n < ground->deform->params.iterations; n++) {
		struct slab was = *of;
		for (int i = 0; i < N * N && is_sumner; i++)
			flows[i] = sumner(ground, &was, still, i % N, i / N);
		for (int i = 0; i < N * N; i++)
			for (int k = 0; k < 9; k++) {
				int px = i % N + k % 3 - 1, py = i / N + k / 3 - 1, j = py * N + px;
				if (k == 4 || px < 0 || py < 0 || px >= N || py >= N || still[i] || still[j])
					continue;
				int64_t amount = is_sumner ? flows[i].to[k] ? flows[i].share : 0
							   : excess(ground, &was, i, j, k % 2 == 0);
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
			slab.offset[i] = (int32_t)(any_share() * (1 << 30)); /* beyond 768 m */
		}
	}
}

static void every_rule_is_the_obvious_one_bit_for_bit(void **state)
{
	static const enum deform_model models[] = {DEFORM_SLIPPAGE, DEFORM_SLIPPAGE, DEFORM_SUMNER};
	/* What slippage reads of one soil, and what sumner reads of another. */
	static const char *const names[][2] = {{"dry_sand", "sand"}, {"clayey_38", "sand"}, {"dry_sand", "sand"},
					       {"dry_sand", "mud"}, {"snow_us", "snow"}, {"dry_sand", "sand"}};
	struct deform_soil soils[6];
	(void)state;
	need_gpu();
	for (int i = 0; i < 6; i++) {
		struct deform_soil own;
		assert_ok(deform_soil_named(names[i][0], &own));
		assert_ok(deform_soil_named(names[i][1], &soils[i]));
		soils[i].cohesion = own.cohesion;
		soils[i].friction_angle = own.friction_angle;
		soils[i].unit_weight = own.unit_weight;
	}
	soils[5].cohesion = soils[5].friction_angle = 0; /* nothing stands */
	for (int round = 0; round < 270; round++) {
		struct ground ground;
		stands = round >= 162 && round % 2;
		tolerance = round >= 162 ? ldexp(1 + any_word() % 1024, -(int)(round % 21)) : 0;
		tolerance = tolerance > 1 ? 1 : tolerance;
		/* Where there are no cliffs, now and then known beforehand: then no post looks for one. */
		relief = round % 5 != 4 && round % 27 < 25 && round % 2 ? 300 : 0;
		start(&ground, models[round % 3], round % 2 ? 0.0625 : 1, 1 + round % 8, round % 3 == 1 ? 0.3 : 0, soils + round % 6,
		      round % 6 == 0 ? 6 : 1);
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
	struct deform_soil soil;
	(void)state;
	need_gpu();
	assert_ok(deform_soil_named("sand", &soil));
	for (int i = 0; i < 3; i++) {
		struct ground ground;
		tolerance = i == 0 ? 0 : i == 1 ? ldexp(3.5, -20) : 1;
		int32_t quanta = i == 0 ? 0 : i == 1 ? 3 : 1 << 20;
		start(&ground, DEFORM_SUMNER, 0.5, 1, 0, &soil, 1);
		for (int k = 0; k < 2; k++) {
			const struct slide_soil *is = &ground.deform->soils[0];
			double apart = k == 0 ? 0.5 : 0.5 * M_SQRT2;
			assert_int_equal(is->critical[k], deform_critical_difference(soil.theta_out, apart) + quanta);
			assert_int_equal(is->held[k], deform_critical_difference(soil.theta_in, apart) + quanta);
			assert_int_equal(is->stop[k], deform_critical_difference(soil.theta_stop, apart) + quanta);
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
		struct deform_soil soil;
		assert_ok(deform_soil_named(names[round % 3], &soil));
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

static void flat_slab(void)
{
	memset(&slab, 0, sizeof slab);
	for (int i = 0; i < N * N; i++)
		slab.base[i] = 40 << 18;
}

/* How much steeper than what stands the steepest pair is, quanta. */
static int64_t steepest_over(const struct ground *ground)
{
	int64_t over = INT64_MIN;
	for (int i = 0; i < N * N; i++)
		for (int k = 0; k < 9; k++) {
			int px = i % N + k % 3 - 1, py = i / N + k / 3 - 1, j = py * N + px;
			if (k == 4 || px < 0 || py < 0 || px >= N || py >= N)
				continue;
			int64_t drop = height_of(&slab, i) - height_of(&slab, j) - ground->deform->soils[0].critical[k % 2 == 0];
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
		struct deform_soil soil;
		assert_ok(deform_soil_named("dry_sand", &soil));
		soil.cohesion = 0;
		start(&ground, DEFORM_SLIPPAGE, 32, 8, 0, &soil, 1);
		flat_slab();
		for (int i = 0; i < N * N; i++)
			slab.offset[i] = cliff ? (i % N < N / 2 ? 500 : -500) * (1 << 20) : i == N / 2 * N + N / 2 ? 767 << 20 : 0;
		for (int i = 0; i < N * N && cliff == 0; i++) /* from 1,000 m: part of it in the base */
			slab.base[i] = i == N / 2 * N + N / 2 ? (40 + 240) << 18 : 40 << 18;
		run_until_still(&ground, 4000);
		/* Both ways: it stands, and no flatter than it must. A pair gives at least a quantum while it is too steep. */
		int64_t over = steepest_over(&ground);
		assert_true(over <= 0);
		assert_true(over >= -ground.deform->soils[0].critical[0] / 100);
		if (!cliff)
			assert_true(height_of(&slab, N / 2 * N + N / 2) < (int64_t)(200) << 20);
		ground_finish(&ground);
	}
}

/* From a slope too steep for it a pile of sand becomes a cone at its angle. */
static void a_pile_of_sand_stands_at_its_angle(void **state)
{
	struct ground ground;
	struct deform_soil soil;
	(void)state;
	need_gpu();
	assert_ok(deform_soil_named("dry_sand", &soil));
	soil.cohesion = 0;
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
	struct deform_soil soil;
	(void)state;
	need_gpu();
	assert_ok(deform_soil_named("dry_sand", &soil));
	soil.cohesion = 0;
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
		int32_t soil_stands = stands ? 0 : ground.deform->soils[0].critical[0], tolerated = sumner && !stands ? 0 : 10485;
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

/* Every pair is within the tolerance of what stands; it is made use of, and ends the slide sooner. */
static void a_pile_stops_within_the_tolerance_beyond_its_angle(void **state)
{
	static const double tolerances[] = {0, 0.0001, 0.001, 0.01};
	struct deform_soil soil;
	(void)state;
	need_gpu();
	assert_ok(deform_soil_named("dry_sand", &soil));
	soil.cohesion = 0;
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
		struct deform_soil soil;
		assert_ok(deform_soil_named("dry_sand", &soil));
		soil.cohesion = 0;
		start(&ground, models[m], 0.0625, 1, 0, &soil, 1);
		flat_slab();
		int pit = N / 2 * N + N / 2;
		slab.offset[pit] = -(760 << 20);
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
	const struct deform_soil clay = {.cohesion = 4140, .friction_angle = 13 * M_PI / 180, .unit_weight = 16000};
	(void)state;
	/* Between posts so near the cut is upright, to a per mille. */
	assert_true(fabs(ldexp(deform_critical_difference_cohesive(&clay, 1e-4), -20) - 1.301) < 0.001);
	/* Without cohesion the angle alone. */
	struct deform_soil sand = clay;
	sand.cohesion = 0;
	assert_int_equal(deform_critical_difference_cohesive(&sand, 0.5), (int)floor(ldexp(0.5 * tan(sand.friction_angle), 20)));
	/* With more than any height is worth, always. */
	sand.cohesion = 1e9;
	assert_int_equal(deform_critical_difference_cohesive(&sand, 0.5), INT32_MAX);
	assert_int_equal(deform_critical_difference(89.95 * M_PI / 180, 1), INT32_MAX);
	assert_true(deform_critical_difference(89.9 * M_PI / 180, 1) < INT32_MAX);
	need_gpu();
	struct ground ground;
	start(&ground, DEFORM_SLIPPAGE, 1.0 / 64, 4, 0, &clay, 1);
	for (int above = 0; above < 2; above++) {
		flat_slab();
		int32_t height = deform_critical_difference_cohesive(&clay, 1.0 / 64) + above;
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
	slab.offset[at] = 767 << 20;
	slab.deposit[at] = (int32_t)(3000u << 20);
	wide sum = sum_of(&slab);
	slide_on_gpu(&ground);
	assert_ok(deform_tally(ground.deform, &tally));
	assert_int_equal(tally.refused, 2);
	assert_true(tally.compacted == (int64_t)2999 << 20);
	assert_true(sum_of(&slab) + tally.compacted == sum);
	ground_finish(&ground);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_rule_is_the_obvious_one_bit_for_bit),
		cmocka_unit_test(a_tolerance_is_whole_quanta_on_every_difference),
		cmocka_unit_test(no_iteration_raises_the_potential_energy),
		cmocka_unit_test(a_spike_and_a_cliff_of_1000_m_come_to_the_angle_of_repose),
		cmocka_unit_test(a_pile_of_sand_stands_at_its_angle),
		cmocka_unit_test(what_is_tolerated_stays_to_the_last_quantum),
		cmocka_unit_test(a_pile_stops_within_the_tolerance_beyond_its_angle),
		cmocka_unit_test(a_pit_is_filled_and_does_not_overflow),
		cmocka_unit_test(a_cohesive_cut_stands_to_culmanns_height_and_slips_above),
		cmocka_unit_test(what_would_leave_the_range_is_refused_and_counted),
	};
	return cmocka_run_group_tests_name("deform/slide", tests, open_gpu, close_gpu);
}
