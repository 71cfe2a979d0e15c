/* High slopes of cohesive soil: at any spacing they fall above Culmann's height, and are stable below it. */
#include "../support/near.h"
#include "late.h"
#include "sliding.h"
#include "soil/stability.h"
#include "../support/program.h"

static const double steep = M_PI / 3;

/* A straight bank through the middle of the ground. */
static struct bank {
	double spacing, middle, height, direction, shift; /* m; rad; posts across the bank */
} bank;

static int32_t bank_post(int64_t x, int64_t y)
{
	double east = (double)x * bank.spacing - bank.middle, north = (double)y * bank.spacing - bank.middle;
	double across = east * cos(bank.direction) + north * sin(bank.direction) + bank.shift * bank.spacing;
	double height = 10 - fmax(0, fmin(bank.height, across * tan(steep) + bank.height / 2));
	return (int32_t)lrint(ldexp(height, BASE_BITS));
}

static void make(struct ground *ground, const struct soil_numbers *soil, double spacing, double height, double direction, double shift)
{
	uint32_t tiles = spacing < 0.2 ? 3 : 2;
	bank = (struct bank){spacing, tiles * 32 * spacing, height, direction, shift};
	ground_init(ground, &(struct ground_params){.cells = 64, .tiles = tiles, .spacing = spacing, .model = DEFORM_SLIPPAGE,
						    .iterations = 4, .soils = soil, .soil_count = 1, .height = bank_post, .relief = 100});
	assert_ok(deform_wake(ground->deform, all_of(ground)));
}

static const char *const cohesive[] = {"dry_sand", "clayey_38", "upland_loam_51"};

static struct soil_numbers soil_of(int i)
{
	struct soil_numbers soil;
	assert_ok(soil_named(cohesive[i], &soil));
	return soil;
}

__extension__ typedef __int128 wide;

/* Returns a multiple of the potential energy. */
static wide energy_of(struct ground *ground, int64_t *sum)
{
	wide energy = 0;
	ground_read(ground);
	*sum = 0;
	for (int64_t i = 0; i < ground->posts * ground->posts; i++) {
		int64_t height = 4 * (int64_t)ground->base[i] + ground->offset[i];
		energy += (wide)height * height;
		*sum += ground->offset[i];
	}
	return energy;
}

static void a_bank_falls_above_culmanns_height_and_stands_below_at_every_spacing(void **state)
{
	(void)state;
	need_gpu();
	for (int s = 0; s < 3; s++)
		/* Only the bank of dry_sand is low enough for the hops to follow it at a small spacing too. */
		for (int k = 0; k < (s == 0 ? 7 : 4) * 3; k++) {
			struct soil_numbers soil = soil_of(s);
			double spacing = ldexp(1, -(k / 3)), critical = reference_culmann(&soil, steep);
			for (int over = 0; over < 2; over++) {
				/* At a spacing of 1 m a lower bank would be narrower than a post, and so less steep than 60 degrees. */
				double height = over ? fmax(3, 1.2 * critical) : 0.8 * critical;
				struct ground ground;
				int64_t sum;
				make(&ground, &soil, spacing, height, k % 3 * M_PI / 8, 0.37 * (k % 2));
				wide before = energy_of(&ground, &sum), energy = before, was = before;
				for (int n = 0; n < 4; n++) {
					interval(&ground, NULL, 0);
					energy = energy_of(&ground, &sum);
					assert_true(energy <= was && sum == 0);
					was = energy;
				}
				if ((energy < before) != over)
					fail_msg("%s, %g m apart, %g m high, %g degrees round: %s", cohesive[s], spacing, height, k % 3 * 22.5,
						 over ? "stands" : "falls");
				ground_finish(&ground);
			}
		}
}

/* The steepest step in the middle row. */
static double steepest(struct ground *ground)
{
	double most = 0;
	int64_t row = ground->posts / 2 * ground->posts;
	ground_read(ground);
	for (int64_t i = row + 1; i < row + ground->posts; i++)
		most = support_most(most, ldexp(4.0 * (ground->base[i - 1] - ground->base[i]) + ground->offset[i - 1] - ground->offset[i], -OFFSET_BITS));
	return atan(most / ground->params.spacing);
}

/* A bank that falls comes to rest at the angle at which a slope of its height is just stable. */
static void a_bank_comes_to_rest_at_culmanns_angle(void **state)
{
	(void)state;
	need_gpu();
	for (int s = 0; s < 2; s++)
		for (double spacing = 0.5; spacing >= 0.25; spacing /= 2) {
			struct soil_numbers soil = soil_of(s);
			double height = 1.4 * reference_culmann(&soil, steep), angle = atan(1 / soil_critical_cotangent(&soil, height));
			struct ground ground;
			size_t blocks = 1;
			make(&ground, &soil, spacing, height, 0, 0.37);
			for (int n = 0; n < 600 && blocks > 0; n++)
				blocks = interval(&ground, NULL, 0);
			assert_int_equal(blocks, 0);
			assert_true(fabs(steepest(&ground) - angle) < 2.5 * M_PI / 180);
			ground_finish(&ground);
		}
}

/* --- the table --- */

/* Returns the critical difference in a slope of this height. The cotangent is interpolated between two known heights. */
static int64_t limit_of(const struct ground *ground, int64_t height)
{
	const int32_t *slope = ground->deform->sliding.classes[0].slope;
	const int digits = ground->params.spacing >= 0.25 ? 12 : ground->params.spacing >= 0.125 ? 13 : 16;
	int i = 0;
	double known[2] = {0, 0};
	height = height < 16 ? 16 : height > 131071 ? 131071 : height;
	for (;; i++) {
		for (int k = 0; k < 2; k++)
			known[k] = ldexp(8 + (i + k) % 8, 1 + (i + k) / 8);
		if ((double)height < known[1])
			break;
	}
	double part = floor(256 * ((double)height - known[0]) / (known[1] - known[0])) / 256;
	int64_t cotangent = (int64_t)floor(slope[i] + (slope[i + 1] - slope[i]) * part);
	return cotangent > 0 ? (int64_t)ldexp(ground->params.spacing, 20 + digits) / cotangent : 1 << 30;
}

/* The table of known cotangents gives what the formula gives. */
static void assert_known(const struct ground *ground, const struct soil_numbers *soil)
{
	int64_t apart = (int64_t)ldexp(ground->params.spacing, 20);
	for (double height = 0.1; height < 100; height *= 1.17) {
		double exact = ground->params.spacing / soil_critical_cotangent(soil, height);
		int64_t limit = limit_of(ground, (int64_t)(height * 512));
		if (exact > 0 && exact < 8 * ground->params.spacing)
			assert_true(fabs(ldexp((double)limit, -20) / exact - 1) < 0.02 && limit >= (int64_t)(0.998 * tan(soil->friction_angle) * (double)apart));
		else
			assert_true(limit > 4 * apart);
	}
}

/* Cliffs, terraces and hollows across blocks and tiles, with holes. Heights and cohesion shrink with the spacing. */
static double broken_scale;

static int32_t broken(int64_t x, int64_t y)
{
	double height = 0.4 * sin((double)x * 0.11 + 1) * cos((double)y * 0.07) + (x + 2 * y > 150 ? 0.6 : 0);
	height += fmax(0, fmin(1.5, 0.6 * (12 - hypot((double)x - 40, (double)y - 60))));
	return x % 37 == 5 && y % 29 < 3 ? BASE_NODATA : (int32_t)lrint(ldexp(height * broken_scale, BASE_BITS)) + conserve_rough(x, y) / 16;
}

static void start_broken(struct ground *ground, uint32_t cells, int iterations, double spacing, double relief)
{
	struct soil_numbers soil = soil_of(0);
	broken_scale = spacing / 0.25;
	soil.cohesion *= broken_scale;
	ground_init(ground, &(struct ground_params){.cells = cells, .tiles = 128 / cells, .spacing = spacing, .model = DEFORM_SLIPPAGE,
						    .iterations = iterations, .soils = &soil, .soil_count = 1, .height = broken, .relief = relief});
}

static void known_cotangents_give_what_the_formula_gives(void **state)
{
	(void)state;
	need_gpu();
	for (int round = 0; round < 3; round++) {
		struct ground ground;
		start_broken(&ground, 64, 1, round == 0 ? 1.0 / 64 : round == 1 ? 0.125 : 0.25, 100);
		assert_known(&ground, &ground.deform->params.soils[0]);
		ground_finish(&ground);
	}
}

/* --- active blocks and the size of tiles change nothing --- */

static void few_blocks_do_what_all_would(void **state)
{
	/* At the foot of what is steep, near corners of blocks. The next is dug before the last has come to rest. */
	static const int dug[][2] = {{64, 60}, {33, 62}, {90, 45}, {90, 52}};
	enum { DUG = sizeof dug / sizeof *dug, BETWEEN = 20 };
	(void)state;
	need_gpu();
	for (int round = 0; round < 3; round++) {
		const int iterations = round == 0 ? 1 : round == 1 ? 3 : 8;
		struct ground few, all, late;
		const double spacing = round == 1 ? 1.0 / 64 : 0.25;
		start_broken(&few, 64, iterations, spacing, 100);
		start_broken(&all, 16, iterations, spacing, 0);
		start_broken(&late, 32, iterations, spacing, 100);
		struct ground *grounds[] = {&few, &all, &late};
		size_t visited = 0, possible = 0;
		int n = 0, still = 0;
		for (int k = 0; k < 3; k++)
			assert_ok(deform_wake(grounds[k]->deform, all_of(grounds[k])));
		for (; n < 1500 && still < 2; n++) {
			if (n % BETWEEN == 0 && n < DUG * BETWEEN)
				for (int k = 0; k < 3; k++)
					disturb(grounds[k], dug[n / BETWEEN][0], dug[n / BETWEEN][1], 1.4 * broken_scale);
			size_t blocks = interval(&few, NULL, 0);
			visited += blocks;
			still += blocks == 0 && n > DUG * BETWEEN;
			assert_ok(deform_wake(all.deform, all_of(&all)));
			possible += interval(&all, NULL, 0);
			late_by = n % 7 == 0 ? 3 : 2;
			interval(&late, NULL, 0);
			late_by = 0;
			late_pass();
			if (n % 10 == 0 || still > 0) {
				assert_same(&few, &all, n);
				assert_same(&late, &all, n);
			}
		}
		assert_true(still == 2 && visited > 0 && visited < possible * 2 / 3);
		for (int k = 0; k < 3; k++)
			ground_finish(grounds[k]);
	}
}

TEST_PROGRAM(slopes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_bank_falls_above_culmanns_height_and_stands_below_at_every_spacing),
		cmocka_unit_test(a_bank_comes_to_rest_at_culmanns_angle),
		cmocka_unit_test(known_cotangents_give_what_the_formula_gives),
		cmocka_unit_test(few_blocks_do_what_all_would),
	};
	return cmocka_run_group_tests_name("deform/slopes", tests, open_gpu, close_gpu);
}
