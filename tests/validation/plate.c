/*
 * Numbers 1 to 3 of the soil models: a plate is pressed, sheared and pressed again. A plate whose posts fill it
 * has no discretisation at all but where its load's height is found: what is allowed is what was printed.
 */
#include <stdio.h>

#include "bed.h"
#include "../support/program.h"

#define PRESSURE 20e3
#define ACROSS 0.1

static const struct {
	const char *soil;
	double millimetres, printed; /* sinkage, and half of its last digit */
} plates[] = {
	{"dry_sand", 19.29, 0.005}, {"sandy_loam_15", 1.97, 0.005}, {"lete_sand", 0.69, 0.005},
	{"lunar", 23.98, 0.005},    {"snow_us", 211.4, 0.05},
};
#define PLATES (sizeof plates / sizeof *plates)

/* A plate in the middle of a bed, its underside on the ground; `fit`: its edges lie between posts. */
static double sinkage(struct soil_numbers soil, double spacing, double at)
{
	int posts = (int)(3 * ACROSS / spacing);
	struct bed_params params = {.width = posts, .height = posts, .spacing = spacing, .soil = soil};
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {ACROSS, ACROSS, 1}};
	struct soil_pose pose = bed_pose(at, at, 0.5, spacing);
	struct deform_contact sweep = {.shape = &plate, .from = pose, .to = pose, .load = PRESSURE * ACROSS * ACROSS};
	struct bed_forces forces;
	double lower;
	struct bed bed;
	bed_init(&bed, &params);
	bed_press(&bed, &sweep, &forces, &lower);
	double step = BED_QUANTUM / forces.sinkage;
	bed_near("the load that is carried, N", forces.normal, sweep.load, 1e-6 + BED_STRESS + soil.bekker_n * step);
	bed_near("how far the plate sank, and its deepest post, m", lower, forces.sinkage, 1e-6 + step);
	bed_finish(&bed);
	return forces.sinkage;
}

static void a_plate_sinks_after_bekker(void **state)
{
	for (size_t i = 0; i < PLATES; i++) {
		struct soil_numbers soil = bed_soil(plates[i].soil);
		double wanted = reference_plate(&soil, ACROSS, PRESSURE);
		bed_near(plates[i].soil, wanted * 1e3, plates[i].millimetres, plates[i].printed / plates[i].millimetres);
		bed_near("and Bekker's pressure there", reference_bekker(&soil, ACROSS, wanted), PRESSURE, 1e-12);
	}
}

static void a_plate_of_posts_sinks_as_deep(void **state)
{
	for (size_t i = 0; i < PLATES; i++) {
		struct soil_numbers soil = bed_soil(plates[i].soil);
		double got = sinkage(soil, 0.01, 14.5), step = BED_QUANTUM / got;
		bed_near(plates[i].soil, got, reference_plate(&soil, ACROSS, PRESSURE), 1e-6 + step + BED_STRESS / soil.bekker_n);
		bed_near("as printed", got * 1e3, plates[i].millimetres, plates[i].printed / plates[i].millimetres + step);
	}
}

/* A plate covers the posts whose middles it covers: a row too many or too few at most, of each pair of sides. */
static void a_plate_between_posts_is_off_by_its_rim_at_most(void **state)
{
	static const double spacings[] = {0.03, 0.017, 0.012, 0.006};
	struct soil_numbers soil = bed_soil("dry_sand");
	for (size_t i = 0; i < sizeof spacings / sizeof *spacings; i++) {
		double got = sinkage(soil, spacings[i], (int)(1.5 * ACROSS / spacings[i]) + 0.3);
		double rim = spacings[i] / ACROSS;
		double least = reference_plate(&soil, ACROSS, PRESSURE / pow(1 + rim, 2));
		double most = reference_plate(&soil, ACROSS, PRESSURE / pow(1 - rim, 2));
		print_message("posts of %g m: %.3f mm, may be %.3f to %.3f\n", spacings[i], got * 1e3, least * 1e3, most * 1e3);
		assert_true(got >= least && got <= most);
	}
}

static struct soil_numbers shear_soil(void)
{
	struct soil_numbers soil = bed_soil("dry_sand");
	soil.janosi_shear = 0.025;
	return soil;
}

static void shear_rises_after_janosi(void **state)
{
	struct soil_numbers soil = shear_soil();
	bed_near("tau, most, kPa", reference_janosi(&soil, PRESSURE, INFINITY) / 1e3, 11.674, 0.0005 / 11.674);
	/* 7.3795: printed as 7.380. */
	bed_near("tau at K, kPa", reference_janosi(&soil, PRESSURE, 0.025) / 1e3, 7.380, 0.00051 / 7.380);
	bed_near("tau at 0.1 m, kPa", reference_janosi(&soil, PRESSURE, 0.1) / 1e3, 11.460, 0.0005 / 11.460);
}

/*
 * A plate of 2 m is dragged lengthwise. Each place has been sheared as far as the plate went, or as far as the plate's front is ahead of
 * it. Shear per area is that mean.
 */
static void a_dragged_plate_is_held_back_by_that_shear(void **state)
{
	double spacing = 0.0125, length = 2;
	struct soil_numbers soil = shear_soil();
	struct bed_params params = {.width = 180, .height = 16, .spacing = spacing, .soil = soil};
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {length, ACROSS, 1}};
	struct soil_pose pose = bed_pose(84.5, 7.5, 0.5, spacing);
	struct deform_contact sweep = {.shape = &plate, .from = pose, .to = pose, .load = PRESSURE * length * ACROSS};
	struct bed_forces forces;
	double lower, way = 0;
	struct bed bed;
	bed_init(&bed, &params);
	bed_press(&bed, &sweep, &forces, &lower);
	assert_true(forces.force[0] == 0); /* nothing has moved */
	for (int step = 1; step <= 8; step++) {
		sweep.from = sweep.to;
		sweep.to = bed_pose(84.5 + step, 7.5, 0.5, spacing);
		bed_press(&bed, &sweep, &forces, &lower);
		way = step * spacing;
		if (step == 2 || step == 8) {
			/* Of c + p tan phi, the integral of 1 - exp(-j / K). */
			double most = reference_janosi(&soil, PRESSURE, INFINITY), modulus = soil.janosi_shear;
			double fresh = most * (way - modulus * (1 - exp(-way / modulus)));
			double wanted = (fresh + reference_janosi(&soil, PRESSURE, way) * (length - way)) / length;
			/* Half a unit of shear is lost at most, each time; and of the load what it is found to. */
			double off = step * BED_SHEAR / 2 / (1 - exp(-way / soil.janosi_shear)) + BED_STRESS + BED_QUANTUM * soil.bekker_n / lower;
			char what[64];
			snprintf(what, sizeof what, "shear per area after %g m, Pa", way);
			bed_near(what, -forces.force[0] / forces.area, wanted, 5e-5 + off);
			/* Of the plate's length `way` is sheared less: at most by that share is it off. */
			bed_near("and of a whole plate at that displacement", -forces.force[0] / forces.area,
				 reference_janosi(&soil, PRESSURE, way), way / length + off);
		}
	}
	bed_finish(&bed);
}

static void a_second_equal_load_sinks_no_deeper(void **state)
{
	struct soil_numbers soil = bed_soft();
	struct bed_params params = {.width = 30, .height = 30, .spacing = 0.01, .soil = soil};
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {ACROSS, ACROSS, 1}};
	struct soil_pose pose = bed_pose(14.5, 14.5, 0.5, 0.01), lifted = bed_pose(14.5, 14.5, 2, 0.01);
	struct deform_contact press = {.shape = &plate, .from = pose, .to = pose, .load = PRESSURE * ACROSS * ACROSS};
	struct deform_contact lift = {.shape = &plate, .from = pose, .to = lifted};
	struct bed_forces forces;
	double first, again, lower;
	struct bed bed;
	bed_init(&bed, &params);
	bed_press(&bed, &press, &forces, &first);
	bed_near("sinkage, mm", first * 1e3, 123.28, 0.005 / 123.28 + BED_QUANTUM / 0.12);
	bed_near("its bottom, m", bed_surface_at(&bed, 14, 14), -first, 1e-5);
	assert_true(forces.work > 0);
	lift.from.z -= lattice_offset(first); /* from where it stands */
	bed_press(&bed, &lift, &forces, &lower);
	double bottom = bed_surface_at(&bed, 14, 14);
	bed_near("rebound, mm", (bottom + first) * 1e3, 0.5, 0.005); /* two quanta of 2^-20 m */
	assert_true(forces.area == 0 && forces.normal == 0);
	bed_press(&bed, &press, &forces, &again);
	bed_near("sinkage under the second load, m", again, first, 1e-5);
	assert_true(forces.work < 1e-6); /* the soil did not yield */
	bed_press(&bed, &lift, &forces, &lower);
	bed_near("bottom after it, m", bed_surface_at(&bed, 14, 14), bottom, 1e-5);
	/* Half the load stands on the rebound alone: elastic. */
	press.load /= 2;
	bed_press(&bed, &press, &forces, &again);
	bed_near("half the load: of the rebound, m", -again - bottom, -0.00025, 0.01);
	bed_finish(&bed);
}

/* Bekker's curve of this clay is steeper than K_e to 26 mm: all of a smaller sinkage is elastic, K_e z, and any load is carried. */
static void a_stiff_clay_carries_any_second_load(void **state)
{
	struct soil_numbers soil = bed_soil("heavy_clay_25");
	struct bed_params params = {.width = 30, .height = 30, .spacing = 0.01, .soil = soil};
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {ACROSS, ACROSS, 1}};
	struct soil_pose deep = bed_pose(14.5, 14.5, 0.499, 0.01), lifted = bed_pose(14.5, 14.5, 2, 0.01);
	struct deform_contact press = {.shape = &plate, .from = deep, .to = deep};
	struct deform_contact lift = {.shape = &plate, .from = deep, .to = lifted};
	struct bed_forces forces;
	double lower, full;
	struct bed bed;
	bed_init(&bed, &params);
	bed_press(&bed, &press, &forces, &lower);
	full = forces.normal;
	bed_near("pressed a millimetre, N", full, reference_yield(&soil, ACROSS, 0.001) * ACROSS * ACROSS, 1e-3);
	bed_near("and by K_e, N", full, soil.elastic_stiffness * 0.001 * ACROSS * ACROSS, 1e-3);
	bed_press(&bed, &lift, &forces, &lower);
	assert_true(fabs(bed_surface_at(&bed, 14, 14)) < 1e-6);
	for (int tenths = 9; tenths > 0; tenths -= 4) {
		press.load = full * tenths / 10;
		bed_press(&bed, &press, &forces, &lower);
		double step = BED_QUANTUM / (tenths * 1e-4);
		bed_near("a second load, N", forces.normal, press.load, 1e-3 + step);
		bed_near("its share of the millimetre, m", forces.sinkage, tenths * 1e-4, 2e-3 + step);
	}
	bed_finish(&bed);
}

TEST_PROGRAM(plate)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_plate_sinks_after_bekker),
		cmocka_unit_test(shear_rises_after_janosi),
		cmocka_unit_test(a_plate_of_posts_sinks_as_deep),
		cmocka_unit_test(a_plate_between_posts_is_off_by_its_rim_at_most),
		cmocka_unit_test(a_dragged_plate_is_held_back_by_that_shear),
		cmocka_unit_test(a_second_equal_load_sinks_no_deeper),
		cmocka_unit_test(a_stiff_clay_carries_any_second_load),
	};
	return cmocka_run_group_tests_name("validation/plate", tests, NULL, NULL);
}
