/*
 * The reference by itself: that soil is neither made nor lost, what its rules say of a few posts, counted by
 * hand, and its forces on bodies whose forces are plain.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "deform/reference/reference.h"

#define RADIANS (M_PI / 180)
#define POST(x, y) ((y) * ground.width + (x))

static double any_height(void)
{
	static uint32_t state = 12345;
	state = state * 1664525 + 1013904223;
	return (double)(state >> 8) / (1 << 24);
}

static struct reference_ground made(int width, int height, double spacing)
{
	struct reference_ground ground;
	assert_int_equal(reference_ground_init(&ground, width, height, spacing), STATUS_OK);
	return ground;
}

static struct deform_params with(enum deform_model model, const char *name)
{
	struct deform_params params = {.model = model, .soil_count = 1, .iterations = 4, .depth = INFINITY, .bulldozing = 0.6};
	assert_int_equal(deform_soil_named(name, &params.soils[0]), STATUS_OK);
	if (model == DEFORM_SCM)
		params.depth = 0;
	return params;
}

static struct deform_pose at(const struct reference_ground *ground, double x, double y, double z)
{
	return (struct deform_pose){
		.x = lattice_offset(((double)ground->left + x) * ground->spacing),
		.y = lattice_offset(((double)ground->bottom + y) * ground->spacing),
		.z = lattice_offset(z),
	};
}

static void swept(struct reference_ground *ground, const struct deform_params *params, const struct deform_contact *sweep,
		  struct reference_forces *forces)
{
	double lower;
	assert_int_equal(reference_sweep(ground, params, sweep, forces, &lower), STATUS_OK);
}

/* Heights of the surface, squared: the potential energy but for factors. */
static double energy(const struct reference_ground *ground)
{
	double sum = 0;
	for (int i = 0; i < ground->width * ground->height; i++)
		sum += pow(ground->base[i] + ground->offset[i], 2);
	return sum;
}

/* Back and forth over rough ground with a hole in it. */
static void soil_is_neither_made_nor_lost(void **state)
{
	(void)state;
	static const enum deform_model models[] = {DEFORM_NONE, DEFORM_SUMNER, DEFORM_SLIPPAGE, DEFORM_SCM};
	struct deform_shape wheel = {.kind = DEFORM_WHEEL, .radius = 0.5, .width = 0.4};
	for (size_t m = 0; m < sizeof models / sizeof *models; m++) {
		struct reference_ground ground = made(48, 24, 0.1);
		struct deform_params params = with(models[m], "dry_sand");
		struct reference_forces forces;
		ground.left = 100;
		ground.bottom = 20;
		ground.hole[POST(24, 11)] = true;
		for (int i = 0; i < 48 * 24; i++)
			ground.base[i] = 0.1 * any_height();
		struct deform_contact sweep = {.shape = &wheel, .from = at(&ground, 8, 12, 0.4), .to = at(&ground, 8, 12, 0.4)};
		double lowest = 0;
		for (int i = 0; i <= 60; i++) {
			double turn = i <= 30 ? i : 60 - i;
			sweep.from = sweep.to;
			sweep.to = at(&ground, 8 + turn, 12, 0.4 - 0.002 * turn);
			sweep.turned = 0.1;
			swept(&ground, &params, &sweep, &forces);
			for (int p = 0; p < 48 * 24; p++)
				lowest = fmin(lowest, ground.offset[p]);
		}
		assert_true(lowest < -0.1);
		assert_true(fabs(reference_volume(&ground)) < 1e-12);
		assert_true(ground.offset[POST(24, 11)] == 0);
		assert_true(models[m] == DEFORM_SLIPPAGE ? ground.compacted == 0 : ground.compacted > 0.05);
		double highest = 0;
		for (int p = 0; p < 48 * 24; p++)
			highest = fmax(highest, ground.offset[p]);
		assert_true(models[m] == DEFORM_NONE ? highest == 0 : highest > 0.01);
		reference_ground_finish(&ground);
	}
}

static void what_is_lifted_goes_to_the_nearest_free_posts(void **state)
{
	(void)state;
	struct reference_ground ground = made(9, 7, 0.5);
	/* A bar three wide and five long, with its north end at a hole. */
	for (int y = 1; y <= 5; y++)
		for (int x = 3; x <= 5; x++)
			ground.contact[POST(x, y)] = REFERENCE_SWEPT;
	ground.hole[POST(4, 6)] = true;
	ground.carried[POST(4, 3)] = 1; /* two west, two east; three south; the north end is a hole */
	ground.carried[POST(4, 1)] = 2; /* one south */
	ground.carried[POST(3, 1)] = 4; /* one south, one west */
	reference_spread(&ground);
	double wanted[9 * 7] = {0};
	wanted[POST(2, 3)] = wanted[POST(6, 3)] = 0.5;
	wanted[POST(4, 0)] = 2;
	wanted[POST(3, 0)] = wanted[POST(2, 1)] = 2;
	for (int i = 0; i < 63; i++) {
		assert_true(ground.offset[i] == wanted[i] && ground.heaped[i] == wanted[i]);
		assert_true(ground.carried[i] == 0);
	}
	/* No free post in its row or column. */
	memset(ground.contact, REFERENCE_HELD, 63);
	ground.contact[POST(0, 0)] = 0;
	ground.carried[POST(4, 3)] = 3;
	reference_spread(&ground);
	assert_true(ground.confined == 0.75 && ground.compacted == 0.75);
	/* What is not written is not there. */
	memset(ground.contact, 0, 63);
	ground.written = (struct post_rect){4, 2, 8, 6};
	ground.carried[POST(4, 2)] = 1;
	double east = ground.offset[POST(5, 2)], west = ground.offset[POST(3, 2)];
	reference_spread(&ground);
	assert_true(ground.offset[POST(5, 2)] == east + 0.5 && ground.offset[POST(3, 2)] == west);
	reference_ground_finish(&ground);
}

static void an_iteration_slides_an_eighth_of_what_is_too_steep(void **state)
{
	(void)state;
	struct reference_ground ground = made(5, 5, 1);
	struct deform_params params = with(DEFORM_SCM, "dry_sand");
	double moved, steep = tan(params.soils[0].repose), spike = 4;
	/* Only what is loose may slide: all of it; then half a metre of it. */
	for (int loose = 0; loose < 2; loose++) {
		memset(ground.offset, 0, 25 * sizeof *ground.offset);
		memset(ground.heaped, 0, 25 * sizeof *ground.heaped);
		ground.offset[12] = spike;
		ground.heaped[12] = loose == 0 ? spike : 0.5;
		assert_int_equal(reference_slide(&ground, &params, 1, 0, &moved), STATUS_OK);
		double axial = fmin(spike - steep, loose == 0 ? spike : 0.5) / 8;
		double diagonal = fmin(spike - sqrt(2) * steep, loose == 0 ? spike : 0.5) / 8;
		assert_true(fabs(ground.offset[13] - axial) < 1e-15 && fabs(ground.offset[7] - axial) < 1e-15);
		assert_true(fabs(ground.offset[18] - diagonal) < 1e-15 && fabs(ground.heaped[6] - diagonal) < 1e-15);
		assert_true(ground.offset[14] == 0);
		assert_true(fabs(ground.offset[12] - (spike - 4 * axial - 4 * diagonal)) < 1e-14);
		assert_true(fabs(moved - 4 * axial - 4 * diagonal) < 1e-14);
	}
	/* What is tolerated stays, to the last bit of it; a hair more, and it slides as ever. */
	for (int more = 0; more < 2; more++) {
		memset(ground.offset, 0, 25 * sizeof *ground.offset);
		ground.offset[12] = ground.heaped[12] = steep + 0.25 + more * 1e-9;
		params.tolerance = 0.25;
		assert_int_equal(reference_slide(&ground, &params, 1, 0, &moved), STATUS_OK);
		assert_true(fabs(ground.offset[13] - more * 0.25 / 8) < 1e-9 && ground.offset[6] == 0);
	}
	params.tolerance = 0;
	memset(ground.heaped, 0, 25 * sizeof *ground.heaped);
	/* A held post neither gives nor takes, a hole and the rim take nothing. */
	memset(ground.offset, 0, 25 * sizeof *ground.offset);
	ground.offset[12] = ground.heaped[12] = spike;
	ground.contact[13] = REFERENCE_HELD;
	ground.hole[11] = true;
	ground.written = (struct post_rect){0, 2, 5, 5};
	assert_int_equal(reference_slide(&ground, &params, 1, 0, &moved), STATUS_OK);
	assert_true(ground.offset[13] == 0 && ground.offset[11] == 0 && ground.offset[7] == 0 && ground.offset[17] > 0);
	ground.contact[12] = REFERENCE_HELD;
	double before = ground.offset[12];
	assert_int_equal(reference_slide(&ground, &params, 1, 0, &moved), STATUS_OK);
	assert_true(ground.offset[12] == before);
	reference_ground_finish(&ground);
}

static void sumner_sheds_a_share_of_the_mean(void **state)
{
	(void)state;
	struct reference_ground ground = made(5, 5, 1);
	struct deform_params params = with(DEFORM_SUMNER, "mud"); /* out and stop 1.1, in 1.57, roughness 0.2 */
	double moved, steep = tan(1.1);
	/* Six neighbours 4 m lower, two 1 m lower: these are not too steep. */
	ground.offset[12] = 4;
	ground.offset[11] = ground.offset[13] = 3;
	assert_int_equal(reference_slide(&ground, &params, 1, 0, &moved), STATUS_OK);
	assert_true(4 > steep * sqrt(2) && 3 > steep && 1 < steep);
	double each = 0.2 * 4 / 6;
	assert_true(fabs(ground.offset[12] - (4 - 0.8)) < 1e-14);
	/* It takes its share; 11 and 13 shed to their own, of 3 m and of fewer neighbours on the diagonal. */
	assert_true(ground.offset[7] > each - 1e-14);
	assert_true(fabs(reference_volume(&ground) - 10) < 1e-13);
	/* Beside what is held it stands at theta_in: nearly upright. */
	memset(ground.offset, 0, 25 * sizeof *ground.offset);
	ground.offset[12] = 4;
	ground.contact[12] = REFERENCE_HELD;
	assert_int_equal(reference_slide(&ground, &params, 1, 0, &moved), STATUS_OK);
	assert_true(moved == 0);
	/* And what is steeper than theta_out but not than theta_stop rests: sand. */
	struct deform_params sand = with(DEFORM_SUMNER, "sand");
	ground.contact[12] = 0;
	ground.offset[12] = 0.7;
	assert_true(0.7 > tan(0.436) && 0.7 < tan(0.8));
	assert_int_equal(reference_slide(&ground, &sand, 1, 0, &moved), STATUS_OK);
	assert_true(moved == 0);
	ground.offset[12] = 1.1;
	assert_int_equal(reference_slide(&ground, &sand, 1, 0, &moved), STATUS_OK);
	assert_true(fabs(moved - 0.22) < 1e-14);
	/* Nor what is within a tolerance of it. */
	memset(ground.offset, 0, 25 * sizeof *ground.offset);
	ground.offset[12] = 1.1;
	sand.tolerance = 1.1 - tan(sand.soils[0].theta_stop) + 1e-9;
	assert_int_equal(reference_slide(&ground, &sand, 1, 0, &moved), STATUS_OK);
	assert_true(moved == 0);
	sand.tolerance -= 2e-9;
	assert_int_equal(reference_slide(&ground, &sand, 1, 0, &moved), STATUS_OK);
	assert_true(fabs(moved - 0.22) < 1e-14);
	reference_ground_finish(&ground);
}

static void sliding_only_ever_lowers_the_potential_energy(void **state)
{
	(void)state;
	static const struct {
		enum deform_model model;
		const char *soil;
	} cases[] = {{DEFORM_SLIPPAGE, "dry_sand"}, {DEFORM_SLIPPAGE, "clayey_38"}, {DEFORM_SUMNER, "sand"}, {DEFORM_SCM, "dry_sand"}};
	for (size_t c = 0; c < sizeof cases / sizeof *cases; c++)
		for (int spike = 0; spike < 2; spike++) {
			struct reference_ground ground = made(24, 24, 0.25);
			struct deform_params params = with(cases[c].model, cases[c].soil);
			params.depth = INFINITY;
			double moved, first = 0;
			for (int i = 0; i < 24 * 24; i++)
				ground.base[i] = spike ? (i == POST(12, 12) ? 1000 : 0) : 100 * any_height();
			for (int i = 0; i < 400; i++) {
				double before = energy(&ground);
				assert_int_equal(reference_slide(&ground, &params, 1, 0, &moved), STATUS_OK);
				assert_true(energy(&ground) <= before * (1 + 1e-15));
				first = i == 0 ? moved : first;
			}
			assert_true(first > 1 && moved < first / 2);
			assert_true(fabs(reference_volume(&ground)) < 1e-9);
			reference_ground_finish(&ground);
		}
}

/* A flat plate: every force and moment is the pressure's, the shear's, or an arm's. */
static void forces_are_those_of_a_plate(void **state)
{
	(void)state;
	struct reference_ground ground = made(30, 30, 0.1);
	struct deform_params params = with(DEFORM_SCM, "dry_sand");
	params.bulldozing = 0;
	const struct deform_soil *soil = &params.soils[0];
	struct deform_shape plate = {.kind = DEFORM_BOX, .size = {1, 0.8, 0.6}};
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
	struct deform_shape wheel = {.kind = DEFORM_WHEEL, .radius = 0.5, .width = 0.4};
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
	struct deform_shape sphere = {.kind = DEFORM_SPHERE, .radius = 0.3};
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
	struct deform_shape plate = {.kind = DEFORM_BOX, .size = {0.4, 0.4, 1}};
	struct reference_ground ground = made(20, 20, 0.1);
	struct deform_contact sweep = {.shape = &plate, .from = at(&ground, 9.5, 9.5, 0.4), .to = at(&ground, 9.5, 9.5, 0.4)};
	struct reference_forces forces;
	params.bulldozing = 1;
	params.soils[0].repose = 80 * RADIANS;
	swept(&ground, &params, &sweep, &forces);
	/* A corner's soil goes half to each of its sides; the middle's, two posts from two sides, likewise. */
	double plastic = 0.1 - forces.normal / forces.area / params.soils[0].elastic_stiffness;
	assert_true(fabs(ground.heaped[POST(7, 8)] - 0.5 * plastic) < 1e-6);
	assert_true(fabs(ground.offset[POST(7, 9)] - 1.5 * plastic) < 1e-6 && ground.pressed[POST(7, 9)] == 0);
	assert_true(ground.heaped[POST(9, 9)] == 0 && fabs(ground.pressed[POST(9, 9)] - 0.1) < 1e-6);
	assert_true(ground.heaped[POST(7, 7)] == 0);
	assert_true(fabs(reference_volume(&ground)) < 1e-14);
	/* Pushed a centimetre into the top of the heap. */
	double heap = ground.heaped[POST(7, 9)];
	plate.size[0] = plate.size[1] = 0.1;
	sweep.from = sweep.to = at(&ground, 7, 9, 0.5 + heap - 0.01);
	params.bulldozing = 0;
	swept(&ground, &params, &sweep, &forces);
	double upright = forces.sinkage / 0.01; /* of the heap's normal */
	assert_true(upright > 0.5 && upright <= 1 + 1e-4 && fabs(ground.pressed[POST(7, 9)] - forces.sinkage) < 1e-15);
	reference_ground_finish(&ground);
}

static void what_is_pressed_and_what_is_held_is_told(void **state)
{
	(void)state;
	struct deform_params params = with(DEFORM_SLIPPAGE, "dry_sand");
	struct deform_shape plate = {.kind = DEFORM_BOX, .size = {0.4, 0.4, 1}};
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
	struct deform_shape plate = {.kind = DEFORM_BOX, .size = {0.1, 0.1, 1}};
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

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(soil_is_neither_made_nor_lost),
		cmocka_unit_test(what_is_lifted_goes_to_the_nearest_free_posts),
		cmocka_unit_test(an_iteration_slides_an_eighth_of_what_is_too_steep),
		cmocka_unit_test(sumner_sheds_a_share_of_the_mean),
		cmocka_unit_test(sliding_only_ever_lowers_the_potential_energy),
		cmocka_unit_test(forces_are_those_of_a_plate),
		cmocka_unit_test(shear_is_against_the_way_of_the_rim),
		cmocka_unit_test(a_load_is_carried_wherever_there_is_ground),
		cmocka_unit_test(heaped_soil_is_undisturbed),
		cmocka_unit_test(what_is_pressed_and_what_is_held_is_told),
		cmocka_unit_test(stress_is_along_the_undisturbed_normal),
	};
	return cmocka_run_group_tests_name("deform/reference_laws", tests, NULL, NULL);
}
