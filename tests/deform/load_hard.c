/*
 * Loads where the search is hard: stiff and soft soil, tiny and huge loads, cohesion, an exponent near 0, an object half over
 * nothing. The height is held to the reference in doubles, and to a search from above in small steps.
 */
#include "../validation/bed_gpu.h"
#include "../long.h"
#include "../support/near.h"
#include "../support/program.h"

enum { POSTS = 60, STEPS = 100 };

static const struct soil_shape bodies[] = {
	{.kind = SOIL_WHEEL, .radius = 0.32, .width = 0.24},
	{.kind = SOIL_BOX, .size = {0.3, 0.2, 0.4}},
	{.kind = SOIL_SPHERE, .radius = 0.3},
};
enum { BODIES = sizeof bodies / sizeof *bodies };

static struct soil_numbers soil_of(int kind)
{
	struct soil_numbers soil = bed_soil(kind == 2 ? "heavy_clay_25" : kind == 4 ? "snow_us" : "dry_sand");
	if (kind == 1) { /* stiff: nearly rock */
		soil.bekker_kphi = 1e8;
		soil.bekker_n = 1;
	} else if (kind == 3) {
		soil.bekker_n = 0.1;
		soil.bekker_kphi = 5e4;
		soil.bekker_kc = 0;
	}
	return soil;
}

static const char *const kinds[] = {"sand", "stiff", "clay", "n 0.1", "snow"};
enum { KINDS = sizeof kinds / sizeof *kinds };

/* Heights that a base holds exactly. */
static double tilted(int x, int y)
{
	return ldexp(3 * x - 2 * y, -10);
}

/* Small bumps, and a bank of 1/8 m, about as steep as soil stands. */
static double banked(int x, int y)
{
	const int up = x - POSTS / 2 + 6;
	return ldexp(up < 0 ? 0 : up > 12 ? 12 : up, -7) + ldexp((x * 7 + y * 13) % 5, -11);
}

struct place {
	double (*ground)(int x, int y);
	double x, y; /* posts */
};
static const struct place places[] = {
	{NULL, 30.3, 30.2}, {tilted, 30.3, 30.2}, {banked, 30.3, 30.2}, {NULL, 59, 30.2}, /* half of it over nothing */
};
enum { PLACES = sizeof places / sizeof *places };

struct seen {
	int carried, skipped;
	double least; /* how much higher a search in small steps found the load, m, at most */
};

/* The reference at the height that was found, a little below and a little above it, and all the way down to it. */
static void compare(const struct deform_contact *sweep, void *bed, double lower, const char *kind, struct seen *seen)
{
	struct bed_reference *reference = bed;
	const struct soil_numbers *soil = &reference->params.soils[0];
	const size_t count = (size_t)POSTS * POSTS;
	double *under = mem_alloc(count, sizeof *under), *rest = mem_alloc(count, sizeof *rest), top = INFINITY;
	assert_true(under != NULL && rest != NULL);
	reference_undersides(&reference->ground, sweep, under, rest);
	/* Posts remember whole units; a stress is in single precision. */
	const double unit = 0x1p-20, error = 1e-4 * sweep->load;
	double deeper = reference_scm_vertical(&reference->ground, soil, sweep, under, rest, lower + 1.5 * unit);
	double higher = reference_scm_vertical(&reference->ground, soil, sweep, under, rest, lower - 1.5 * unit);
	if (!(deeper >= sweep->load - error && higher <= sweep->load + error))
		fail_msg("%s, body %d, %g N: lowered by %.9g m, where the reference bears %.9g to %.9g N", kind, (int)sweep->shape->kind,
			 sweep->load, lower, higher, deeper);
	for (size_t i = 0; i < count; i++)
		if (rest[i] < INFINITY && !reference->ground.hole[i])
			top = support_least(top, rest[i] - reference->ground.base[i]);
	for (int k = 1; k < STEPS; k++) {
		double share = (double)k / STEPS, above = (lower - top) * share * share, at = lower - above;
		if (reference_scm_vertical(&reference->ground, soil, sweep, under, rest, at) >= sweep->load * 1.0001)
			seen->least = support_most(seen->least, above);
	}
	mem_free(under);
	mem_free(rest);
}

static void run(int kind, int b, int p, double load, double spacing, struct seen *seen)
{
	struct bed_params params = bed_scm(POSTS, POSTS, spacing, soil_of(kind));
	const struct soil_shape *shape = &bodies[b];
	const struct place *place = &places[p];
	const double reach = soil_shape_reach(shape, 0, 0);
	params.ground = place->ground;
	void *bed = bed_gpu.make(&params), *reference = bed_reference.make(&params);
	struct deform_contact sweep = {.shape = shape, .load = load, .tag = 1};
	sweep.from = sweep.to = bed_pose(place->x, place->y, reach - 0.01, spacing);
	struct bed_gpu *gpu = bed;
	struct deform_forces got = ground_forces(&gpu->ground, &sweep);
	if (got.state == DEFORM_SUNK) {
		seen->skipped++;
	} else {
		seen->carried++;
		assert_true(fabs(got.force[2] / load - 1) <= 0.005);
		compare(&sweep, reference, lattice_offset_metres(sweep.to.z - got.z), kinds[kind], seen);
	}
	bed_gpu.destroy(bed);
	bed_reference.destroy(reference);
}

static void the_reference_carries_it_there_and_nowhere_above(void **state)
{
	static const double loads[] = {0.5, 30, 1500, 60000};
	struct seen seen = {.carried = 0};
	(void)state;
	need_gpu();
	for (int kind = 0; kind < KINDS; kind++)
		for (int b = 0; b < BODIES; b++)
			for (int p = 0; p < PLACES; p++)
				for (int l = 0; l < 4; l++)
					if (by_turn((size_t)(kind + b + p + l), 2))
						run(kind, b, p, loads[l], (kind + l) % 2 == 0 ? 0.02 : 0.03, &seen);
	print_message("%d carried, %d not; carried at most %.3g m higher\n", seen.carried, seen.skipped, seen.least);
	assert_true(seen.carried > (long_run() ? 150 : 60));
	assert_true(seen.least <= 1.5 * 0x1p-20); /* heights are whole units */
}

TEST_PROGRAM(load_hard)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_reference_carries_it_there_and_nowhere_above),
	};
	return cmocka_run_group_tests_name("deform/load_hard", tests, open_gpu, close_gpu);
}
