/*
 * A wheel that rolls, beside the closed forms of the same law: wherever its axle lies between posts, and at each angle to them.
 * Nothing is laid around it. The soil is fresh, and the way longer than the contact.
 */
#include <stdio.h>

#include "bed.h"
#include "../support/program.h"

struct told {
	double drawbar, side, vertical, moment, area, sinkage;
	double deepest; /* m: the sinkage that forces tell */
};

struct rolled {
	double spacing, degrees, shift; /* posts that the start is moved by */
	double sinkage, load;           /* at this sinkage; or under this load, N, if it is above 0 */
	double hair;                    /* m: not 0: the axle is so far beside a row of posts */
};

/* Rolls as far as the contact is long and two posts more. The forces are those of the last path sample. */
static struct told roll(const struct soil_numbers *soil, const struct reference_rolling *wheel, const struct rolled *how)
{
	struct ground ground;
	double heading = how->degrees * RADIANS, c = cos(heading), s = sin(heading), spacing = how->spacing, r = wheel->radius;
	int stations = (int)ceil(1.3 * sqrt(2 * r * how->sinkage) / spacing) + 2;
	double edge = 1.1 * r / spacing + 4, x = edge + how->shift, y = how->hair != 0 ? floor(edge) + how->hair / spacing : edge + 0.7 * how->shift;
	ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = (uint32_t)ceil((2 * edge + stations + 2) / 64), .spacing = spacing,
						     .soils = soil, .iterations = 1,
						     .ground_normals = wheel->normals == REFERENCE_NORMALS_GROUND});
	struct soil_shape shape = {.kind = SOIL_WHEEL, .radius = r, .width = wheel->width};
	struct deform_contact sweep = {.shape = &shape, .interface = wheel->interface, .load = how->load};
	struct deform_forces forces = {.z = 0};
	for (int i = 0; i <= stations; i++) {
		sweep.from = sweep.to;
		sweep.to = ground_pose(&ground, x + i * c, y + i * s, r - how->sinkage);
		sweep.to.yaw = heading;
		sweep.turned = i > 0 ? wheel->turned * spacing / r : 0;
		sweep.from = i > 0 ? sweep.from : sweep.to;
		forces = ground_forces(&ground, &sweep);
	}
	double z = lattice_offset_metres(forces.z);
	ground_finish(&ground);
	return (struct told){forces.force[0] * c + forces.force[1] * s, forces.force[1] * c - forces.force[0] * s, forces.force[2],
			     forces.moment[1] * c - forces.moment[0] * s, forces.area, r - z, forces.sinkage};
}

/* Shares by which the vertical force, the drawbar and the moment are off. */
struct off {
	double vertical, drawbar, moment;
};

static struct off off_by(const struct told *got, const struct reference_rolling_force *wanted)
{
	return (struct off){fabs(got->vertical / wanted->vertical - 1), fabs(got->drawbar / wanted->drawbar - 1),
			    fabs(got->moment / wanted->moment - 1)};
}

static struct off larger(struct off a, struct off b)
{
	return (struct off){fmax(a.vertical, b.vertical), fmax(a.drawbar, b.drawbar), fmax(a.moment, b.moment)};
}

static const char *const soils[] = {"dry_sand", "lunar", "lete_sand", "snow_us", "sandy_loam_15"};
static const double angles[] = {0, 22.5, 45}, shifts[] = {0, 0.31, 0.62};

/* The worst at all angles and places. */
static struct off worst(const struct soil_numbers *soil, const struct reference_rolling *wheel, double sinkage, double spacing, double load)
{
	struct reference_rolling_force wanted = reference_rolling(soil, wheel, sinkage);
	struct off most = {0, 0, 0};
	for (int angle = 0; angle < 3; angle++)
		for (int shift = 0; shift < 3; shift++) {
			struct told got = roll(soil, wheel, &(struct rolled){spacing, angles[angle], shifts[shift], sinkage, load, 0});
			most = larger(most, off_by(&got, &wanted));
			/* It goes straight. */
			assert_true(fabs(got.side) < 2e-3 * wanted.vertical);
			/* The post that is nearest to the axle is half a post away at most. */
			assert_true(fabs(got.deepest - got.sinkage) < 1.5 * spacing * spacing / (8 * wheel->radius) + 2e-5);
			if (load > 0) {
				assert_true(fabs(got.vertical / load - 1) < 5e-3);
				if (!(fabs(got.sinkage / sinkage - 1) < 5e-3))
					fail_msg("%g m, %g degrees: sinkage %g m, wanted %g", spacing, angles[angle], got.sinkage, sinkage);
			}
		}
	print_message("posts of %g m: off by Fz %.3f %%, Fx %.3f %%, My %.3f %%\n", spacing, most.vertical * 100, most.drawbar * 100,
		      most.moment * 100);
	return most;
}

static const struct reference_rolling driven = {.radius = 0.32, .width = 0.24, .turned = 1.25, .rebound = true,
						.normals = REFERENCE_NORMALS_SURFACE, .follows = REFERENCE_FOLLOWS_RIM};

/* The wheel of lete_sand has two posts below it at 4 cm. */
static void a_wheel_tells_what_the_closed_form_does(void **state)
{
	for (size_t k = 0; k < COUNT(soils); k++) {
		struct soil_numbers soil = bed_soil(soils[k]);
		double sinkage = reference_rolling_sinkage(&soil, &driven, 1000);
		print_message("%s, %.2f mm\n", soils[k], sinkage * 1e3);
		struct off coarse = worst(&soil, &driven, sinkage, 0.04, 0), fine = worst(&soil, &driven, sinkage, 0.02, 0);
		assert_true(coarse.vertical < 0.01 && coarse.drawbar < (k == 3 ? 0.05 : 0.02) && coarse.moment < 0.02);
		assert_true(fine.vertical < 0.005 && fine.drawbar < 0.02 && fine.moment < 0.02);
		/* Of first order at least, where it is not small already. */
		assert_true(fine.drawbar < fmax(coarse.drawbar / 2, 0.005) && fine.moment < fmax(coarse.moment / 2, 0.002));
	}
}

/* Each place of a rim that does not turn slips for as long as it is in the soil, so all its shear is mobilised. The law counts ten times the soil's time. */
static void a_locked_wheel_is_held_back_as_the_closed_form_says(void **state)
{
	const struct reference_rolling locked = {.radius = 0.32, .width = 0.24, .rebound = true, .normals = REFERENCE_NORMALS_SURFACE, .follows = REFERENCE_FOLLOWS_RIM};
	for (size_t k = 0; k < COUNT(soils); k++) {
		struct soil_numbers soil = bed_soil(soils[k]);
		const double sinkage = 0.05;
		print_message("%s, locked\n", soils[k]);
		for (double spacing = 0.04; spacing > 0.005; spacing /= 2) {
			struct off off = worst(&soil, &locked, sinkage, spacing, 0);
			/* In snow_us, whose shear modulus is 3 cm, ten times is not yet for ever. */
			const double allowed = k != 3 ? 0.01 : spacing > 0.03 ? 0.08 : 0.03;
			assert_true(off.vertical < allowed && off.drawbar < allowed && off.moment < allowed);
		}
	}
}

static void a_loaded_wheel_sinks_as_deep(void **state)
{
	struct soil_numbers soil = bed_soil("dry_sand");
	double sinkage = reference_rolling_sinkage(&soil, &driven, 1000);
	struct off off = worst(&soil, &driven, sinkage, 0.04, 1000);
	assert_true(off.drawbar < 0.05 && off.moment < 0.05);
	off = worst(&soil, &driven, sinkage, 0.02, 1000);
	assert_true(off.drawbar < 0.02 && off.moment < 0.02);
}

/* Smooth rims, sticky ones, and both: the soil slides along them, or shears within itself, whichever takes less. */
static void a_rim_weaker_than_the_soil_pulls_as_the_closed_form_does(void **state)
{
	static const struct {
		const char *soil;
		struct soil_interface rim;
	} rows[] = {
		{"dry_sand", {.has_friction = true, .friction_angle = 15 * RADIANS}},
		{"dry_sand", {.has_adhesion = true, .adhesion = 0}},
		{"lete_sand", {true, true, 20 * RADIANS, 300}},
		/* Adhesion holds more than cohesion, friction less: near the ground's surface soil shears within itself, below it slides. */
		{"sandy_loam_15", {true, true, 10 * RADIANS, 6000}},
	};
	for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
		struct soil_numbers soil = bed_soil(rows[k].soil);
		struct reference_rolling wheel = driven;
		double drawbar = reference_rolling(&soil, &wheel, reference_rolling_sinkage(&soil, &wheel, 1000)).drawbar;
		wheel.interface = rows[k].rim;
		double sinkage = reference_rolling_sinkage(&soil, &wheel, 1000);
		struct reference_rolling_force wanted = reference_rolling(&soil, &wheel, sinkage);
		print_message("%s, %.2f mm, %.1f N, of a rough rim %.1f N\n", rows[k].soil, sinkage * 1e3, wanted.drawbar, drawbar);
		assert_true(wanted.drawbar < drawbar - 20);
		struct off coarse = worst(&soil, &wheel, sinkage, 0.04, 1000), middle = worst(&soil, &wheel, sinkage, 0.02, 1000);
		struct off fine = worst(&soil, &wheel, sinkage, 0.01, 1000);
		assert_true(coarse.drawbar < 0.03 && coarse.moment < 0.02);
		assert_true(middle.drawbar < 0.02 && middle.moment < 0.02);
		assert_true(fine.drawbar < 0.01 && fine.moment < 0.01);
	}
}

/* Its sides are on posts, or some fixed-point units beside them: what it bears on hardly changes. */
static void a_hair_beside_posts_is_nothing(void **state)
{
	struct soil_numbers soil = bed_soil("dry_sand");
	for (double spacing = 0.04; spacing > 0.01; spacing /= 2) {
		struct told first = {0};
		for (int units = -4; units <= 4; units++) {
			struct told got = roll(&soil, &driven, &(struct rolled){spacing, 0, 0.31, 0.04, 1000, units * 0x1p-20 + 0x1p-30});
			first = units == -4 ? got : first;
			print_message("%g m, %d: %.3f mm, %.2f N, %g m2\n", spacing, units, got.sinkage * 1e3, got.drawbar, got.area);
			assert_true(fabs(got.sinkage / first.sinkage - 1) < 1e-4 && fabs(got.drawbar / first.drawbar - 1) < 1e-4);
			assert_true(fabs(got.area / first.area - 1) < 1e-4 && fabs(got.side) < 0.01);
		}
	}
}

/* A wheel of 25 mm over posts of 31 mm: also where it goes between them. */
static void a_wheel_narrower_than_the_posts_is_carried_everywhere(void **state)
{
	struct soil_numbers soil = bed_soil("dry_sand");
	struct reference_rolling narrow = driven;
	narrow.width = 0.025;
	struct reference_rolling_force wanted = reference_rolling(&soil, &narrow, 0.03);
	for (int angle = 0; angle < 3; angle++)
		for (double shift = 0; shift < 1; shift += 0.125) {
			struct told got = roll(&soil, &narrow, &(struct rolled){0.03125, angles[angle], shift, 0.03, 0, 0});
			struct off off = off_by(&got, &wanted);
			print_message("%g degrees, %g: Fz %.2f %%, Fx %.2f %%, My %.2f %% area %g\n", angles[angle], shift, off.vertical * 100,
				      off.drawbar * 100, off.moment * 100, got.area);
			assert_true(off.vertical < 0.03 && off.drawbar < 0.06 && off.moment < 0.06);
		}
}

/* Project Chrono's soft soil, and stresses as it has them: along the ground's normal. By the closed forms; its own figures differ by 1 %. */
static void normals_of_the_ground_are_chronos(void **state)
{
	struct soil_numbers soil = {.bekker_kphi = 0.2e6, .bekker_n = 1.1, .friction_angle = 30 * RADIANS, .janosi_shear = 0.01,
				    .elastic_stiffness = 4e7, .unit_weight = 16e3, .repose = 30 * RADIANS};
	static const struct {
		double sinkage, slip, drawbar, vertical, moment;
	} rows[] = {
		{0.1, 0, -627.1, 1349.7, 163.0}, {0.1, 0.2, 643.1, 1349.7, -454.9}, {0.1, 0.5, 774.4, 1349.7, -514.9},
		{0.05, 0, -120.8, 450.7, 25.5}, {0.05, 0.2, 226.2, 450.7, -145.5}, {0.05, 0.5, 258.3, 450.7, -160.9},
	};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		struct reference_rolling wheel = {.radius = 0.5, .width = 0.4, .turned = reference_turned(rows[i].slip), .rebound = true,
						  .normals = REFERENCE_NORMALS_GROUND, .follows = REFERENCE_FOLLOWS_SOIL};
		/* Without slip the surface hardly moves at the lowest point. The shear there has the direction of that way, which is rounded
		 * to 2^-20 m: at 22.5 degrees it is lost. */
		for (int angle = 0; angle < 3; angle += rows[i].slip == 0 ? 2 : 1) {
			struct told got = roll(&soil, &wheel, &(struct rolled){0.02, angles[angle], 0.31, rows[i].sinkage, 0, 0});
			print_message("%g m, slip %g, %g degrees\n", rows[i].sinkage, rows[i].slip, angles[angle]);
			bed_near("Fz, N", got.vertical, rows[i].vertical, 0.005);
			bed_near("Fx, N", got.drawbar, rows[i].drawbar, 0.005);
			bed_near("My, N m", got.moment, rows[i].moment, 0.01);
		}
	}
}

TEST_PROGRAM(rolling)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_wheel_tells_what_the_closed_form_does),
		cmocka_unit_test(a_locked_wheel_is_held_back_as_the_closed_form_says),
		cmocka_unit_test(a_loaded_wheel_sinks_as_deep),
		cmocka_unit_test(a_rim_weaker_than_the_soil_pulls_as_the_closed_form_does),
		cmocka_unit_test(a_hair_beside_posts_is_nothing),
		cmocka_unit_test(a_wheel_narrower_than_the_posts_is_carried_everywhere),
		cmocka_unit_test(normals_of_the_ground_are_chronos),
	};
	return cmocka_run_group_tests_name("validation/rolling", tests, NULL, NULL);
}
