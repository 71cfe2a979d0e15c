/*
 * Light bodies: soil holds a body by no more than its load and friction, however well it sticks. heavy_clay_25 has a cohesion of 69 kPa: with all of it a
 * wheel of 1 N pulled 14 N. And numbers at their ends: no friction, no cohesion, steep friction, loads from 1 N to 1 MN.
 */
#include "ground.h"

#include "../support/near.h"
#include "../support/program.h"

#define DEGREES (M_PI / 180)

static const char *const soils[] = {"dry_sand", "sandy_loam_15", "sandy_loam_22", "clayey_38", "heavy_clay_25", "heavy_clay_40",
				    "lean_clay_22", "lete_sand", "upland_loam_51", "snow_us", "snow_sweden", "lunar"};
static const struct soil_shape bodies[] = {
	{.kind = SOIL_WHEEL, .radius = 0.25, .width = 0.2}, {.kind = SOIL_BOX, .size = {0.3, 0.2, 0.1}}, {.kind = SOIL_SPHERE, .radius = 0.15},
	{.kind = SOIL_CYLINDER, .radius = 0.12, .length = 0.3},
};

/* A body goes 0.3 m under its load, a wheel with a slip of 0.5. Returns its forces at the end. */
static struct deform_forces goes(const struct soil_shape *shape, const struct soil_numbers *soil, const struct soil_interface *surface, double load, double spacing)
{
	struct ground ground;
	ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 3, .first = 1, .spacing = spacing, .soils = soil});
	struct deform_contact sweep = {.shape = shape, .interface = *surface, .load = load};
	struct deform_forces forces = {.z = 0};
	const int steps = 20;
	for (int step = 0; step <= steps; step++) {
		const struct soil_pose pose = ground_pose(&ground, 96.5 + 0.3 / spacing * step / steps, 96.5, soil_shape_reach(shape, 0, 0));
		sweep.from = step == 0 ? pose : sweep.to;
		sweep.to = pose;
		sweep.turned = step > 0 && shape->kind == SOIL_WHEEL ? 0.3 / steps / shape->radius / 0.5 : 0;
		forces = ground_forces(&ground, &sweep);
	}
	ground_finish(&ground);
	return forces;
}

static void a_load_of_a_newton_is_held_by_no_more_than_that(void **state)
{
	static const double spacings[] = {0.04, 0.02, 0.01};
	const struct soil_interface none = {.has_friction = false};
	double most = 0;
	for (size_t s = 0; s < COUNT(soils); s++)
		for (size_t p = 0; p < COUNT(spacings); p++)
			for (size_t b = 0; b < COUNT(bodies); b++) {
				const struct soil_numbers soil = bed_soil(soils[s]);
				const struct deform_forces forces = goes(&bodies[b], &soil, &none, 1, spacings[p]);
				const double holds = hypot(forces.force[0], forces.force[1]) / forces.force[2];
				most = support_most(most, holds);
				if (!(holds <= 1.05 * (1 + tan(soil.friction_angle))) || !isfinite(forces.force[2]) || getenv("LIGHT_TRACE") != NULL)
					print_message("%s, body %d, %g m: %.4f N along, %.4f N up\n", soils[s], bodies[b].kind, spacings[p], forces.force[0], forces.force[2]);
				assert_true(holds <= 1.05 * (1 + tan(soil.friction_angle)));
			}
	print_message("at most %.3f of the load\n", most);
}

/* Strong surfaces hold no more than the soil; the force along is at most the strength, and what is carried is the load. */
static void numbers_at_their_ends_give_forces_within_the_strength(void **state)
{
	static const double cohesions[] = {0, 1e-3, 1e3, 1e6}, angles[] = {0, 30, 50, 80}, loads[] = {1, 100, 1e4, 1e6};
	const struct soil_interface surfaces[] = {{.has_friction = false}, {true, true, 89 * DEGREES, 1e9}, {true, true, 0, 0}, {.has_adhesion = true, .adhesion = 1e6}};
	int carried = 0;
	for (size_t i = 0; i < COUNT(cohesions) * COUNT(angles) * COUNT(loads); i++)
		for (size_t k = 0; k < COUNT(surfaces); k++) {
			struct soil_numbers soil = bed_soil("dry_sand");
			const struct soil_shape *shape = &bodies[(i + k) % 2];
			const double load = loads[i / 16];
			soil.cohesion = cohesions[i % 4];
			soil.friction_angle = angles[i / 4 % 4] * DEGREES;
			const struct deform_forces forces = goes(shape, &soil, &surfaces[k], load, 0.02);
			if (forces.state == DEFORM_SUNK)
				continue;
			carried++;
			/* Normal and shear act along the surface: its normal force is at most what both make. */
			const double along = hypot(forces.force[0], forces.force[1]), up = forces.force[2];
			for (int c = 0; c < 3; c++)
				assert_true(isfinite(forces.force[c]) && isfinite(forces.moment[c]));
			if (shape->kind == SOIL_BOX && k < 2) {
				const double holds = up * tan(soil.friction_angle) + fmin(forces.area * soil.cohesion, up);
				if (!(along <= 1.001 * holds + 1e-9))
					fail_msg("c %g Pa, %g degrees, %g N, surface %zu: %g N along, holds %g", soil.cohesion, soil.friction_angle / DEGREES, load, k, along, holds);
			}
			if (shape->kind == SOIL_BOX && k == 2)
				assert_true(along <= 1e-6 * up);
		}
	print_message("%d of 256 are carried\n", carried);
	assert_true(carried > 128);
}

TEST_PROGRAM(light)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_load_of_a_newton_is_held_by_no_more_than_that),
		cmocka_unit_test(numbers_at_their_ends_give_forces_within_the_strength),
	};
	return cmocka_run_group_tests_name("bearing/light", tests, NULL, NULL);
}
