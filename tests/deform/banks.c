/*
 * Objects against banks and steps: the ground of a cell may be far higher than its post. The forces, and the height at which a load is
 * carried, are held to the reference in doubles.
 */
#include "../validation/bed_gpu.h"
#include "../support/near.h"
#include "../support/program.h"

enum { POSTS = 60 };
#define SPACING 0.02

static const struct soil_shape bodies[] = {
	{.kind = SOIL_WHEEL, .radius = 0.32, .width = 0.14},
	{.kind = SOIL_SPHERE, .radius = 0.3},
	{.kind = SOIL_BOX, .size = {0.3, 0.2, 0.4}},
};
enum { BODIES = sizeof bodies / sizeof *bodies };

static double bank_slope, bank_height, bank_yaw; /* rise a metre; m; rad: towards the top */

/* Level below and above. Heights that a base holds exactly. */
static double bank(int x, int y)
{
	double along = ((x - POSTS / 2) * cos(bank_yaw) + (y - POSTS / 2) * sin(bank_yaw)) * SPACING;
	return ldexp(round(ldexp(fmin(fmax(bank_slope * along, 0), bank_height), 18)), -18);
}

/* The centre is `before` m before the bank's foot, and `above` the level below it. */
static struct deform_contact stand(const struct soil_shape *shape, double before, double above, double load)
{
	double x = POSTS / 2 + 0.3 - before * cos(bank_yaw) / SPACING, y = POSTS / 2 + 0.2 - before * sin(bank_yaw) / SPACING;
	struct deform_contact sweep = {.shape = shape, .load = load, .tag = 1};
	sweep.from = bed_pose(x, y, above, SPACING);
	sweep.from.yaw = bank_yaw;
	sweep.to = sweep.from;
	return sweep;
}

/* Set down at a height, and moved towards the bank, twice. */
static void move(const struct soil_shape *shape, double before, double above, struct bed_gpu *gpu, struct bed_reference *reference)
{
	struct deform_contact sweep = stand(shape, before, above, 0);
	for (int step = 0; step < 3; step++) {
		struct deform_forces got = ground_forces(&gpu->ground, &sweep);
		struct reference_forces wanted;
		double lower = 0, size = 0, off = 0;
		assert_int_equal(reference_sweep(&reference->ground, &reference->params, &sweep, &wanted, &lower), STATUS_OK);
		for (int k = 0; k < 3; k++) {
			size = support_most(size, fabs(wanted.force[k]));
			off = support_most(off, fabs(got.force[k] - wanted.force[k]));
		}
		if (!(off <= 1e-3 * size + 0.01))
			fail_msg("body %d, bank of %g, %g m before it, step %d: %g %g %g N, wanted %g %g %g", (int)shape->kind, bank_slope, before,
				 step, got.force[0], got.force[1], got.force[2], wanted.force[0], wanted.force[1], wanted.force[2]);
		sweep.from = sweep.to;
		/* After half a post the end of a cell is where another post was: a tie but for rounding, which a wheel must not feel. */
		double way = shape->kind == SOIL_WHEEL ? 0.5 * SPACING : 0.37 * SPACING;
		sweep.to.x += lattice_offset(way * cos(bank_yaw));
		sweep.to.y += lattice_offset(way * sin(bank_yaw));
		sweep.turned = shape->kind == SOIL_WHEEL ? 0.6 * SPACING / shape->radius : 0;
	}
}

/* Returns true if something carries the load. Then the reference does so at that height, and at none above it. */
static bool let_down(const struct soil_shape *shape, double before, double above, double load, struct bed_gpu *gpu,
		     struct bed_reference *reference)
{
	static double under[POSTS * POSTS], rest[POSTS * POSTS];
	const struct soil_numbers *soil = &reference->params.soils[0];
	struct deform_contact sweep = stand(shape, before, above, load);
	struct deform_forces got = ground_forces(&gpu->ground, &sweep);
	if (got.state == DEFORM_SUNK)
		return false;
	double lower = lattice_offset_metres(sweep.to.z - got.z), unit = 0x1p-20;
	reference_undersides(&reference->ground, &sweep, under, rest);
	double deeper = reference_scm_vertical(&reference->ground, soil, &sweep, under, rest, lower + 1.5 * unit);
	double higher = reference_scm_vertical(&reference->ground, soil, &sweep, under, rest, lower - 1.5 * unit);
	if (!(deeper >= 0.999 * load && higher <= 1.001 * load))
		fail_msg("body %d, bank of %g, %g m before it, %g N: lowered by %.9g m, where the reference bears %.9g to %.9g N", (int)shape->kind,
			 bank_slope, before, load, lower, higher, deeper);
	for (double up = 0.001; up < 0.5; up *= 1.6)
		assert_true(reference_scm_vertical(&reference->ground, soil, &sweep, under, rest, lower - up) < 1.001 * load);
	return true;
}

/* With a load: returns true if it is carried. */
static bool press(const struct soil_shape *shape, double before, double above, double load)
{
	struct bed_params params = bed_scm(POSTS, POSTS, SPACING, bed_soil("dry_sand"));
	bool carried = true;
	params.ground = bank;
	void *gpu = bed_gpu.make(&params), *reference = bed_reference.make(&params);
	if (load > 0)
		carried = let_down(shape, before, above, load, gpu, reference);
	else
		move(shape, before, above, gpu, reference);
	bed_gpu.destroy(gpu);
	bed_reference.destroy(reference);
	return carried;
}

static void presses(double slope, double height)
{
	static const double yaws[] = {0, 22.5, 200};
	int carried = 0, tried = 0;
	need_gpu();
	bank_slope = slope;
	bank_height = height;
	for (int b = 0; b < BODIES; b++)
		for (int i = 0; i < 3; i++) {
			double reach = soil_shape_reach(&bodies[b], 0, 0);
			bank_yaw = yaws[i] * RADIANS;
			for (double before = 0.02; before < 0.35; before += 0.13) {
				press(&bodies[b], before, reach + 0.02, 0);
				press(&bodies[b], before, reach - 0.01, 0);
				carried += press(&bodies[b], before, reach + 0.02, 5);
				carried += press(&bodies[b], before, reach, 800);
				tried += 2;
			}
		}
	print_message("%d of %d loads carried\n", carried, tried);
	assert_true(carried > 3 * tried / 4);
}

static void level_ground(void **state)
{
	(void)state;
	presses(0, 1);
}

static void a_bank_of_one_and_a_half(void **state)
{
	(void)state;
	presses(1.5, 0.6);
}

static void a_step_of_a_metre(void **state)
{
	(void)state;
	presses(1e6, 1);
}

TEST_PROGRAM(banks)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(level_ground),
		cmocka_unit_test(a_bank_of_one_and_a_half),
		cmocka_unit_test(a_step_of_a_metre),
	};
	return cmocka_run_group_tests_name("deform/banks", tests, open_gpu, close_gpu);
}
