/* The soil contact model: plates and wheels against its formulas. */
#include "scm_rig.h"
#include "../support/program.h"

static const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.4, 0.1, 0.5}};

/* soil-models.md 4.1. The numbers there are rounded to 0.01 mm, so a sinkage may be off by 5e-6 m. */
static void plates_sink_as_bekker_says(void **state)
{
	static const struct {
		const char *soil;
		double sinkage; /* mm, under 20 kPa and 0.1 m wide */
	} plates[] = {{"dry_sand", 19.29}, {"sandy_loam_15", 1.97}, {"lete_sand", 0.69}, {"lunar", 23.98}, {"snow_us", 211.4}};
	(void)state;
	need_gpu();
	for (size_t i = 0; i < sizeof plates / sizeof *plates; i++) {
		struct ground ground;
		struct soil_numbers soil = named(plates[i].soil);
		init(&ground, &soil, 0.015625, 0);
		struct deform_contact sweep = ground_stand(&ground, &plate, 64.3, 64.4, 0.25 - plates[i].sinkage / 1000);
		struct deform_forces forces = ground_forces(&ground, &sweep);
		double pressure = forces.force[2] / forces.area, rounding = plates[i].sinkage > 100 ? 0.055 : 0.0055;
		assert_true(fabs(pressure / 20e3 - 1) < soil.bekker_n * rounding / plates[i].sinkage);
		double k = soil.bekker_kc / 0.1 + soil.bekker_kphi;
		assert_true(fabs(pressure / (k * pow(forces.sinkage, soil.bekker_n)) - 1) < 1e-5);
		assert_true(forces.force[0] == 0 && forces.force[1] == 0 && fabs(forces.moment[2]) == 0);
		ground_finish(&ground);
	}
}

/* Returns the mean shear below the plate after a straight way of (x, y) metres. At each place the plate has slid since it came over it. */
static double mean_shear(const struct soil_numbers *soil, double pressure, double x, double y)
{
	enum { PIECES = 400 };
	double sum = 0;
	for (int i = 0; i < PIECES; i++)
		for (int k = 0; k < PIECES; k++) {
			double share = fmin(1, fmin(plate.size[0] * (i + 0.5) / PIECES / x, plate.size[1] * (k + 0.5) / PIECES / y));
			sum += reference_janosi(soil, pressure, share * hypot(x, y));
		}
	return sum / PIECES / PIECES;
}

/* 4.2: of the whole way at once. What was below the plate from the start is sheared so far. The plate is 6.4 posts wide. */
static void plates_shear_as_janosi_says(void **state)
{
	struct soil_numbers soil = named("dry_sand");
	struct ground ground;
	const struct {
		double way, tau, within; /* of the last, a post slides a K further than the one before it */
	} cases[] = {{0.025, 7380, 0.01}, {0.1, 11460, 0.005}, {0.9, 11674, 0.03}};
	(void)state;
	need_gpu();
	soil.janosi_shear = 0.025;
	init(&ground, &soil, 0.015625, 0);
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		ground_reset(&ground);
		double x = cases[i].way * 0.8, y = cases[i].way * 0.6;
		struct deform_contact first = ground_stand(&ground, &plate, 40, 64, 0.25 - 0.0192946), sweep = move(&first, x, y, 0);
		struct deform_forces forces = ground_forces(&ground, &sweep);
		double wanted = mean_shear(&soil, 20e3, x, y);
		assert_true(fabs(forces.force[2] / forces.area - 20e3) < 2);
		assert_true(fabs(reference_janosi(&soil, 20e3, cases[i].way) - cases[i].tau) < 2);
		assert_true(wanted < cases[i].tau);
		print_message("%g m: %.1f and %.1f Pa, wanted %.1f\n", cases[i].way, -forces.force[0] / forces.area / 0.8, -forces.force[1] / forces.area / 0.6, wanted);
		assert_true(fabs(-forces.force[0] / forces.area / (0.8 * wanted) - 1) < cases[i].within);
		assert_true(fabs(-forces.force[1] / forces.area / (0.6 * wanted) - 1) < cases[i].within);
	}
	ground_finish(&ground);
}

/* Damping adds R v to the pressure where the body moves down, and nothing where it moves up or has no time of motion. */
static void soil_that_is_pressed_fast_bears_more(void **state)
{
	struct soil_numbers soil = soft();
	struct ground ground;
	(void)state;
	need_gpu();
	init(&ground, &soil, 0.015625, 0);
	const double seconds[] = {0, 0.1, 0.01};
	double still = 0;
	for (int i = 0; i < 3; i++) {
		ground_reset(&ground);
		struct deform_contact first = ground_stand(&ground, &plate, 64, 64, 0.25 - 0.04), sweep = move(&first, 0, 0, -0.01);
		sweep.seconds = seconds[i];
		struct deform_forces forces = ground_forces(&ground, &sweep);
		double pressure = forces.force[2] / forces.area, rate = i > 0 ? 0.01 / seconds[i] : 0;
		still = i == 0 ? pressure : still;
		assert_true(fabs(pressure - still - soil.damping * rate) < 0.5 + 1e-4 * soil.damping * rate); /* places are whole quanta */
	}
	ground_finish(&ground);
}

/* 4.3: it rebounds by 0.5 mm, and bears the same again without sinking deeper. */
static void a_load_rebounds_and_presses_no_deeper_again(void **state)
{
	struct soil_numbers soil = soft();
	struct ground ground;
	(void)state;
	need_gpu();
	init(&ground, &soil, 0.015625, 0);
	struct deform_contact first = ground_stand(&ground, &plate, 64, 64, 0.25);
	first.load = 1;
	struct deform_forces forces = ground_forces(&ground, &first);
	ground_reset(&ground);
	first.load = 20e3 * forces.area;
	forces = ground_forces(&ground, &first);
	assert_true(fabs(forces.sinkage - 0.12328) < 6e-6);
	struct deform_contact lift = ground_stand(&ground, &plate, 64, 64, 0.25 - forces.sinkage);
	lift.to.z = lattice_offset(1);
	ground_sweep(&ground, &lift);
	int32_t rut = ground_post(&ground, PLANE_OFFSET, 64, 64), pressed = ground_post(&ground, PLANE_PLASTIC_SINKAGE, 64, 64);
	assert_true(fabs(lattice_offset_metres(rut) + forces.sinkage - 0.0005) < 2e-6);
	for (int i = 0; i < 3; i++) {
		struct deform_forces again = ground_forces(&ground, &first);
		assert_true(fabs(again.sinkage - forces.sinkage) <= 0x1p-20);
		assert_true(abs(ground_post(&ground, PLANE_OFFSET, 64, 64) + (int32_t)lattice_offset(forces.sinkage)) <= 1);
		lift.from.z = again.z;
		ground_sweep(&ground, &lift);
		assert_true(abs(ground_post(&ground, PLANE_OFFSET, 64, 64) - rut) <= 1);
		assert_true(abs(ground_post(&ground, PLANE_PLASTIC_SINKAGE, 64, 64) - pressed) <= 1);
	}
	ground_finish(&ground);
}

static void roll(struct ground *ground, const struct deform_contact *start, int sweeps, struct deform_forces *last)
{
	struct deform_contact sweep = *start;
	ground_sweep(ground, &sweep);
	for (int i = 0; i < sweeps; i++) {
		sweep = move(&sweep, ground->params.spacing, 0, 0);
		if (i + 1 < sweeps || last == NULL)
			ground_sweep(ground, &sweep);
		else
			*last = ground_forces(ground, &sweep);
	}
}

static void a_second_pass_sinks_no_deeper(void **state)
{
	struct soil_numbers soil = soft();
	struct ground ground;
	(void)state;
	need_gpu();
	init(&ground, &soil, 0.03125, 0);
	struct deform_contact start = ground_stand(&ground, &wheel, 40, 64, 0.3 - 0.05);
	roll(&ground, &start, 40, NULL);
	struct planes first = planes_of(&ground);
	roll(&ground, &start, 40, NULL);
	struct planes second = planes_of(&ground);
	for (int i = 0; i < 3; i++)
		assert_memory_equal(first.all[i], second.all[i], (size_t)(ground.posts * ground.posts) * 4);
	/* In the second pass only the rut's bottom is in contact, so it is sheared less. The third pass changes nothing at all. */
	assert_memory_not_equal(first.all[3], second.all[3], (size_t)(ground.posts * ground.posts) * 4);
	for (size_t i = 0; i < KEPT; i++)
		mem_free(first.all[i]);
	roll(&ground, &start, 40, NULL);
	struct planes third = planes_of(&ground);
	assert_same_and_free(&ground, &second, &third);
	ground_finish(&ground);
}

static void left_and_right_are_the_same(void **state)
{
	struct soil_numbers soil = soft();
	struct deform_forces forces;
	struct ground ground;
	(void)state;
	need_gpu();
	/* Without bulldozing: the remainder of laid soil would go to the south first. */
	init(&ground, &soil, 0.03125, 0);
	struct deform_contact start = ground_stand(&ground, &wheel, 40, 64, 0.3 - 0.06);
	start.seconds = 0.01;
	start.turned = 0.03125 / 0.3 / 0.8;
	roll(&ground, &start, 30, &forces);
	struct planes planes = planes_of(&ground);
	for (size_t i = 0; i < KEPT; i++) {
		for (int64_t y = 1; y <= 64; y++)
			assert_memory_equal(planes.all[i] + (64 - y) * ground.posts, planes.all[i] + (64 + y) * ground.posts,
					    (size_t)ground.posts * 4);
		mem_free(planes.all[i]);
	}
	assert_true(forces.force[0] != 0 && forces.force[2] > 0);
	/* Rounded post by post. */
	assert_true(fabs(forces.force[1]) < 1e-2 && fabs(forces.moment[0]) < 1e-2 && fabs(forces.moment[2]) < 1e-2);
	ground_finish(&ground);
}

static void a_wheel_that_slips_more_pulls_more(void **state)
{
	struct soil_numbers soil = named("dry_sand");
	struct ground ground;
	double before = -INFINITY;
	(void)state;
	need_gpu();
	init(&ground, &soil, 0.03125, 0);
	for (int i = -2; i < 9; i++) {
		struct deform_forces forces;
		ground_reset(&ground);
		struct deform_contact start = ground_stand(&ground, &wheel, 40, 64, 0.3 - 0.03);
		start.turned = 0.03125 / (0.3 * (1 - i * 0.1));
		roll(&ground, &start, 30, &forces);
		assert_true(forces.force[0] > before);
		before = forces.force[0];
		assert_true(i < 2 || forces.force[0] > 0);
		assert_true(i > -1 || forces.force[0] < 0);
	}
	ground_finish(&ground);
}

TEST_PROGRAM(scm)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(plates_sink_as_bekker_says),
		cmocka_unit_test(plates_shear_as_janosi_says),
		cmocka_unit_test(soil_that_is_pressed_fast_bears_more),
		cmocka_unit_test(a_load_rebounds_and_presses_no_deeper_again),
		cmocka_unit_test(a_second_pass_sinks_no_deeper),
		cmocka_unit_test(left_and_right_are_the_same),
		cmocka_unit_test(a_wheel_that_slips_more_pulls_more),
	};
	return cmocka_run_group_tests_name("deform/scm", tests, open_gpu, close_gpu);
}
