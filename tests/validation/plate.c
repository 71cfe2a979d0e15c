/*
 * Numbers 1 to 3 of the soil models: a plate is pressed, sheared and pressed again. A plate whose posts fill it
 * has no discretisation at all but where its load's height is found: what is allowed is what was printed.
 */
#include <stdio.h>

#include "bed_gpu.h"
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

/* Project Chrono's soft soil. */
static struct soil_numbers soft_soil(void)
{
	return (struct soil_numbers){
		.bekker_kphi = 0.2e6, .bekker_n = 1.1, .friction_angle = 30 * RADIANS, .janosi_shear = 0.01,
		.elastic_stiffness = 4e7, .damping = 3e4, .unit_weight = 16e3, .repose = 30 * RADIANS,
	};
}

/* A plate in the middle of a bed, its underside on the ground; `fit`: its edges lie between posts. */
static double sinkage(const struct bed_kind *kind, struct soil_numbers soil, double spacing, double at)
{
	int posts = (int)(3 * ACROSS / spacing);
	struct bed_params params = bed_scm(posts, posts, spacing, soil);
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {ACROSS, ACROSS, 1}};
	struct soil_pose pose = bed_pose(at, at, 0.5, spacing);
	struct deform_contact sweep = {.shape = &plate, .from = pose, .to = pose, .load = PRESSURE * ACROSS * ACROSS};
	struct reference_forces forces;
	double lower;
	void *bed = kind->make(&params);
	kind->sweep(bed, &sweep, &forces, &lower);
	double step = kind->quantum / forces.sinkage;
	bed_near("the load that is carried, N", forces.normal, sweep.load, 1e-6 + kind->stress + soil.bekker_n * step);
	bed_near("how far the plate sank, and its deepest post, m", lower, forces.sinkage, 1e-6 + step);
	kind->destroy(bed);
	return forces.sinkage;
}

static void a_plate_sinks_after_bekker(void **state)
{
	(void)state;
	for (size_t i = 0; i < PLATES; i++) {
		struct soil_numbers soil = bed_soil(plates[i].soil);
		double wanted = reference_plate(&soil, ACROSS, PRESSURE);
		bed_near(plates[i].soil, wanted * 1e3, plates[i].millimetres, plates[i].printed / plates[i].millimetres);
		bed_near("and Bekker's pressure there", reference_bekker(&soil, ACROSS, wanted), PRESSURE, 1e-12);
	}
}

static void a_plate_of_posts_sinks_as_deep(void **state)
{
	const struct bed_kind *kind = *state;
	for (size_t i = 0; i < PLATES; i++) {
		struct soil_numbers soil = bed_soil(plates[i].soil);
		double got = sinkage(kind, soil, 0.01, 14.5), step = kind->quantum / got;
		bed_near(plates[i].soil, got, reference_plate(&soil, ACROSS, PRESSURE), 1e-6 + step + kind->stress / soil.bekker_n);
		bed_near("as printed", got * 1e3, plates[i].millimetres, plates[i].printed / plates[i].millimetres + step);
	}
}

/* A plate covers the posts whose middles it covers: a row too many or too few at most, of each pair of sides. */
static void a_plate_between_posts_is_off_by_its_rim_at_most(void **state)
{
	static const double spacings[] = {0.03, 0.017, 0.012, 0.006};
	struct soil_numbers soil = bed_soil("dry_sand");
	for (size_t i = 0; i < sizeof spacings / sizeof *spacings; i++) {
		double got = sinkage(*state, soil, spacings[i], (int)(1.5 * ACROSS / spacings[i]) + 0.3);
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
	(void)state;
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
	const struct bed_kind *kind = *state;
	double spacing = 0.0125, length = 2;
	struct soil_numbers soil = shear_soil();
	struct bed_params params = bed_scm(180, 16, spacing, soil);
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {length, ACROSS, 1}};
	struct soil_pose pose = bed_pose(84.5, 7.5, 0.5, spacing);
	struct deform_contact sweep = {.shape = &plate, .from = pose, .to = pose, .load = PRESSURE * length * ACROSS};
	struct reference_forces forces;
	double lower, way = 0;
	void *bed = kind->make(&params);
	kind->sweep(bed, &sweep, &forces, &lower);
	assert_true(forces.force[0] == 0); /* nothing has moved */
	for (int step = 1; step <= 8; step++) {
		sweep.from = sweep.to;
		sweep.to = bed_pose(84.5 + step, 7.5, 0.5, spacing);
		kind->sweep(bed, &sweep, &forces, &lower);
		way = step * spacing;
		if (step == 2 || step == 8) {
			/* Of c + p tan phi, the integral of 1 - exp(-j / K). */
			double most = reference_janosi(&soil, PRESSURE, INFINITY), modulus = soil.janosi_shear;
			double fresh = most * (way - modulus * (1 - exp(-way / modulus)));
			double wanted = (fresh + reference_janosi(&soil, PRESSURE, way) * (length - way)) / length;
			/* Half a unit of shear is lost at most, each time; and of the load what it is found to. */
			double off = step * kind->shear_quantum / 2 / (1 - exp(-way / soil.janosi_shear)) + kind->stress + kind->quantum * soil.bekker_n / lower;
			char what[64];
			snprintf(what, sizeof what, "shear per area after %g m, Pa", way);
			bed_near(what, -forces.force[0] / forces.area, wanted, 5e-5 + off);
			/* Of the plate's length `way` is sheared less: at most by that share is it off. */
			bed_near("and of a whole plate at that displacement", -forces.force[0] / forces.area,
				 reference_janosi(&soil, PRESSURE, way), way / length + off);
		}
	}
	kind->destroy(bed);
}

static void a_second_equal_load_sinks_no_deeper(void **state)
{
	const struct bed_kind *kind = *state;
	struct soil_numbers soil = soft_soil();
	struct bed_params params = bed_scm(30, 30, 0.01, soil);
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {ACROSS, ACROSS, 1}};
	struct soil_pose pose = bed_pose(14.5, 14.5, 0.5, 0.01), lifted = bed_pose(14.5, 14.5, 2, 0.01);
	struct deform_contact press = {.shape = &plate, .from = pose, .to = pose, .load = PRESSURE * ACROSS * ACROSS};
	struct deform_contact lift = {.shape = &plate, .from = pose, .to = lifted};
	struct reference_forces forces;
	double first, again, lower;
	void *bed = kind->make(&params);
	kind->sweep(bed, &press, &forces, &first);
	bed_near("sinkage, mm", first * 1e3, 123.28, 0.005 / 123.28 + kind->quantum / 0.12);
	bed_near("its bottom, m", kind->surface(bed, 14, 14), -first, 1e-5);
	assert_true(forces.work > 0);
	lift.from.z -= lattice_offset(first); /* from where it stands */
	kind->sweep(bed, &lift, &forces, &lower);
	double bottom = kind->surface(bed, 14, 14);
	bed_near("rebound, mm", (bottom + first) * 1e3, 0.5, 0.005); /* two quanta of 2^-20 m */
	assert_true(forces.area == 0 && forces.normal == 0);
	kind->sweep(bed, &press, &forces, &again);
	bed_near("sinkage under the second load, m", again, first, 1e-5);
	assert_true(forces.work < 1e-6); /* the soil did not yield */
	kind->sweep(bed, &lift, &forces, &lower);
	bed_near("bottom after it, m", kind->surface(bed, 14, 14), bottom, 1e-5);
	/* Half the load stands on the rebound alone: elastic. */
	press.load /= 2;
	kind->sweep(bed, &press, &forces, &again);
	bed_near("half the load: of the rebound, m", -again - bottom, -0.00025, 0.01);
	assert_true(fabs(kind->volume(bed)) < 1e-9);
	kind->destroy(bed);
}

/* Bekker's curve of this clay is steeper than K_e to 26 mm: all of a smaller sinkage is elastic, K_e z, and any load is carried. */
static void a_stiff_clay_carries_any_second_load(void **state)
{
	const struct bed_kind *kind = *state;
	struct soil_numbers soil = bed_soil("heavy_clay_25");
	struct bed_params params = bed_scm(30, 30, 0.01, soil);
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {ACROSS, ACROSS, 1}};
	struct soil_pose deep = bed_pose(14.5, 14.5, 0.499, 0.01), lifted = bed_pose(14.5, 14.5, 2, 0.01);
	struct deform_contact press = {.shape = &plate, .from = deep, .to = deep};
	struct deform_contact lift = {.shape = &plate, .from = deep, .to = lifted};
	struct reference_forces forces;
	double lower, full;
	void *bed = kind->make(&params);
	kind->sweep(bed, &press, &forces, &lower);
	full = forces.normal;
	bed_near("pressed a millimetre, N", full, reference_yield(&soil, ACROSS, 0.001) * ACROSS * ACROSS, 1e-3);
	bed_near("and by K_e, N", full, soil.elastic_stiffness * 0.001 * ACROSS * ACROSS, 1e-3);
	kind->sweep(bed, &lift, &forces, &lower);
	assert_true(fabs(kind->surface(bed, 14, 14)) < 1e-6);
	for (int tenths = 9; tenths > 0; tenths -= 4) {
		press.load = full * tenths / 10;
		kind->sweep(bed, &press, &forces, &lower);
		double step = kind->quantum / (tenths * 1e-4);
		bed_near("a second load, N", forces.normal, press.load, 1e-3 + step);
		bed_near("its share of the millimetre, m", forces.sinkage, tenths * 1e-4, 2e-3 + step);
	}
	kind->destroy(bed);
}

TEST_PROGRAM(plate)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_plate_sinks_after_bekker),
		cmocka_unit_test(shear_rises_after_janosi),
		bed_tests(a_plate_of_posts_sinks_as_deep),
		bed_tests(a_plate_between_posts_is_off_by_its_rim_at_most),
		bed_tests(a_dragged_plate_is_held_back_by_that_shear),
		bed_tests(a_second_equal_load_sinks_no_deeper),
		bed_tests(a_stiff_clay_carries_any_second_load),
	};
	return cmocka_run_group_tests_name("validation/plate", tests, open_gpu, close_gpu);
}
