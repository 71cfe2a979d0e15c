/* Number 4 of the soil models: a wheel that is towed. */
#include <stdio.h>

#include "bed.h"
#include "../support/program.h"

static const struct towed {
	const char *soil;
	double load, width, diameter; /* N, m, m */
	double millimetres, resistance; /* as printed */
} wheels[] = {
	{"lunar", 283, 0.23, 0.81, 18.33, 31.9},
	{"dry_sand", 5000, 0.3, 1, 78.87, 1056},
};
#define WHEELS (sizeof wheels / sizeof *wheels)

static void a_towed_wheel_sinks_after_bekker(void **state)
{
	for (size_t i = 0; i < WHEELS; i++) {
		struct soil_numbers soil = bed_soil(wheels[i].soil);
		double sinkage = reference_towed(&soil, wheels[i].load, wheels[i].width, wheels[i].diameter);
		bed_near(wheels[i].soil, sinkage * 1e3, wheels[i].millimetres, 0.005 / wheels[i].millimetres);
		bed_near("its resistance, N", reference_resistance(&soil, wheels[i].width, sinkage), wheels[i].resistance,
			 (i == 0 ? 0.05 : 0.5) / wheels[i].resistance);
	}
}

struct rut {
	double sinkage, resistance; /* m; N: the work of a metre's soil yielding */
};

/* Rolls without slip, an axle `shift` of a post past one, until it has left what it stood on at first. `stiff`: of what it
 * stands on then no square metre is stiffer, Pa/m. */
static struct rut roll(const struct towed *wheel, const struct soil_numbers *soil,
		       double spacing, double shift, double stiff)
{
	double radius = wheel->diameter / 2, contact = sqrt(wheel->millimetres / 1e3 * wheel->diameter);
	int samples = (int)(1.3 * contact / spacing) + 1, rim = 3;
	int width = (int)(wheel->diameter / spacing) + samples + 2 * rim, height = (int)lround(wheel->width / spacing) + 2 * rim;
	struct bed_params params = {.width = width, .height = height, .spacing = spacing, .soil = *soil};
	struct soil_shape shape = {.kind = SOIL_WHEEL, .radius = radius, .width = wheel->width};
	double x = ceil(rim + radius / spacing) + shift, y = (height - 1) / 2.0;
	struct soil_pose start = bed_pose(x, y, radius, spacing);
	struct deform_contact sweep = {.shape = &shape, .from = start, .to = start, .load = wheel->load};
	struct bed_forces forces;
	struct rut rut;
	struct bed bed;
	bed_init(&bed, &params);
	bed_press(&bed, &sweep, &forces, &rut.sinkage);
	double standing = rut.sinkage;
	sweep.turned = spacing / radius;
	for (int i = 1; i <= samples; i++) {
		sweep.from = sweep.to;
		sweep.to = bed_pose(x + i, y, radius, spacing);
		bed_press(&bed, &sweep, &forces, &rut.sinkage);
	}
	/* Rolling it stands on its front half only. */
	assert_true(rut.sinkage > 1.1 * standing);
	bed_near("the load that is carried, N", forces.normal, wheel->load,
		 1e-6 + BED_STRESS + BED_QUANTUM * stiff * forces.area / wheel->load);
	rut.resistance = forces.work / spacing;
	bed_finish(&bed);
	return rut;
}

/*
 * A sum over posts is off by half a post at the lowest of the arc, where the stress is greatest and ends; sinkage goes with the
 * load's 2 / (2 n + 1). A tenth more for what is of second order.
 */
static double allowed(const struct towed *wheel, const struct soil_numbers *soil, double spacing)
{
	double stress = reference_bekker(soil, wheel->width, wheel->millimetres / 1e3);
	return 1.1 * stress * wheel->width * spacing / 2 / wheel->load * 2 / (2 * soil->bekker_n + 1);
}

static const struct {
	size_t wheel;
	double spacing, shift;
} rolls[] = {{0, 0.01, 0}, {0, 0.23 / 12, 0.1}, {1, 0.02, 0}, {1, 0.02, 0.5}};

/* Bekker's wheel stands on soil that does not spring back, and its arc is a parabola: 0.5 % off at these depths. */
static void a_wheel_on_posts_sinks_as_a_towed_one(void **state)
{
	for (size_t i = 0; i < sizeof rolls / sizeof *rolls; i++) {
		const struct towed *wheel = &wheels[rolls[i].wheel];
		struct soil_numbers soil = bed_soil(wheel->soil);
		soil.elastic_stiffness = 1e12;
		soil.cohesion = soil.friction_angle = 0; /* Bekker's wheel has no shear */
		double arc = reference_arc(&soil, wheel->load, wheel->width, wheel->diameter / 2, false);
		double error = allowed(wheel, &soil, rolls[i].spacing);
		print_message("%s, posts of %g m\n", wheel->soil, rolls[i].spacing);
		/* The soil at its foot yields. */
		double stiff = soil.bekker_n * reference_bekker(&soil, wheel->width, 1) *
			       pow(arc, soil.bekker_n - 1);
		struct rut rut = roll(wheel, &soil, rolls[i].spacing, rolls[i].shift, stiff);
		bed_near("the arc's sinkage, and Bekker's, m", arc,
			 reference_towed(&soil, wheel->load, wheel->width, wheel->diameter), 0.005);
		bed_near("sinkage, and the arc's, m", rut.sinkage, arc, error);
		bed_near("sinkage, mm", rut.sinkage * 1e3, wheel->millimetres, error + 0.005);
		/* It goes with the sinkage's n + 1, and to second order. */
		double share = 1.05 * (soil.bekker_n + 1) * (error + 0.005);
		bed_near("resistance, N", rut.resistance, wheel->resistance, share);
	}
}

/* The named soils do spring back, and carry some of the load behind the axle: the stress begins and ends at nothing there,
 * over a post or two at least, and a sum over posts is off by a quarter at most of what it else is. */
static void a_wheel_on_elastic_soil_sinks_less(void **state)
{
	for (size_t i = 0; i < sizeof rolls / sizeof *rolls; i++) {
		const struct towed *wheel = &wheels[rolls[i].wheel];
		struct soil_numbers soil = bed_soil(wheel->soil);
		soil.cohesion = soil.friction_angle = 0;
		double arc = reference_arc(&soil, wheel->load, wheel->width, wheel->diameter / 2, true);
		print_message("%s, posts of %g m\n", wheel->soil, rolls[i].spacing);
		assert_true(arc < 0.95 * reference_towed(&soil, wheel->load, wheel->width, wheel->diameter));
		struct rut rut = roll(wheel, &soil, rolls[i].spacing, rolls[i].shift, soil.elastic_stiffness);
		bed_near("sinkage, and the arc's, m", rut.sinkage, arc, allowed(wheel, &soil, rolls[i].spacing) / 4);
		bed_near("resistance, and of the arc's, N", rut.resistance,
			 reference_resistance(&soil, wheel->width, rut.sinkage), 0.01);
	}
}

/* Where the stresses of the rim have an antiderivative. */
static void the_rims_integrals_are_what_they_are_on_paper(void **state)
{
	struct soil_numbers soil = bed_soil("dry_sand");
	struct reference_wheel wheel = {.radius = 0.5, .width = 0.3, .slip = 0.4};
	double sinkage = 0.06, entry = acos(1 - sinkage / wheel.radius), r = wheel.radius, b = wheel.width, c = 2000;
	/* No shear, all stress in front: the arc's load, and Bekker's resistance. */
	soil.friction_angle = soil.cohesion = 0;
	struct reference_wheel_forces forces = reference_wong_reece(&soil, &wheel, sinkage);
	double arc = reference_arc_load(&soil, sinkage, b, r, false), resistance = reference_resistance(&soil, b, sinkage);
	bed_near("load, N", forces.load, arc, 1e-6);
	bed_near("drawbar, N", forces.drawbar, -resistance, 1e-6);
	assert_true(forces.torque == 0);
	/* All of the cohesion at once. */
	soil.cohesion = c;
	soil.janosi_shear = 1e-9;
	forces = reference_wong_reece(&soil, &wheel, sinkage);
	bed_near("torque of cohesion, N m", forces.torque, r * r * b * c * entry, 1e-6);
	bed_near("drawbar, N", forces.drawbar, r * b * c * sin(entry) - resistance, 1e-5);
	bed_near("load, N", forces.load, r * b * c * (1 - cos(entry)) + arc, 1e-5);
	/* Cohesion in proportion to the displacement: K far off. */
	soil.janosi_shear = 1e3;
	for (wheel.slip = -0.5; wheel.slip < 1; wheel.slip += 0.25) {
		double displacement = r * (entry * entry / 2 - (1 - wheel.slip) * (entry * sin(entry) - (1 - cos(entry))));
		forces = reference_wong_reece(&soil, &wheel, sinkage);
		bed_near("torque of a little cohesion, N m", forces.torque, r * r * b * c / 1e3 * displacement, 1e-3);
	}
	/* The greatest stress half way: behind it the stresses of the front again, the other way round. */
	soil = bed_soil("dry_sand");
	soil.friction_angle = soil.cohesion = 0;
	wheel = (struct reference_wheel){.radius = 0.5, .width = 0.3, .a0 = 0.25, .a1 = 0.5, .slip = 0.5};
	double sum = 0, most = 0.5 * entry;
	for (int i = 0; i < 100000; i++) {
		double angle = (i + 0.5) / 100000 * entry, like = angle > most ? angle : entry - angle;
		sum += reference_bekker(&soil, b, r * (cos(like) - cos(entry))) * cos(angle) * r * b * entry / 100000;
	}
	bed_near("load, the greatest stress in the middle, N", reference_wong_reece(&soil, &wheel, sinkage).load, sum, 1e-6);
	bed_near("and its sinkage, m", reference_wong_reece_sinkage(&soil, &wheel, sum), sinkage, 1e-6);
}

TEST_PROGRAM(wheel)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_towed_wheel_sinks_after_bekker),
		cmocka_unit_test(the_rims_integrals_are_what_they_are_on_paper),
		cmocka_unit_test(a_wheel_on_posts_sinks_as_a_towed_one),
		cmocka_unit_test(a_wheel_on_elastic_soil_sinks_less),
	};
	return cmocka_run_group_tests_name("validation/wheel", tests, NULL, NULL);
}
