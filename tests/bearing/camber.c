/* Wheels that lean, under scm: beside an integral over the wheel's surface, from no camber to much, and to both sides. */
#include "ground.h"
#include "../support/program.h"

#include <stdlib.h>

#define FAR_BACK 0.32 /* m: after this way nothing is left below the wheel of where it was set down */

/* How the wheel came where it is. turned: rim's way a way of the axle; 0: it was set down. */
static const struct {
	const char *name;
	double turned;
} motions[] = {{"set down", 0}, {"rolls", 1}, {"driven", 1.25}};

static const char *const soils[] = {"dry_sand", "lunar", "clayey_38"};

static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2};
static const double cambers[] = {0, 0.05, 0.2, 1, 3, 9, 23}, spacings[] = {0.02, 0.01}, yaws[] = {0, 0.7, 2.1};


/* The wheel stands at a post (x, y) with its lowest place `sinkage` below the ground, and goes on as the motion says. Returns the forces at
 * the end, in its frame. */
static struct deform_forces forces_at(struct ground *ground, const double place[2], double yaw, double camber, double sinkage, double turned)
{
	const double spacing = ground->params.spacing;
	struct deform_contact contact = {.shape = &wheel};
	ground_reset(ground);
	contact.to = ground_pose(ground, place[0], place[1], soil_shape_reach(&wheel, 0, camber) - sinkage);
	contact.to.yaw = yaw;
	contact.to.roll = camber;
	contact.from = contact.to;
	struct deform_forces forces = ground_forces(ground, &contact);
	for (double way = 0; way < FAR_BACK && turned > 0; way += spacing) {
		ground_go(&contact, spacing * cos(yaw), spacing * sin(yaw), 0);
		contact.turned = spacing * turned / wheel.radius;
		forces = ground_forces(ground, &contact);
	}
	ground_into(yaw, forces.force);
	ground_into(yaw, forces.moment);
	return forces;
}

static void init(struct ground *ground, const struct soil_numbers *soil, double spacing)
{
	ground_init(ground, &(struct ground_params){.cells = 128, .tiles = 1, .first = 2, .spacing = spacing, .soils = soil});
}

static struct reference_wrench integral(const struct soil_numbers *soil, double camber, double sinkage, double turned)
{
	return reference_leaning(soil, &(struct reference_leaning){.radius = wheel.radius, .width = wheel.width, .camber = camber, .sinkage = sinkage,
								    .rolls = turned > 0, .turned = turned});
}

static void the_integral_of_a_level_wheel_is_the_closed_form(void **state)
{
	for (size_t s = 0; s < COUNT(soils); s++)
		for (size_t m = 1; m < COUNT(motions); m++) {
			const struct soil_numbers soil = bed_soil(soils[s]);
			const struct reference_wrench got = integral(&soil, 0, 0.02, motions[m].turned);
			const struct reference_rolling rolling = {.radius = wheel.radius, .width = wheel.width, .turned = motions[m].turned, .rebound = true,
								  .normals = REFERENCE_NORMALS_SURFACE, .follows = REFERENCE_FOLLOWS_RIM};
			const struct reference_rolling_force wanted = reference_rolling(&soil, &rolling, 0.02);
			const double within = 2e-3 * wanted.vertical;
			assert_true(fabs(got.force[0] - wanted.drawbar) < within && fabs(got.force[2] - wanted.vertical) < within);
			assert_true(fabs(got.moment[1] - wanted.moment) < within * wheel.radius && fabs(got.force[1]) < 1e-9 * wanted.vertical);
		}
}

/* The depth at which the soil carries a wheel that is set down. */
static double carries(const struct soil_numbers *soil, double camber, double load)
{
	return reference_leaning_sinkage(soil, &(struct reference_leaning){.radius = wheel.radius, .width = wheel.width, .camber = camber}, load);
}

/* The worst difference of a force or a moment, as a share of `load`. */
static double off_by(const struct deform_forces *got, const struct reference_wrench *wanted, double load)
{
	double worst = 0;
	for (int k = 0; k < 3; k++)
		worst = support_most(worst, support_most(fabs(got->force[k] - wanted->force[k]), fabs(got->moment[k] - wanted->moment[k]) / wheel.radius) / load);
	return worst;
}

static void fail_at(double camber, const char *soil, const char *motion, double spacing, const struct deform_forces *got, const struct reference_wrench *wanted)
{
	fail_msg("%g degrees, %s, %s, %g m: forces %.6g %.6g %.6g N, moments %.6g %.6g %.6g N m; integral: %.6g %.6g %.6g, %.6g %.6g %.6g", camber / DEGREES, soil,
		 motion, spacing, got->force[0], got->force[1], got->force[2], got->moment[0], got->moment[1], got->moment[2], wanted->force[0], wanted->force[1],
		 wanted->force[2], wanted->moment[0], wanted->moment[1], wanted->moment[2]);
}

/* As deep as 1500 N press it, all forces are within 3 % of the load. Up to a degree they change by no more than the integral's do, and 0.5 % of the load. */
static void forces_are_the_integral_over_the_surface(void **state)
{
	for (size_t s = 0; s < COUNT(soils); s++) {
		const struct soil_numbers soil = bed_soil(soils[s]);
		double sinkages[COUNT(cambers)];
		for (size_t i = 0; i < COUNT(cambers); i++)
			sinkages[i] = carries(&soil, cambers[i] * DEGREES, 1500);
		for (size_t p = 0; p < COUNT(spacings); p++) {
			double worst = 0, jumps = 0;
			struct ground ground;
			init(&ground, &soil, spacings[p]);
			for (size_t m = 0; m < COUNT(motions); m++) {
				const double yaw = yaws[(s + p + m) % 3], start = motions[m].turned > 0 ? FAR_BACK / 2 / spacings[p] : 0;
				const double place[2] = {64.2 - start * cos(yaw), 64.7 - start * sin(yaw)};
				struct deform_forces level = {.z = 0};
				struct reference_wrench level_wanted = {{0}, {0}};
				for (size_t i = 0; i < COUNT(cambers); i++) {
					const double camber = cambers[i] * DEGREES;
					const struct deform_forces got = forces_at(&ground, place, yaw, camber, sinkages[i], motions[m].turned);
					const struct reference_wrench wanted = integral(&soil, camber, sinkages[i], motions[m].turned);
					const double load = wanted.force[2], off = off_by(&got, &wanted, load);
					worst = support_most(worst, off);
					if (!(off <= 0.03))
						fail_at(camber, soils[s], motions[m].name, spacings[p], &got, &wanted);
					if (i == 0) {
						level = got;
						level_wanted = wanted;
					}
					for (int k = 0; k < 3 && cambers[i] <= 1; k++) {
						const double jump = fabs(got.force[k] - level.force[k]) - fabs(wanted.force[k] - level_wanted.force[k]);
						jumps = support_most(jumps, jump / load);
						if (!(jump <= 0.005 * load))
							fail_at(camber, soils[s], motions[m].name, spacings[p], &got, &wanted);
					}
				}
			}
			ground_finish(&ground);
			print_message("%s at %g m: within %.2f %% of the load; up to a degree changes exceed the integral's by %.3f %%\n", soils[s], spacings[p],
				      worst * 100, jumps * 100);
		}
	}
}

static void camber_to_the_other_side_mirrors_all_forces(void **state)
{
	static const double signs[] = {1, -1, 1, -1, 1, -1}; /* of forces forward, aside, up; of moments the other way round */
	const struct soil_numbers soil = bed_soil("dry_sand");
	struct ground ground;
	init(&ground, &soil, 0.02);
	for (size_t i = 2; i < COUNT(cambers); i += 2)
		for (size_t m = 0; m < COUNT(motions); m++) {
			const double yaw = 0.35, camber = cambers[i] * DEGREES;
			const struct deform_forces a = forces_at(&ground, (const double[]){56.2, 64.7}, yaw, camber, 0.02, motions[m].turned);
			const struct deform_forces b = forces_at(&ground, (const double[]){56.2, 63.3}, -yaw, -camber, 0.02, motions[m].turned);
			for (int k = 0; k < 3; k++) {
				assert_true(fabs(a.force[k] - signs[k] * b.force[k]) < 1e-4 * a.force[2]);
				assert_true(fabs(a.moment[k] + signs[k] * b.moment[k]) < 1e-4 * a.force[2] * wheel.radius);
			}
		}
	ground_finish(&ground);
}

static double slope; /* rise to the north */

static int32_t side_slope(int64_t x, int64_t y)
{
	(void)x;
	return (int32_t)lattice_base(slope * 0.01 * (double)y);
}

/* A wheel that stands straight on a side slope is a level wheel, turned: what its side wall bears does not count from the vertical. */
static void across_a_slope_a_wheel_that_stands_straight_on_it_is_level(void **state)
{
	static const double degrees[] = {3, 8, 15};
	const struct soil_numbers soil = bed_soil("dry_sand");
	for (size_t i = 0; i < COUNT(degrees); i++)
		for (size_t m = 0; m < COUNT(motions); m++) {
			const double leans = degrees[i] * DEGREES, s = sin(leans), c = cos(leans), x = m > 0 ? 48.2 : 64.2, y = 64.7, sinkage = 0.03;
			struct deform_contact contact = {.shape = &wheel};
			struct ground ground;
			slope = tan(leans);
			ground_init(&ground, &(struct ground_params){.cells = 128, .tiles = 1, .first = 2, .spacing = 0.01, .soils = &soil, .height = side_slope});
			contact.to = ground_pose(&ground, x, y, slope * 0.01 * y + (wheel.radius - sinkage) / c);
			contact.to.roll = leans;
			contact.from = contact.to;
			struct deform_forces got = ground_forces(&ground, &contact);
			for (double way = 0; way < FAR_BACK && m > 0; way += 0.01) {
				ground_go(&contact, 0.01, 0, 0);
				contact.turned = 0.01 * motions[m].turned / wheel.radius;
				got = ground_forces(&ground, &contact);
			}
			ground_finish(&ground);
			const struct reference_wrench wanted = integral(&soil, 0, sinkage, motions[m].turned);
			const double across[] = {got.force[0], got.force[1] * c + got.force[2] * s, got.force[2] * c - got.force[1] * s};
			for (int k = 0; k < 3; k++)
				if (!(fabs(across[k] - wanted.force[k]) < 0.01 * wanted.force[2]))
					fail_msg("%g degrees, %s: forward, along the axle, across it: %.6g %.6g %.6g N; level: %.6g %.6g %.6g", degrees[i], motions[m].name, across[0],
						 across[1], across[2], wanted.force[0], wanted.force[1], wanted.force[2]);
		}
}

/* Of the least sinkage: of the wheel's lowest place. Up to a degree it changes as the integral's does. */
static void a_loaded_wheel_sinks_as_the_integral_says(void **state)
{
	const double load = 1500;
	for (size_t s = 0; s < COUNT(soils); s++) {
		const struct soil_numbers soil = bed_soil(soils[s]);
		double level = 0, level_wanted = 0;
		struct ground ground;
		init(&ground, &soil, 0.01);
		for (size_t i = 0; i < COUNT(cambers); i++) {
			const double camber = cambers[i] * DEGREES, reach = soil_shape_reach(&wheel, 0, camber);
			struct deform_contact contact = {.shape = &wheel, .to = ground_pose(&ground, 64.2, 64.7, reach), .load = load};
			contact.to.yaw = yaws[i % 3];
			contact.to.roll = camber;
			contact.from = contact.to;
			ground_reset(&ground);
			const struct deform_forces forces = ground_forces(&ground, &contact);
			const double sinkage = reach - lattice_offset_metres(forces.z);
			const double wanted = carries(&soil, camber, load);
			if (i == 0) {
				level = sinkage;
				level_wanted = wanted;
			}
			if (!(fabs(sinkage - wanted) < 0.02 * wanted) || (cambers[i] <= 1 && !(fabs(sinkage - level) < fabs(wanted - level_wanted) + 0.005 * level)))
				fail_msg("%s, %g degrees: %.6g m; integral: %.6g m", soils[s], cambers[i], sinkage, wanted);
		}
		ground_finish(&ground);
	}
}

static void a_cylinder_that_leans_is_a_wheel_that_does_not_turn(void **state)
{
	const struct soil_shape log = {.kind = SOIL_CYLINDER, .radius = wheel.radius, .length = wheel.width};
	const struct soil_numbers soil = bed_soil("dry_sand");
	struct ground ground;
	init(&ground, &soil, 0.02);
	for (size_t i = 1; i < COUNT(cambers); i++) {
		struct deform_forces forces[2];
		for (int k = 0; k < 2; k++) {
			struct deform_contact contact = {.shape = k == 0 ? &wheel : &log};
			ground_reset(&ground);
			contact.to = ground_pose(&ground, 64.2, 64.7, soil_shape_reach(&wheel, 0, cambers[i] * DEGREES) - 0.02);
			contact.to.yaw = yaws[i % 3];
			contact.to.roll = cambers[i] * DEGREES + (k == 0 ? 0 : M_PI / 2);
			contact.from = contact.to;
			forces[k] = ground_forces(&ground, &contact);
		}
		for (int k = 0; k < 3; k++)
			assert_true(fabs(forces[0].force[k] - forces[1].force[k]) < 2e-5 * forces[0].force[2] &&
				    fabs(forces[0].moment[k] - forces[1].moment[k]) < 2e-5 * forces[0].force[2] * wheel.radius);
	}
	ground_finish(&ground);
}

TEST_PROGRAM(camber)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_integral_of_a_level_wheel_is_the_closed_form),
		cmocka_unit_test(forces_are_the_integral_over_the_surface),
		cmocka_unit_test(camber_to_the_other_side_mirrors_all_forces),
		cmocka_unit_test(across_a_slope_a_wheel_that_stands_straight_on_it_is_level),
		cmocka_unit_test(a_loaded_wheel_sinks_as_the_integral_says),
		cmocka_unit_test(a_cylinder_that_leans_is_a_wheel_that_does_not_turn),
	};
	return cmocka_run_group_tests_name("bearing/camber", tests, NULL, NULL);
}
