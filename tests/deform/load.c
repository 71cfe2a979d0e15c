/* Loads: the height found on the GPU is that at which the soil's normal force is the load, against a bisection in double. */
#include "ground.h"
#include "../support/program.h"

#define LOADS 7

static const char *const soils[] = {"dry_sand", "sandy_loam_15", "sandy_loam_22", "clayey_38", "heavy_clay_25", "heavy_clay_40",
				    "lean_clay_22", "lete_sand", "upland_loam_51", "snow_us", "snow_sweden", "lunar"};

/* A fresh flat bed of the reference, and the object's underside above it. */
struct bed {
	struct reference_ground ground;
	struct deform_contact sweep;
	double *under, *rest;
};

static void bed_init(struct bed *bed, const struct ground *ground, const struct deform_contact *sweep)
{
	int64_t count = ground->posts * ground->posts;
	bed->sweep = *sweep;
	assert_ok(reference_ground_init(&bed->ground, (int)ground->posts, (int)ground->posts, ground->params.spacing));
	bed->ground.left = bed->ground.bottom = ground->x0;
	bed->under = ground_room(count, sizeof *bed->under);
	bed->rest = ground_room(count, sizeof *bed->rest);
	reference_undersides(&bed->ground, sweep, bed->under, bed->rest);
}

static void bed_finish(struct bed *bed)
{
	reference_ground_finish(&bed->ground);
	mem_free(bed->under);
	mem_free(bed->rest);
}

/* N at a sinkage of the lowest point. */
static double force_at(const struct bed *bed, const struct soil_numbers *soil, double sinkage)
{
	double reach = soil_shape_reach(bed->sweep.shape, 0, 0), lower = sinkage - reach + lattice_offset_metres(bed->sweep.to.z);
	return reference_scm_vertical(&bed->ground, soil, &bed->sweep, bed->under, bed->rest, lower);
}

static void try_shape(const struct soil_shape *shape, double spacing)
{
	double reach = soil_shape_reach(shape, 0, 0);
	for (size_t k = 0; k < sizeof soils / sizeof *soils; k++) {
		struct ground ground;
		struct soil_numbers soil;
		assert_ok(soil_named(soils[k], &soil));
		ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 1, .first = 2, .spacing = spacing, .model = DEFORM_SCM,
							     .soils = &soil});
		/* Every other one, and those between with the next soil. */
		for (int i = (int)k % 2; i < LOADS; i += 2) {
			double load = pow(10, i);
			struct soil_pose pose = ground_pose(&ground, 32.37, 32.21, reach - soil_sinkage_guess(shape, &soil, load));
			struct deform_contact sweep = {.shape = shape, .from = pose, .to = pose, .load = load};
			struct bed bed;
			bed_init(&bed, &ground, &sweep);
			ground_reset(&ground);
			struct deform_forces forces = ground_forces(&ground, &sweep);
			double sinkage = reach - lattice_offset_metres(forces.z), quantum = 0x1p-20;
			double low = force_at(&bed, &soil, sinkage - 1.5 * quantum);
			double high = force_at(&bed, &soil, sinkage + 1.5 * quantum);
			bool carried = force_at(&bed, &soil, 2 * reach) > load;
			assert_true((forces.state == DEFORM_SUNK) == !carried);
			if (carried && !(low <= load * (1 + 1e-5) && high >= load * (1 - 1e-5)))
				fail_msg("%s, %g N: sunk %.9g m, which bears %.9g to %.9g N", soils[k], load, sinkage, low, high);
			assert_true(carried || fabs(sinkage - 2 * reach) < 1e-3); /* of its first post */
			bed_finish(&bed);
		}
		ground_finish(&ground);
	}
}

static void plates_stand_where_the_soil_carries_them(void **state)
{
	const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.6, 0.3, 0.4}};
	(void)state;
	need_gpu();
	try_shape(&plate, 0.03125);
}

static void wheels_stand_where_the_soil_carries_them(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.3};
	(void)state;
	need_gpu();
	try_shape(&wheel, 0.03125);
}

static void spheres_stand_where_the_soil_carries_them(void **state)
{
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.5};
	(void)state;
	need_gpu();
	try_shape(&ball, 0.03125);
}

static void the_guess_does_not_matter(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.3};
	struct ground ground;
	int64_t z = 0;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 2, .first = 2, .spacing = 0.03125, .model = DEFORM_SCM});
	const double guesses[] = {0.45, 0.5, 0.2, 3, -3, 400, -400};
	for (size_t i = 0; i < sizeof guesses / sizeof *guesses; i++) {
		ground_reset(&ground);
		struct soil_pose pose = ground_pose(&ground, 64.37, 64.21, guesses[i]);
		struct deform_contact sweep = {.shape = &wheel, .from = pose, .to = pose, .load = 3000};
		struct deform_forces forces = ground_forces(&ground, &sweep);
		assert_true(i == 0 || llabs(forces.z - z) <= 1);
		z = i == 0 ? forces.z : z;
	}
	ground_finish(&ground);
}

/* It stands on what it left itself: no deeper, as often as it stands there. */
static void a_wheel_that_stands_again_stands_as_high(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.3};
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 2, .first = 2, .spacing = 0.03125, .model = DEFORM_SCM});
	struct soil_pose pose = ground_pose(&ground, 64.37, 64.21, 0.45);
	struct deform_contact sweep = {.shape = &wheel, .from = pose, .to = pose, .load = 3000};
	int64_t z = ground_forces(&ground, &sweep).z;
	for (int i = 0; i < 20; i++)
		assert_true(llabs(ground_forces(&ground, &sweep).z - z) <= 1);
	ground_finish(&ground);
}

static void an_object_over_nothing_stays_where_it_is(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.3};
	struct ground ground;
	struct deform_tally tally;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 2, .first = 0, .spacing = 0.03125, .model = DEFORM_SCM});
	/* Its rim reaches over the world's edge, itself not. */
	struct soil_pose pose = ground_pose(&ground, -17, 64, 0.45);
	struct deform_contact sweep = {.shape = &wheel, .from = pose, .to = pose, .load = 3000};
	struct deform_forces forces = ground_forces(&ground, &sweep);
	assert_true(forces.z == pose.z && forces.force[2] == 0 && forces.area == 0 && forces.state == DEFORM_AIR);
	assert_ok(deform_tally(ground.deform, &tally));
	assert_int_equal(tally.compacted, 0);
	ground_finish(&ground);
}

/* The intervals that follow a press of one wheel; `at`: where it is said to stand. */
static int32_t *slid_on(const struct soil_numbers *soil, const struct deform_contact *sweep, const struct deform_rest *at, bool told)
{
	struct ground ground;
	ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 2, .spacing = 0.03125, .model = DEFORM_SCM, .bulldozing = 1,
						     .soils = soil, .iterations = 2, .loaded_bodies = 2});
	struct deform_forces forces = ground_forces(&ground, sweep);
	if (told) /* as after a resume */
		deform_set_equilibrium(ground.deform, 2, (int32_t)(forces.z - sweep->to.z));
	struct deform_rest rest = *at;
	if (at->loaded_body == 0)
		rest.pose.z = forces.z;
	assert_ok(deform_wake(ground.deform, ground.windows[0].write));
	for (int n = 0; n < 12; n++) {
		ground_interval(&ground, &rest, 1);
	}
	int32_t *offsets = ground_plane(&ground, PLANE_OFFSET);
	ground_finish(&ground);
	return offsets;
}

/* What holds the soil meanwhile is the wheel as the soil carries it, not as it was guessed to stand. */
static void the_ground_slides_around_where_it_stands(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.3};
	const size_t bytes = 129 * 129 * sizeof(int32_t);
	struct soil_numbers soil;
	(void)state;
	need_gpu();
	assert_ok(soil_named("dry_sand", &soil));
	soil.repose = 0.1;
	for (int i = 0; i < 2; i++) {
		struct soil_pose pose = {.x = lattice_offset(64.37 * 0.03125), .y = lattice_offset(64.21 * 0.03125),
					 .z = lattice_offset(i == 0 ? 0.55 : 0.2)};
		struct deform_contact sweep = {.shape = &wheel, .from = pose, .to = pose, .load = 6000, .loaded_body = 1};
		int32_t *where = slid_on(&soil, &sweep, &(struct deform_rest){&wheel, pose, 0}, false);
		int32_t *found = slid_on(&soil, &sweep, &(struct deform_rest){&wheel, pose, 1}, false);
		int32_t *resumed = slid_on(&soil, &sweep, &(struct deform_rest){&wheel, pose, 2}, true);
		int32_t *guessed = slid_on(&soil, &sweep, &(struct deform_rest){&wheel, pose, 2}, false);
		assert_memory_equal(found, where, bytes);
		assert_memory_equal(resumed, where, bytes);
		assert_memory_not_equal(guessed, where, bytes);
		mem_free(where);
		mem_free(found);
		mem_free(resumed);
		mem_free(guessed);
	}
}

TEST_PROGRAM(load)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(plates_stand_where_the_soil_carries_them),
		cmocka_unit_test(wheels_stand_where_the_soil_carries_them),
		cmocka_unit_test(spheres_stand_where_the_soil_carries_them),
		cmocka_unit_test(the_guess_does_not_matter),
		cmocka_unit_test(a_wheel_that_stands_again_stands_as_high),
		cmocka_unit_test(the_ground_slides_around_where_it_stands),
		cmocka_unit_test(an_object_over_nothing_stays_where_it_is),
	};
	return cmocka_run_group_tests_name("deform/load", tests, open_gpu, close_gpu);
}
