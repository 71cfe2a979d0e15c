/* The reference alone: its forces on bodies whose forces have closed forms, and the state of posts that a contact leaves. */
#include "reference_rig.h"
#include "../support/program.h"

/* A flat plate: every force and moment is the pressure's, the shear's, or an arm's. */
static void forces_are_those_of_a_plate(void **state)
{
	(void)state;
	struct reference_ground ground = made(30, 30, 0.1);
	struct deform_params params = with(DEFORM_SCM, "dry_sand");
	params.bulldozing = 0;
	const struct soil_numbers *soil = &params.soils[0];
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {1, 0.8, 0.6}};
	struct deform_contact sweep = {.shape = &plate, .from = at(&ground, 14.5, 14.5, 0.28), .to = at(&ground, 14.5, 14.5, 0.28)};
	struct reference_forces forces;
	swept(&ground, &params, &sweep, &forces);
	double sunk = 0.3 - lattice_offset_metres(lattice_offset(0.28)), area = 0.8, pressure = reference_bekker(soil, 0.8, sunk);
	assert_true(fabs(forces.area - area) < 1e-8 && fabs(forces.sinkage - sunk) < 1e-12);
	assert_true(fabs(forces.normal / (pressure * area) - 1) < 1e-8 && forces.force[2] == forces.normal);
	assert_true(forces.force[0] == 0 && forces.force[1] == 0);
	for (int k = 0; k < 3; k++)
		assert_true(fabs(forces.moment[k]) < 1e-6 * forces.normal);
	/* Work: the pressure over the way down, of the area. */
	assert_true(fabs(forces.work / (pressure * sunk / (soil->bekker_n + 1) * area) - 1) < 1e-9);
	/* North by a post: shear against it, with an arm of half the height. The northern row has been below it for half of the way. */
	sweep.from = sweep.to;
	sweep.to = at(&ground, 14.5, 15.5, 0.28);
	swept(&ground, &params, &sweep, &forces);
	double way = lattice_offset_metres(sweep.to.y - sweep.from.y), shear = (7 * reference_janosi(soil, pressure, way) + reference_janosi(soil, pressure, way / 2)) / 8;
	assert_true(fabs(forces.force[1] / -(shear * area) - 1) < 1e-5 && fabs(forces.force[0]) < 1e-9);
	assert_true(fabs(forces.moment[0] / (0.3 * forces.force[1]) - 1) < 1e-5); /* -z x y */
	/* Deeper in half a second: damping. */
	sweep.from = sweep.to;
	sweep.to.z -= 1 << 10;
	sweep.seconds = 0.5;
	double deeper = sunk + 1.0 / 1024;
	swept(&ground, &params, &sweep, &forces);
	assert_true(fabs(forces.normal / (reference_bekker(soil, 0.8, deeper) * area) - 1) < 1e-9);
	assert_true(fabs(forces.force[2] / (forces.normal + soil->damping / 512 * area) - 1) < 1e-9);
	/* Pressed on its eastern half only: the moment about y turns its nose, which is east, up. */
	struct reference_ground half = made(30, 30, 0.1);
	for (int i = 0; i < 900; i++)
		half.hole[i] = i % 30 < 15;
	sweep = (struct deform_contact){.shape = &plate, .from = at(&half, 14.5, 14.5, 0.28), .to = at(&half, 14.5, 14.5, 0.28)};
	swept(&half, &params, &sweep, &forces);
	assert_true(fabs(forces.area - area / 2) < 1e-3 * area && forces.moment[1] < -0.2 * forces.force[2]);
	reference_ground_finish(&half);
	reference_ground_finish(&ground);
}

/* A wheel that spins on the spot is driven forwards; one that is dragged is held back. */
static void shear_is_against_the_way_of_the_rim(void **state)
{
	(void)state;
	struct deform_params params = with(DEFORM_SCM, "dry_sand");
	struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4};
	static const double yaws[] = {0, 1, 2.5, -1.5707963267948966};
	for (int i = 0; i < 4; i++)
		for (int spins = 0; spins < 2; spins++) {
			struct reference_ground ground = made(40, 40, 0.05);
			struct deform_contact sweep = {.shape = &wheel, .from = at(&ground, 19.5, 19.5, 0.45), .to = at(&ground, 19.5, 19.5, 0.45)};
			struct reference_forces forces;
			sweep.to.yaw = sweep.from.yaw = yaws[i];
			if (spins)
				sweep.turned = 0.1;
			else
				sweep.from = at(&ground, 19.5 - cos(yaws[i]), 19.5 - sin(yaws[i]), 0.45);
			swept(&ground, &params, &sweep, &forces);
			double forwards = forces.force[0] * cos(yaws[i]) + forces.force[1] * sin(yaws[i]);
			double left = forces.force[1] * cos(yaws[i]) - forces.force[0] * sin(yaws[i]);
			/* The torque about its own y that the soil makes: against the turning. */
			double torque = forces.moment[1] * cos(yaws[i]) - forces.moment[0] * sin(yaws[i]);
			assert_true(spins ? forwards > 0.1 * forces.normal : forwards < -0.1 * forces.normal);
			assert_true(fabs(left) < 0.02 * forces.normal);
			if (spins)
				assert_true(torque < -0.4 * forwards);
			reference_ground_finish(&ground);
		}
}

static void a_load_is_carried_wherever_there_is_ground(void **state)
{
	(void)state;
	struct deform_params params = with(DEFORM_SCM, "lunar");
	struct soil_shape sphere = {.kind = SOIL_SPHERE, .radius = 0.3};
	struct reference_ground ground = made(20, 20, 0.05);
	struct reference_forces forces;
	struct deform_contact sweep = {.shape = &sphere, .load = 40};
	double lower;
	for (int i = 0; i < 400; i++)
		ground.base[i] = 7 + 0.05 * any_height();
	/* From above it, from within it, and from a step that goes up and down: the same place. */
	static const double heights[] = {7.4, 7.1, 9};
	double stands[3];
	for (int i = 0; i < 3; i++) {
		struct reference_ground fresh = made(20, 20, 0.05);
		memcpy(fresh.base, ground.base, 400 * sizeof *fresh.base);
		sweep.to = sweep.from = at(&ground, 9.3, 9.7, heights[i]);
		assert_int_equal(reference_sweep(&fresh, &params, &sweep, &forces, &lower), STATUS_OK);
		assert_true(fabs(forces.force[2] - 40) < 1e-6);
		stands[i] = heights[i] - lower;
		assert_true(fabs(stands[i] - stands[0]) < 3e-6);
		reference_ground_finish(&fresh);
	}
	memset(ground.hole, 1, 400);
	assert_int_equal(reference_sweep(&ground, &params, &sweep, &forces, &lower), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "40 N"));
	reference_ground_finish(&ground);
}

/* Soil that bulldozing lays beside a rut is not pressed: the next pass over it begins at its own top. */
static void heaped_soil_is_undisturbed(void **state)
{
	(void)state;
	struct deform_params params = with(DEFORM_SCM, "dry_sand");
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.4, 0.4, 1}};
	struct reference_ground ground = made(20, 20, 0.1);
	struct deform_contact sweep = {.shape = &plate, .from = at(&ground, 9.5, 9.5, 0.4), .to = at(&ground, 9.5, 9.5, 0.4)};
	struct reference_forces forces;
	params.bulldozing = 1;
	params.soils[0].repose = 80 * RADIANS;
	swept(&ground, &params, &sweep, &forces);
	/* All around it, the same to each side, and farther at the corners. */
	double plastic = 0.1 - forces.normal / forces.area / params.soils[0].elastic_stiffness;
	double all = 0;
	for (int i = 0; i < 400; i++)
		all += ground.heaped[i];
	assert_true(fabs(all - 16 * plastic) < 1e-5);
	assert_true(ground.heaped[POST(7, 9)] > 0.1 * plastic && fabs(ground.heaped[POST(7, 9)] - ground.heaped[POST(10, 12)]) < 1e-12);
	assert_true(ground.offset[POST(7, 9)] == ground.heaped[POST(7, 9)] && ground.pressed[POST(7, 9)] == 0);
	assert_true(ground.heaped[POST(9, 9)] == 0 && fabs(ground.pressed[POST(9, 9)] - 0.1) < 1e-6);
	assert_true(ground.heaped[POST(7, 7)] > ground.heaped[POST(7, 8)] && ground.heaped[POST(7, 8)] == ground.heaped[POST(8, 7)]);
	assert_true(fabs(reference_volume(&ground)) < 1e-14);
	/* Pushed a centimetre into the top of the heap. */
	double heap = ground.heaped[POST(7, 9)];
	plate.size[0] = plate.size[1] = 0.1;
	sweep.from = sweep.to = at(&ground, 7, 9, 0.5 + heap - 0.01);
	params.bulldozing = 0;
	swept(&ground, &params, &sweep, &forces);
	/* The heap beside it does not turn the normal. */
	assert_true(fabs(forces.sinkage - 0.01) < 1e-5 && fabs(ground.pressed[POST(7, 9)] - forces.sinkage) < 1e-15);
	reference_ground_finish(&ground);
}

static void what_is_pressed_and_what_is_held_is_told(void **state)
{
	(void)state;
	struct deform_params params = with(DEFORM_SLIPPAGE, "dry_sand");
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.4, 0.4, 1}};
	struct reference_ground ground = made(20, 20, 0.1);
	struct deform_contact sweep = {.shape = &plate, .from = at(&ground, 8.5, 9.5, 0.4), .to = at(&ground, 11.5, 9.5, 0.4)};
	struct reference_forces forces;
	swept(&ground, &params, &sweep, &forces);
	for (int y = 0; y < 20; y++)
		for (int x = 0; x < 20; x++) {
			bool row = y >= 8 && y <= 11;
			assert_int_equal(ground.contact[POST(x, y)], row && x >= 7 && x <= 9     ? REFERENCE_SWEPT
								     : row && x >= 10 && x <= 13 ? REFERENCE_SWEPT | REFERENCE_HELD
												 : 0);
		}
	/* Held: still the plate's underside, though beside it soil was laid down. */
	assert_true(fabs(ground.offset[POST(13, 10)] + 0.1) < 1e-6 && ground.offset[POST(14, 10)] > 0);
	reference_ground_finish(&ground);
}

/* Also beside a hole, where only one neighbour says so, and on a wall, which has a bound. */
static void stress_is_along_the_undisturbed_normal(void **state)
{
	(void)state;
	struct deform_params params = with(DEFORM_SCM, "dry_sand");
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.1, 0.1, 1}};
	struct reference_ground ground = made(20, 20, 0.1);
	struct reference_forces forces;
	params.bulldozing = params.iterations = 0;
	params.ground_normals = true;
	for (int hole = 0; hole < 2; hole++) {
		struct deform_contact sweep = {.shape = &plate, .from = at(&ground, 9, 9 + hole, 0.85), .to = at(&ground, 9, 9 + hole, 0.85)};
		for (int i = 0; i < 400; i++)
			ground.base[i] = 0.05 * (i % 20);
		ground.hole[POST(8, 10)] = hole;
		swept(&ground, &params, &sweep, &forces);
		assert_true(fabs(forces.force[0] / forces.force[2] + 0.5) < 1e-9 && fabs(forces.force[1]) < 1e-9);
		assert_true(fabs(forces.sinkage - 0.1 / sqrt(1.25)) < 1e-5);
	}
	struct deform_contact sweep = {.shape = &plate, .from = at(&ground, 10, 5, 9.5), .to = at(&ground, 10, 5, 9.5)};
	for (int i = 0; i < 400; i++)
		ground.base[i] = i % 20 < 10 ? 0 : 10;
	swept(&ground, &params, &sweep, &forces);
	assert_true(fabs(forces.sinkage - 0.05) < 1e-6);
	reference_ground_finish(&ground);
}

TEST_PROGRAM(reference_forces)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(forces_are_those_of_a_plate),
		cmocka_unit_test(shear_is_against_the_way_of_the_rim),
		cmocka_unit_test(a_load_is_carried_wherever_there_is_ground),
		cmocka_unit_test(heaped_soil_is_undisturbed),
		cmocka_unit_test(what_is_pressed_and_what_is_held_is_told),
		cmocka_unit_test(stress_is_along_the_undisturbed_normal),
	};
	return cmocka_run_group_tests_name("deform/reference_forces", tests, NULL, NULL);
}
