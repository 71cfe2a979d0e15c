/*
 * Bodies that turn on the spot. A body that yaws is sheared over its whole way, since no part of it rolls off the soil: its moment becomes that of Coulomb's
 * stress. A wheel that spins reaches Coulomb's limit, and digs. Probes tell the same.
 */
#include "bed.h"
#include "../support/program.h"

#define SPACING 0.015625
#define SIDE 128
#define MIDDLE (SIDE / 2 * SPACING)

/* Turns a body by `angle` about an axis (0 .. 2: east, north, up), in so many steps, under its load. Returns the last forces. */
static struct soil_forces turned(struct bed *bed, const struct soil_shape *shape, struct bed_state *now, int axis, double angle, int steps, double load)
{
	struct soil_forces forces = {.area = 0};
	const bool wheel_spins = shape->kind == SOIL_WHEEL && axis < 2;
	for (int i = 0; i < steps; i++) {
		const struct bed_state before = *now;
		double rotated[3] = {0};
		rotated[axis] = angle / steps;
		if (!wheel_spins)
			bed_turn(now, axis, rotated[axis]);
		struct soil_motion motion = bed_motion(shape, &before, now, rotated);
		if (shape->kind == SOIL_WHEEL && !wheel_spins)
			motion.turned = 0;
		motion.load = load;
		const struct soil_imprint imprint = bed_press(bed, &motion, 0);
		forces = imprint.forces;
		now->at[2] += ldexp(imprint.raised, -OFFSET_BITS);
		/* The same by a probe there. */
		motion = bed_motion(shape, now, now, NULL);
		assert_true(bed_probe(bed, &motion).force[2] > 0);
	}
	return forces;
}

static struct bed_state set_down(struct bed *bed, const struct soil_shape *shape, double reach, double load)
{
	struct bed_state now = bed_state(MIDDLE + 0.0043, MIDDLE + 0.0021, bed->height + reach, 0, 0, 0);
	struct soil_motion motion = bed_motion(shape, &now, &now, NULL);
	motion.load = load;
	now.at[2] += ldexp(bed_press(bed, &motion, -10000).raised, -OFFSET_BITS);
	return now;
}

static void a_wheel_that_yaws_is_scrubbed_by_coulombs_stress(void **state)
{
	static const char *const soils[] = {"dry_sand", "sandy_loam_15", "lunar"};
	static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.25, .width = 0.2};
	const double load = 1000;
	for (size_t n = 0; n < COUNT(soils); n++) {
		struct bed bed;
		const struct soil_numbers soil = bed_soil(soils[n]);
		bed_init(&bed, &soil, SPACING, SIDE, 0, 0);
		struct bed_state now = set_down(&bed, &wheel, 0.25, load);
		const struct soil_forces early = turned(&bed, &wheel, &now, 2, 15 * DEGREES, 30, load), forces = turned(&bed, &wheel, &now, 2, 45 * DEGREES, 90, load);
		/* The stress of a wheel that sank there, with its load: its shape in plan, times what makes the sum the load. */
		const double sinks = bed.height + 0.25 - now.at[2], reach = sqrt(0.25 * 0.25 - (0.25 - sinks) * (0.25 - sinks));
		double carried = 0, area = 0, arms[2] = {0, 0};
		for (int i = 0; i < 200; i++)
			for (int k = 0; k < 200; k++) {
				const double x = reach * ((i + 0.5) / 100 - 1), y = 0.1 * ((k + 0.5) / 100 - 1), each = 2 * reach * 0.2 / 40000;
				const double p = pow(sqrt(0.25 * 0.25 - x * x) - 0.25 + sinks, soil.bekker_n);
				carried += p * each;
				area += each;
				arms[0] += p * each * hypot(x, y);
				arms[1] += each * hypot(x, y);
			}
		const double wanted = soil.cohesion * arms[1] * forces.area / area + load * arms[0] / carried * tan(soil.friction_angle);
		print_message("%s: scrub moment %.2f N m after 15 degrees, %.2f N m after 60, of Coulomb's stress %.2f N m, %.1f mm deep\n", soils[n], -early.moment[2],
			      -forces.moment[2], wanted, sinks * 1e3);
		assert_true(-early.moment[2] > 0.5 * wanted); /* Janosi: 1 - exp(-j / K), j about 0.2 rad times 0.08 m */
		assert_near(-forces.moment[2], wanted, 0.2 * wanted);
		bed_finish(&bed);
	}
}

static void a_peg_that_is_turned_resists_by_coulombs_stress(void **state)
{
	static const struct soil_shape peg = {.kind = SOIL_CYLINDER, .radius = 0.15, .length = 0.3};
	struct bed bed;
	const struct soil_numbers soil = bed_soil("dry_sand");
	bed_init(&bed, &soil, SPACING, SIDE, 0, 0);
	struct bed_state now = set_down(&bed, &peg, 0.15, 1000);
	const struct soil_forces early = turned(&bed, &peg, &now, 2, 15 * DEGREES, 30, 1000), forces = turned(&bed, &peg, &now, 2, 45 * DEGREES, 90, 1000);
	const double area = M_PI * 0.15 * 0.15, wanted = 2.0 / 3 * 0.15 * (soil.cohesion * area + 1000 * tan(soil.friction_angle));
	print_message("peg: moment %.2f N m after 15 degrees, %.2f N m after 60, of Coulomb's stress %.2f N m\n", -early.moment[2], -forces.moment[2], wanted);
	assert_true(-early.moment[2] > 0.6 * wanted);
	assert_near(-forces.moment[2], wanted, 0.05 * wanted);
	bed_finish(&bed);
}

static void a_wheel_that_spins_reaches_coulombs_limit_and_digs(void **state)
{
	static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.25, .width = 0.2};
	const double load = 1000;
	struct bed bed;
	const struct soil_numbers soil = bed_soil("dry_sand");
	for (int digs = 0; digs < 2; digs++) {
		bed_init(&bed, &soil, SPACING, SIDE, 0, 0);
		bed.law.slip_sinkage = digs ? 1.35 : 0;
		struct bed_state now = set_down(&bed, &wheel, 0.25, load);
		const double before = now.at[2];
		const struct soil_forces forces = turned(&bed, &wheel, &now, 1, 40, 800, load);
		const double limit = soil.cohesion * forces.area + load * tan(soil.friction_angle);
		print_message("slip_sinkage %g: torque %.1f N m at radius 0.25 m, Coulomb's limit %.1f N m; sank by %.1f mm\n", bed.law.slip_sinkage, -forces.moment[1],
			      0.25 * limit, (before - now.at[2]) * 1e3);
		assert_true(-forces.moment[1] > 0.9 * 0.25 * limit && -forces.moment[1] < 1.25 * 0.25 * limit);
		assert_true(digs ? before - now.at[2] > 0.01 : before - now.at[2] < 0.03);
		bed_finish(&bed);
	}
}

TEST_PROGRAM(turning)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_wheel_that_yaws_is_scrubbed_by_coulombs_stress),
		cmocka_unit_test(a_peg_that_is_turned_resists_by_coulombs_stress),
		cmocka_unit_test(a_wheel_that_spins_reaches_coulombs_limit_and_digs),
	};
	return cmocka_run_group_tests_name("soil/turning", tests, NULL, NULL);
}
