/*
 * A body on a vertical guide: the soil's whole vertical force is the load, on any slope, in any direction and at any speed. And
 * what is left along the slope is what the soil's shear does not hold.
 */
#include "bed.h"
#include "../support/program.h"

enum { POSTS = 160, STATIONS = 6 };

static const char *const soils[] = {"dry_sand", "sandy_loam_15", "sandy_loam_22", "clayey_38", "heavy_clay_25", "heavy_clay_40",
				    "lean_clay_22", "lete_sand", "upland_loam_51", "snow_us", "snow_sweden", "lunar"};
enum { SOILS = sizeof soils / sizeof *soils };

static double rise_x, rise_y; /* a post */

static int32_t plane_height(int64_t x, int64_t y)
{
	return (int32_t)lattice_base(rise_x * (double)(x - POSTS / 2) + rise_y * (double)(y - POSTS / 2));
}

struct drive {
	const struct soil_shape *shape;
	struct soil_numbers soil;
	double load, slope, up, yaw, slip, spacing; /* up: the slope's direction, rad */
	double bulldozing;
	struct soil_interface interface;
};

/* Rolls on along its yaw; the forces of its last station. */
static struct deform_forces drive(const struct drive *of, struct ground *ground)
{
	const double reach = soil_shape_reach(of->shape, 0, 0);
	struct deform_forces forces = {.z = 0};
	rise_x = tan(of->slope) * cos(of->up) * of->spacing;
	rise_y = tan(of->slope) * sin(of->up) * of->spacing;
	ground_init(ground, &(struct ground_params){.cells = POSTS / 2, .tiles = 2, .first = 0, .spacing = of->spacing, .height = plane_height, .soils = &of->soil,
						    .bulldozing = of->bulldozing});
	struct deform_contact sweep = {.shape = of->shape, .interface = of->interface, .load = of->load};
	for (int i = 0; i < STATIONS; i++) {
		double x = POSTS / 2 + 0.3 + i * cos(of->yaw), y = POSTS / 2 + 0.4 + i * sin(of->yaw);
		double z = (x - POSTS / 2) * rise_x + (y - POSTS / 2) * rise_y + reach;
		struct soil_pose pose = ground_pose(ground, x, y, z);
		pose.yaw = of->yaw;
		sweep.from = i == 0 ? pose : sweep.to;
		sweep.to = pose;
		if (of->shape->kind == SOIL_WHEEL && i > 0)
			sweep.turned = of->spacing / (of->shape->radius * (1 - of->slip));
		forces = ground_forces(ground, &sweep);
	}
	return forces;
}

static const struct soil_shape bodies[] = {
	{.kind = SOIL_WHEEL, .radius = 0.32, .width = 0.24},
	{.kind = SOIL_BOX, .size = {0.5, 0.4, 0.4}},
	{.kind = SOIL_SPHERE, .radius = 0.4},
};

static void the_soil_s_vertical_force_is_the_load(void **state)
{
	static const double loads[] = {1, 10, 100, 1000, 10000, 50000}, spacings[] = {0.02, 0.01, 0.04};
	double worst = 0;
	int carried = 0, sunk = 0;
	for (int s = 0; s < SOILS; s++)
		for (int l = 0; l < 6; l++)
			for (int k = 0; k < 3; k++) {
				struct soil_numbers soil = bed_soil(soils[s]);
				/* Each soil and load meets each body, and each of the others in turn. */
				double most = soil.friction_angle - 5 * RADIANS, share = (s + l + k) % 4 / 3.0;
				struct drive of = {
					.shape = &bodies[k], .soil = soil, .load = loads[l], .slope = fmax(most, 0) * share,
					.up = (s + 2 * l) % 8 * 45 * RADIANS, .yaw = (l + k) % 5 * 22.5 * RADIANS,
					.slip = 0.3 * ((l + k) % 3 - 1),
					.spacing = spacings[(s + l) % 3], .bulldozing = k == 0 ? 0.5 : 0,
				};
				struct ground ground;
				struct deform_forces forces = drive(&of, &ground);
				ground_finish(&ground);
				if (forces.state == DEFORM_SUNK) {
					sunk++;
					continue;
				}
				carried++;
				assert_int_equal(forces.state, DEFORM_TOUCHING);
				worst = support_most(worst, fabs(forces.force[2] / of.load - 1));
				if (!(fabs(forces.force[2] / of.load - 1) <= 0.005))
					fail_msg("%s, body %d, %g N on %.1f degrees: %.9g N", soils[s], k, of.load, of.slope / RADIANS, forces.force[2]);
			}
	print_message("%d carried, %d sunk; fz is off by %.4f %% at most\n", carried, sunk, worst * 100);
	assert_true(carried > 180);
}

/* Surfaces half as strong as the soil. */
static void the_load_is_balanced_by_weak_surfaces_too(void **state)
{
	int slid = 0;
	for (int s = 0; s < SOILS; s++)
		for (int k = 0; k < 3; k++) {
			struct drive of = {
				.shape = &bodies[k], .soil = bed_soil(soils[s]), .load = k == 1 ? 3000 : 1000, .up = (s + k) % 8 * 45 * RADIANS,
				.yaw = (s + k) % 5 * 22.5 * RADIANS, .slip = 0.3 * (s % 3 - 1), .spacing = 0.02, .bulldozing = k == 0 ? 0.5 : 0,
			};
			of.slope = fmax(of.soil.friction_angle - 5 * RADIANS, 0) * (k + s % 2) / 3;
			of.interface = (struct soil_interface){true, s % 3 > 0, of.soil.friction_angle / 2, of.soil.cohesion / 2};
			struct ground ground;
			struct deform_forces forces = drive(&of, &ground);
			ground_finish(&ground);
			if (forces.state == DEFORM_SUNK)
				continue;
			if (!(fabs(forces.force[2] / of.load - 1) <= 0.005))
				fail_msg("%s, body %d on %.1f degrees: %.9g N", soils[s], k, of.slope / RADIANS, forces.force[2]);
			const double pressed = of.load * cos(of.slope) / forces.area, sticks = s % 3 > 0 ? of.soil.cohesion / 2 : reference_adhesion(of.soil.cohesion);
			double adhesion = forces.area * sticks * fmin(pressed / of.soil.cohesion, 1), friction = tan(of.interface.friction_angle);
			double holds = adhesion + of.load * cos(of.slope) * friction, along = of.load * sin(of.slope);
			slid += forces.state == DEFORM_SLIDES;
			if (fabs(along / holds - 1) > 0.02)
				assert_int_equal(forces.state, along > holds ? DEFORM_SLIDES : DEFORM_TOUCHING);
			/* The box's underside is level: all that is level is shear. */
			if (k == 1)
				assert_true(hypot(forces.force[0], forces.force[1]) <= 1.001 * (adhesion + of.load * friction));
		}
	assert_true(slid > 5);
}

/* Soil without cohesion holds a body up to its angle of friction. */
static void the_state_says_where_the_soil_cannot_hold_it(void **state)
{
	static const double beyond[] = {-12, -5, -1, 1, 5, 12}; /* degrees */
	for (int s = 0; s < SOILS; s++)
		for (size_t i = 0; i < sizeof beyond / sizeof *beyond; i++) {
			struct drive of = {.shape = &bodies[i % 2], .soil = bed_soil(soils[s]), .load = 3000, .spacing = 0.02,
					   .up = 22.5 * RADIANS * (double)i};
			of.soil.cohesion = 0;
			of.slope = of.soil.friction_angle + beyond[i] * RADIANS;
			if (of.slope < 0)
				continue;
			struct ground ground;
			struct deform_tally tally;
			struct deform_forces forces = drive(&of, &ground);
			bearing_tally(ground.bearing, &tally);
			ground_finish(&ground);
			if (forces.state == DEFORM_SUNK)
				continue;
			assert_int_equal(forces.state, beyond[i] > 0 ? DEFORM_SLIDES : DEFORM_TOUCHING);
			assert_int_equal(tally.slid + tally.sunk, beyond[i] > 0 ? STATIONS : tally.sunk);
		}
}

/* Of the soil and the surface the weaker one decides: friction alone; and cohesive soil that does not stick. */
static void the_state_is_of_the_surface_where_that_is_weaker(void **state)
{
	static const double beyond[] = {-4, -1, 1, 4}, other[] = {-8, 10}; /* degrees */
	for (int s = 0; s < SOILS; s++)
		for (int i = 0; i < 4 * 3; i++) {
			struct drive of = {.shape = &bodies[i % 2], .soil = bed_soil(soils[s]), .load = 3000, .spacing = 0.02, .up = 22.5 * RADIANS * i};
			double friction = of.soil.friction_angle;
			if (i < 8) {
				of.soil.cohesion = 0;
				of.interface = (struct soil_interface){.has_friction = true, .friction_angle = friction + other[i / 4] * RADIANS};
				friction = support_least(friction, of.interface.friction_angle);
			} else {
				of.interface.has_adhesion = true;
			}
			of.slope = friction + beyond[i % 4] * RADIANS;
			if (of.slope < 0 || friction < 0)
				continue;
			struct ground ground;
			struct deform_forces forces = drive(&of, &ground);
			ground_finish(&ground);
			if (forces.state != DEFORM_SUNK)
				assert_int_equal(forces.state, beyond[i % 4] > 0 ? DEFORM_SLIDES : DEFORM_TOUCHING);
		}
}

TEST_PROGRAM(incline)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_load_is_balanced_by_weak_surfaces_too),
		cmocka_unit_test(the_state_is_of_the_surface_where_that_is_weaker),
		cmocka_unit_test(the_soil_s_vertical_force_is_the_load),
		cmocka_unit_test(the_state_says_where_the_soil_cannot_hold_it),
	};
	return cmocka_run_group_tests_name("validation/incline", tests, NULL, NULL);
}
