/*
 * Loads: the height that a search finds is that at which the soil carries the load. Where it was found the forces at fixed heights around it are asked
 * (bearing_feel), and there is no height above it at which the soil carries as much. Also where the search is hard: stiff soil, tiny and huge loads, an
 * exponent near 0, banks and steps, a body half over nothing.
 */
#include "ground.h"

#include "../long.h"
#include "../support/program.h"

enum { POSTS = 64 };

static const char *const soils[] = {"dry_sand", "sandy_loam_15", "sandy_loam_22", "clayey_38", "heavy_clay_25", "heavy_clay_40",
				    "lean_clay_22", "lete_sand", "upland_loam_51", "snow_us", "snow_sweden", "lunar"};

static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.3};

static void init(struct ground *ground, const struct soil_numbers *soil, double spacing, int32_t (*height)(int64_t x, int64_t y))
{
	ground_init(ground, &(struct ground_params){.cells = POSTS, .tiles = 1, .spacing = spacing, .soils = soil, .height = height});
}

/* The vertical force on a body that is set down `raised` fixed-point units above a contact's pose. Changes nothing. */
static double force_at(struct ground *ground, const struct deform_contact *contact, int64_t raised)
{
	struct deform_contact fixed = *contact;
	struct bearing_contact felt = {.contact = &fixed, .feels = true};
	fixed.load = 0;
	fixed.from.z = fixed.to.z = contact->to.z + raised;
	assert_ok(bearing_area(ground->bearing, &fixed, &felt.area));
	assert_ok(bearing_contact_alone(ground->bearing, &felt, ground->tiles, ground->tile_count));
	return felt.forces.force[2];
}

/* Lets a body down on fresh ground. Returns true if the soil carries it. */
static bool let_down(struct ground *ground, const struct deform_contact *contact, const char *soil, double *above)
{
	enum { STEPS = 100 };
	const int64_t unit = 2, top = lattice_offset(2.5);
	ground_reset(ground);
	const struct deform_forces forces = ground_forces(ground, contact);
	ground_reset(ground);
	if (forces.state == DEFORM_SUNK)
		return false;
	const int64_t raised = forces.z - contact->to.z;
	const double load = contact->load, low = force_at(ground, contact, raised + unit), high = force_at(ground, contact, raised - unit);
	assert_near(forces.force[2], load, 0.005 * load); /* heights are whole units */
	if (!(low <= load * (1 + 1e-5) && high >= load * (1 - 1e-5)))
		fail_msg("%s, body %d, %g N: found %.9g m above its pose, where the soil bears %.9g to %.9g N", soil, (int)contact->shape->kind, load,
			 lattice_offset_metres(raised), low, high);
	for (int k = 1; k < STEPS; k++) {
		const double share = (double)k / STEPS;
		const int64_t at = raised + (int64_t)((double)top * share * share);
		if (force_at(ground, contact, at) >= 1.0001 * load)
			*above = support_most(*above, lattice_offset_metres(at - raised));
	}
	return true;
}

static void bodies_rest_where_the_soil_carries_them(void **state)
{
	static const struct soil_shape shapes[] = {
		{.kind = SOIL_BOX, .size = {0.6, 0.3, 0.4}}, {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.3}, {.kind = SOIL_SPHERE, .radius = 0.5},
	};
	int carried = 0, sunk = 0;
	double above = 0;
	for (size_t s = 0; s < COUNT(shapes); s++)
		for (size_t k = 0; k < COUNT(soils); k++) {
			const struct soil_numbers soil = bed_soil(soils[k]);
			const double reach = soil_shape_reach(&shapes[s], 0, 0);
			struct ground ground;
			init(&ground, &soil, 0.03125, NULL);
			for (int i = 0; i < 7; i++) {
				struct deform_contact contact = ground_stand(&ground, &shapes[s], 32.37, 32.21, reach - soil_sinkage_guess(&shapes[s], &soil, pow(10, i)));
				contact.load = pow(10, i);
				const bool bears = let_down(&ground, &contact, soils[k], &above);
				carried += bears;
				sunk += !bears;
				/* What sinks as deep as it is high is not carried there either. */
				assert_true(bears || force_at(&ground, &contact, lattice_offset(reach - 2 * reach + 0x1p-10) - contact.to.z) < contact.load);
			}
			ground_finish(&ground);
		}
	print_message("%d carried, %d not; carried at most %.3g m higher\n", carried, sunk, above);
	assert_true(carried > 200 && sunk > 5 && above == 0);
}

/* --- where the search is hard --- */

static double bank_slope, bank_height, bank_yaw; /* rise a metre; m; rad: towards the top */

static int32_t bank(int64_t x, int64_t y)
{
	const double along = ((double)(x - POSTS / 2) * cos(bank_yaw) + (double)(y - POSTS / 2) * sin(bank_yaw)) * 0.02;
	return (int32_t)lattice_base(fmin(fmax(bank_slope * along, 0), bank_height));
}

static int32_t tilted(int64_t x, int64_t y)
{
	return (int32_t)ldexp((double)(3 * x - 2 * y), BASE_BITS - 10);
}

/* Small bumps, and a bank of 1/8 m, about as steep as soil is stable. */
static int32_t bumps(int64_t x, int64_t y)
{
	const int64_t up = x - POSTS / 2 + 6;
	return (int32_t)lattice_base(ldexp((double)(up < 0 ? 0 : up > 12 ? 12 : up), -7) + ldexp((double)((x * 7 + y * 13) % 5), -11));
}

static int32_t holed(int64_t x, int64_t y)
{
	return x > 58 ? BASE_NODATA : 0;
}

static struct soil_numbers hard_soil(int kind)
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

static const struct soil_shape bodies[] = {
	{.kind = SOIL_WHEEL, .radius = 0.32, .width = 0.24}, {.kind = SOIL_BOX, .size = {0.3, 0.2, 0.4}}, {.kind = SOIL_SPHERE, .radius = 0.3},
};

static void hard_places_too(void **state)
{
	static const char *const kinds[] = {"sand", "stiff", "clay", "n 0.1", "snow"};
	static const double loads[] = {0.5, 30, 1500, 60000};
	static const struct {
		int32_t (*height)(int64_t x, int64_t y);
		double x;
	} places[] = {{NULL, 30.3}, {tilted, 30.3}, {bumps, 30.3}, {holed, 58}}; /* the last: half of it over nothing */
	int carried = 0;
	double above = 0;
	for (int n = 0; n < 5 * 4 * 3; n++) {
		const int kind = n % 5, p = n / 5 % 4, b = n / 20;
		const struct soil_numbers soil = hard_soil(kind);
		struct ground ground;
		init(&ground, &soil, n % 2 == 0 ? 0.02 : 0.03, places[p].height);
		for (int l = 0; l < 4; l++) {
			struct deform_contact contact = ground_stand(&ground, &bodies[b], places[p].x, 30.2, soil_shape_reach(&bodies[b], 0, 0) - 0.01);
			contact.load = loads[l];
			carried += let_down(&ground, &contact, kinds[kind], &above);
		}
		ground_finish(&ground);
	}
	print_message("%d carried; carried at most %.3g m higher\n", carried, above);
	assert_true(carried > 150);
	assert_true(above <= 1.5 * 0x1p-20); /* heights are whole units */
}

static void before_banks_and_steps_too(void **state)
{
	static const double yaws[] = {0, 22.5, 200}, slopes[] = {0, 1.5, 1e6}, heights[] = {1, 0.6, 1};
	const struct soil_numbers soil = bed_soil("dry_sand");
	int carried = 0, tried = 0;
	double above = 0;
	for (size_t n = 0; n < 3 * 3 * COUNT(bodies); n++) {
		const struct soil_shape *shape = &bodies[n / 9];
		struct ground ground;
		bank_slope = slopes[n % 3];
		bank_height = heights[n % 3];
		bank_yaw = yaws[n / 3 % 3] * DEGREES;
		init(&ground, &soil, 0.02, bank);
		for (double before = 0.02; before < 0.35; before += 0.13)
			for (int l = 0; l < 2; l++) {
				const double x = POSTS / 2 + 0.3 - before * cos(bank_yaw) / 0.02, y = POSTS / 2 + 0.2 - before * sin(bank_yaw) / 0.02;
				struct deform_contact contact = ground_stand(&ground, shape, x, y, soil_shape_reach(shape, 0, 0) + (l == 0 ? 0.02 : 0));
				contact.from.yaw = contact.to.yaw = bank_yaw;
				contact.load = l == 0 ? 5 : 800;
				carried += let_down(&ground, &contact, "dry_sand", &above);
				tried++;
			}
		ground_finish(&ground);
	}
	print_message("%d of %d loads carried; at most %.3g m higher\n", carried, tried, above);
	assert_true(carried > 3 * tried / 4 && above <= 1.5 * 0x1p-20);
}

/* --- --- */

static void the_guess_does_not_matter(void **state)
{
	static const double guesses[] = {0.45, 0.5, 0.2, 3, -3, 400, -400};
	struct ground ground;
	int64_t z = 0;
	init(&ground, NULL, 0.03125, NULL);
	for (size_t i = 0; i < COUNT(guesses); i++) {
		ground_reset(&ground);
		struct deform_contact contact = ground_stand(&ground, &wheel, 32.37, 32.21, guesses[i]);
		contact.load = 3000;
		const struct deform_forces forces = ground_forces(&ground, &contact);
		assert_true(i == 0 || forces.z == z);
		z = forces.z;
	}
	ground_finish(&ground);
}

/* It stands on what it left itself: no deeper, as often as it stands there. */
static void a_wheel_that_stands_again_stands_as_high(void **state)
{
	struct ground ground;
	init(&ground, NULL, 0.03125, NULL);
	struct deform_contact contact = ground_stand(&ground, &wheel, 32.37, 32.21, 0.45);
	contact.load = 3000;
	const int64_t z = ground_forces(&ground, &contact).z;
	for (int i = 0; i < 20; i++)
		assert_true(llabs(ground_forces(&ground, &contact).z - z) <= 1);
	ground_finish(&ground);
}

/* Its rim reaches over the world's edge, itself not. */
static void a_body_over_nothing_stays_where_it_is(void **state)
{
	struct ground ground;
	struct deform_tally tally;
	init(&ground, NULL, 0.03125, NULL);
	struct deform_contact contact = ground_stand(&ground, &wheel, -17, 32, 0.45);
	contact.load = 3000;
	const struct deform_forces forces = ground_forces(&ground, &contact);
	assert_true(forces.z == contact.to.z && forces.force[2] == 0 && forces.area == 0 && forces.state == DEFORM_AIR);
	bearing_tally(ground.bearing, &tally);
	assert_int_equal(tally.compacted, 0);
	ground_finish(&ground);
}

/* The intervals that follow a press of one wheel; `at`: where it is said to stand. */
static int32_t *slid_on(const struct soil_numbers *soil, const struct deform_contact *contact, const struct deform_rest *at, bool told)
{
	struct ground ground;
	ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 2, .spacing = 0.03125, .bulldozing = 1, .soils = soil, .iterations = 2,
						     .loaded_bodies = 2});
	const struct deform_forces forces = ground_forces(&ground, contact);
	if (told) /* as after a resume */
		bearing_set_equilibrium(ground.bearing, 2, (int32_t)(forces.z - contact->to.z));
	struct deform_rest rest = *at;
	if (at->loaded_body == 0)
		rest.pose.z = forces.z;
	assert_ok(bearing_wake(ground.bearing, ground.area.write));
	for (int n = 0; n < 12; n++)
		ground_interval(&ground, &rest, 1);
	int32_t *offsets = ground_plane(&ground, PLANE_OFFSET);
	ground_finish(&ground);
	return offsets;
}

/* What holds the soil meanwhile is the wheel as the soil carries it, not as it was guessed to stand. */
static void the_ground_slides_around_where_it_stands(void **state)
{
	const size_t bytes = 129 * 129 * sizeof(int32_t);
	struct soil_numbers soil = bed_soil("dry_sand");
	soil.repose = 0.1;
	for (int i = 0; i < 2; i++) {
		struct soil_pose pose = {.x = lattice_offset(64.37 * 0.03125), .y = lattice_offset(64.21 * 0.03125), .z = lattice_offset(i == 0 ? 0.55 : 0.2)};
		struct deform_contact contact = {.shape = &wheel, .from = pose, .to = pose, .load = 6000, .loaded_body = 1};
		int32_t *where = slid_on(&soil, &contact, &(struct deform_rest){&wheel, pose, 0, false}, false);
		int32_t *found = slid_on(&soil, &contact, &(struct deform_rest){&wheel, pose, 1, false}, false);
		int32_t *resumed = slid_on(&soil, &contact, &(struct deform_rest){&wheel, pose, 2, false}, true);
		int32_t *guessed = slid_on(&soil, &contact, &(struct deform_rest){&wheel, pose, 2, false}, false);
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
		cmocka_unit_test(bodies_rest_where_the_soil_carries_them),
		cmocka_unit_test(hard_places_too),
		cmocka_unit_test(before_banks_and_steps_too),
		cmocka_unit_test(the_guess_does_not_matter),
		cmocka_unit_test(a_wheel_that_stands_again_stands_as_high),
		cmocka_unit_test(the_ground_slides_around_where_it_stands),
		cmocka_unit_test(a_body_over_nothing_stays_where_it_is),
	};
	return cmocka_run_group_tests_name("bearing/load", tests, NULL, NULL);
}
