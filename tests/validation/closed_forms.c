/* The closed forms that the posts are held to, held themselves: to a second derivation, to figures of others, and to balance. */
#include <stdio.h>

#include "../support/near.h"
#include "bed.h"
#include "wheel_march.h"
#include "../support/program.h"

static const char *const wong_soils[] = {
	"dry_sand", "sandy_loam_15", "sandy_loam_22", "clayey_38", "heavy_clay_25", "heavy_clay_40",
	"lean_clay_22", "lete_sand", "upland_loam_51", "snow_us", "snow_sweden", "lunar",
};
#define WONG_SOILS (sizeof wong_soils / sizeof *wong_soils)

static uint64_t random_state = 20261122;

/* 0 .. 1, the same in each run. */
static double random_share(void)
{
	random_state = random_state * 6364136223846793005u + 1442695040888963407u;
	return (double)(random_state >> 11) / (double)(1ull << 53);
}

static double between(double low, double high)
{
	return low + (high - low) * random_share();
}

static double between_powers(double low, double high)
{
	return low * pow(high / low, random_share());
}

static struct soil_numbers random_soil(void)
{
	return (struct soil_numbers){
		.bekker_kc = between(0, 1e5), .bekker_kphi = between_powers(1e4, 5e6), .bekker_n = between(0.1, 1.6),
		.cohesion = random_share() < 0.3 ? 0 : between_powers(100, 7e4), .friction_angle = between(0, 40) * RADIANS,
		.janosi_shear = between_powers(0.005, 0.05), .elastic_stiffness = between_powers(3e6, 1e9),
	};
}

static void two_derivations_agree(void **state)
{
	(void)state;
	double worst = 0;
	for (int i = 0; i < 200; i++) {
		struct soil_numbers soil = random_soil();
		struct reference_rolling wheel = {.radius = between_powers(0.05, 1), .rebound = i % 4 != 0};
		wheel.width = wheel.radius * between(0.2, 1.2);
		double slip = i % 20 == 0 ? -1 : i % 20 == 1 ? 0 : between(-1, 0.9);
		double sinkage = wheel.radius * between_powers(0.005, 0.7);
		wheel.turned = reference_turned(slip);
		for (int kind = 0; kind < 4; kind++) {
			wheel.normals = kind % 2 == 0 ? REFERENCE_NORMALS_GROUND : REFERENCE_NORMALS_SURFACE;
			wheel.follows = kind / 2 == 0 ? REFERENCE_FOLLOWS_SOIL : REFERENCE_FOLLOWS_RIM;
			struct reference_rolling_force got = reference_rolling(&soil, &wheel, sinkage);
			struct march_force other = march_wheel(&soil, &wheel, sinkage);
			/* Of all that presses, since a drawbar and a moment may be near 0. */
			double all = fabs(got.vertical) + fabs(got.drawbar) + fabs(got.moment) / wheel.radius;
			double off = fmax(fmax(fabs(got.drawbar - other.sums[0]), fabs(got.vertical - other.sums[1])),
					  fabs(got.moment - other.sums[2]) / wheel.radius) / all;
			worst = support_most(worst, off);
			if (!(off <= 1e-6))
				fail_msg("wheel %d, kind %d, n %g, slip %g, sinkage %g m, radius %g m, K %g m: off by %g", i, kind,
					 soil.bekker_n, slip, sinkage, wheel.radius, soil.janosi_shear, off);
		}
	}
	print_message("the two differ by %.2g at most\n", worst);
}

static void close_to(const char *what, double got, double wanted, double error)
{
	print_message("%-60s %11.4f, wanted %11.4f within %g\n", what, got, wanted, error);
	if (!(fabs(got - wanted) <= error))
		fail_msg("%s: %.9g, wanted %.9g", what, got, wanted);
}

/* Project Chrono's demonstration of soft soil. */
static struct soil_numbers soft_soil(void)
{
	return (struct soil_numbers){.bekker_kphi = 0.2e6, .bekker_n = 1.1, .friction_angle = 30 * RADIANS, .janosi_shear = 0.01,
				     .elastic_stiffness = 4e7};
}

/*
 * Wheel r 0.5 m, b 0.4 m. A build of Project Chrono 7689fbc with rays in double precision tells these to 1 %, the closed
 * forms to the newton that is printed. Those of the rim at 0.1 m are an integral by somebody else.
 */
static void chronos_soft_soil(void **state)
{
	(void)state;
	static const struct {
		enum reference_follows follows;
		double sinkage, slip, drawbar, vertical, moment;
	} rows[] = {
		{REFERENCE_FOLLOWS_SOIL, 0.1, 0, -627, 1350, 163}, {REFERENCE_FOLLOWS_SOIL, 0.1, 0.2, 643, 1350, -455},
		{REFERENCE_FOLLOWS_SOIL, 0.1, 0.5, 774, 1350, -515}, {REFERENCE_FOLLOWS_SOIL, 0.05, 0, -121, 451, 25},
		{REFERENCE_FOLLOWS_SOIL, 0.05, 0.2, 226, 451, -146}, {REFERENCE_FOLLOWS_SOIL, 0.05, 0.5, 258, 451, -161},
		{REFERENCE_FOLLOWS_RIM, 0.1, 0, -659, 1350, 178}, {REFERENCE_FOLLOWS_RIM, 0.1, 0.2, 624, 1350, -446},
		{REFERENCE_FOLLOWS_RIM, 0.1, 0.5, 767, 1350, -512},
	};
	struct soil_numbers soil = soft_soil();
	struct reference_rolling wheel = {.radius = 0.5, .width = 0.4, .normals = REFERENCE_NORMALS_GROUND, .rebound = true};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		wheel.follows = rows[i].follows;
		wheel.turned = reference_turned(rows[i].slip);
		struct reference_rolling_force got = reference_rolling(&soil, &wheel, rows[i].sinkage);
		close_to("Fx, N", got.drawbar, rows[i].drawbar, 0.56);
		close_to("Fz, N", got.vertical, rows[i].vertical, 0.5);
		close_to("My, N m", got.moment, rows[i].moment, 0.56);
	}
	close_to("sinkage of 2 kN, mm", 1e3 * reference_rolling_sinkage(&soil, &wheel, 2000), 128.5, 0.05);
	close_to("sinkage of 10 kN, mm", 1e3 * reference_rolling_sinkage(&soil, &wheel, 10000), 367.7, 0.05);
}

/* A kilonewton on dry_sand at slip 0.2. Those of the rim are printed elsewhere, those of the soil are not. */
static void a_kilonewton_on_dry_sand(void **state)
{
	(void)state;
	static const struct {
		const char *name;
		enum reference_normals normals;
		enum reference_follows follows;
		double millimetres, drawbar, moment, shear_moment;
	} rows[] = {
		{"ground, rim", REFERENCE_NORMALS_GROUND, REFERENCE_FOLLOWS_RIM, 34.32, 296.5, -138.0, -93.9},
		{"surface, rim", REFERENCE_NORMALS_SURFACE, REFERENCE_FOLLOWS_RIM, 33.40, 233.55, -119.5, -119.5},
		{"ground, soil", REFERENCE_NORMALS_GROUND, REFERENCE_FOLLOWS_SOIL, 34.32, 329.0, -148.3, -104.2},
		{"surface, soil", REFERENCE_NORMALS_SURFACE, REFERENCE_FOLLOWS_SOIL, 33.32, 262.25, -128.6, -128.6},
	};
	struct soil_numbers soil = bed_soil("dry_sand");
	struct reference_rolling wheel = {.radius = 0.32, .width = 0.24, .turned = reference_turned(0.2), .rebound = true};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		print_message("%s\n", rows[i].name);
		wheel.normals = rows[i].normals;
		wheel.follows = rows[i].follows;
		double sinkage = reference_rolling_sinkage(&soil, &wheel, 1000);
		struct reference_rolling_force got = reference_rolling(&soil, &wheel, sinkage);
		close_to("the load that is carried, N", got.vertical, 1000, 1e-5);
		close_to("sinkage, mm", sinkage * 1e3, rows[i].millimetres, 0.006);
		close_to("drawbar, N", got.drawbar, rows[i].drawbar, 0.06);
		close_to("moment, N m", got.moment, rows[i].moment, 0.06);
		close_to("of it shear's, N m", got.shear_moment, rows[i].shear_moment, 0.06);
	}
	double low = 0, high = 0.1;
	for (int i = 0; i < 50; i++) {
		double middle = (low + high) / 2;
		*(reference_standing_load(&soil, middle, wheel.width, wheel.radius) < 1000 ? &low : &high) = middle;
	}
	close_to("let down without rolling, mm", high * 1e3, 24.5, 0.05);
}

/* The older integrals by Simpson's rule, where they are of the same law. */
static void simpsons_rule_says_the_same(void **state)
{
	(void)state;
	struct soil_numbers soil = bed_soil("dry_sand");
	soil.cohesion = 0; /* it has a kink, which Simpson's rule does not know */
	struct reference_rolling wheel = {.radius = 0.32, .width = 0.24, .rebound = true};
	for (double sinkage = 0.001; sinkage < 0.3; sinkage *= 2) {
		wheel.normals = REFERENCE_NORMALS_GROUND;
		wheel.turned = 1;
		wheel.rebound = true;
		bed_near("the arc's load, N", reference_rolling(&soil, &wheel, sinkage).vertical,
			 reference_arc_load(&soil, sinkage, wheel.width, wheel.radius, true), 1e-6);
		struct reference_wheel other = {.radius = wheel.radius, .width = wheel.width, .slip = 0.3};
		wheel.normals = REFERENCE_NORMALS_SURFACE;
		wheel.follows = REFERENCE_FOLLOWS_RIM;
		wheel.turned = 1 / (1 - other.slip);
		wheel.rebound = false;
		struct reference_rolling_force got = reference_rolling(&soil, &wheel, sinkage);
		struct reference_wheel_forces wanted = reference_wong_reece(&soil, &other, sinkage);
		bed_near("load, N", got.vertical, wanted.load, 1e-6);
		bed_near("drawbar, N", got.drawbar, wanted.drawbar, 1e-5);
		bed_near("torque, N m", -got.moment, wanted.torque, 1e-6);
	}
}

static void the_sinkage_is_the_least(void **state)
{
	(void)state;
	static const double slips[] = {-1, -0.5, 0, 0.2, 0.8};
	int carried = 0;
	for (int i = 0; i < 60; i++) {
		struct soil_numbers soil = bed_soil(wong_soils[i % WONG_SOILS]);
		struct reference_rolling wheel = {.radius = 0.32, .width = 0.24, .turned = reference_turned(slips[i / 12]),
						  .normals = REFERENCE_NORMALS_SURFACE, .follows = REFERENCE_FOLLOWS_RIM,
						  .rebound = true};
		double load = between_powers(1, 5e4), sinkage = reference_rolling_sinkage(&soil, &wheel, load);
		double to = isnan(sinkage) ? wheel.radius : sinkage;
		carried += !isnan(sinkage);
		if (!isnan(sinkage) && sinkage > 1e-8)
			bed_near("the vertical force, N", reference_rolling(&soil, &wheel, sinkage).vertical, load, 1e-6);
		for (int step = 1; step < 100; step++)
			assert_true(reference_rolling(&soil, &wheel, to * step / 100).vertical < load);
	}
	print_message("%d of 60 are carried\n", carried);
	assert_true(carried >= 40);
	/* A locked wheel drags itself down: the force grows to 1434 N at 175 mm, and falls to 1040 N at the axle. */
	struct soil_numbers soil = bed_soil("sandy_loam_22");
	struct reference_rolling wheel = {.radius = 0.32, .width = 0.24, .normals = REFERENCE_NORMALS_SURFACE,
					  .follows = REFERENCE_FOLLOWS_RIM, .rebound = true};
	double sinkage = reference_rolling_sinkage(&soil, &wheel, 1200);
	print_message("a locked wheel under 1200 N: %.2f mm\n", sinkage * 1e3);
	assert_true(sinkage > 0 && sinkage < 0.175);
	assert_true(reference_rolling(&soil, &wheel, wheel.radius).vertical < 1200);
	assert_true(isnan(reference_rolling_sinkage(&soil, &wheel, 1500)));
}

/* p by the definition, and the sum of a box's strips or a sphere's rings: midpoints. */
static double pressure_of(const struct soil_numbers *soil, double width, double sinkage)
{
	return sinkage > 0 ? march_pressure(soil, width, sinkage) : 0;
}

/* The vertical force of a level box, or of one that lies on the slope, with what shear may hold. */
static double vertical_of(const struct soil_numbers *soil, bool level, double load, double slope, double sinkage)
{
	enum { STRIPS = 4000 };
	/* Of a level box only what is below the ground. */
	double length = level ? fmin(0.5, sinkage / sin(slope)) : 0.5, width = 0.3, normal = 0, holds = 0;
	for (int i = 0; i < STRIPS; i++) {
		double x = (i + 0.5) * length / STRIPS, strip = width * length / STRIPS / (level ? cos(slope) : 1);
		double deep = sinkage - (level ? x * sin(slope) : 0);
		const double pressure = deep > 0 ? pressure_of(soil, width, deep) : 0;
		normal += pressure * strip;
		holds += reference_strength(soil, &(struct soil_interface){.has_friction = false}, pressure) * strip;
	}
	double shear = fmin(load * sin(slope), holds);
	return normal * cos(slope) + shear * sin(slope);
}

static void a_box_on_a_slope_is_in_balance(void **state)
{
	(void)state;
	static const double loads[] = {1, 30, 1e3, 5e4};
	int checked = 0;
	for (size_t i = 0; i < WONG_SOILS; i++) {
		struct soil_numbers soil = bed_soil(wong_soils[i]);
		for (size_t l = 0; l < sizeof loads / sizeof *loads; l++)
			for (int part = 0; part <= 4; part++) {
				/* To 5 degrees below friction; at last 8 beyond, where only cohesion may hold. */
				double steep = part == 4 ? soil.friction_angle + 8 * RADIANS
							 : fmax(0, soil.friction_angle - 5 * RADIANS) * part / 3;
				for (int level = 0; level < 2; level++) {
					struct reference_rest rest = level ? reference_rest_level(&soil, 0.5, 0.3, loads[l], steep)
									   : reference_rest_flat(&soil, 0.5, 0.3, loads[l], steep);
					double other = vertical_of(&soil, level, loads[l], steep, rest.sinkage);
					assert_true(fabs(rest.vertical / loads[l] - 1) < 1e-9);
					/* The strips' error: the pressure begins steeply where n is small. */
					if (!(fabs(other / loads[l] - 1) < (level ? 1e-4 : 1e-9)))
						fail_msg("%s, %g N, %g degrees, level %d: %.9g N", wong_soils[i], loads[l],
							 steep / RADIANS, level, other);
					assert_true(vertical_of(&soil, level, loads[l], steep, rest.sinkage * 0.99) < loads[l]);
					/* As vectors: without a guide, below the angle of friction. */
					if (part < 4) {
						assert_true(fabs(rest.residual) <= 1e-9 * loads[l]);
						assert_true(fabs(rest.normal / (loads[l] * cos(steep)) - 1) < 1e-9);
					}
					/* The guide's push closes the sum of forces along the level. */
					double push = rest.normal * sin(steep) - rest.shear * cos(steep);
					assert_true(fabs(push - rest.residual / cos(steep)) < 1e-8 * loads[l]);
					checked++;
				}
			}
	}
	struct soil_numbers sand = bed_soil("dry_sand");
	struct reference_rest slides = reference_rest_flat(&sand, 0.5, 0.3, 5e4, 36 * RADIANS);
	print_message("%d boxes; 50 kN on dry_sand at 36 degrees: residual %.1f N\n", checked, slides.residual);
	assert_true(slides.residual > 0);
}

static void plates_and_spheres_settle(void **state)
{
	(void)state;
	struct soil_numbers soft = soft_soil();
	close_to("a plate of soft soil, 20 kPa, mm", 1e3 * reference_yield_sinkage(&soft, 0.1, 20e3), 123.28, 0.005);
	for (size_t i = 0; i < WONG_SOILS; i++) {
		struct soil_numbers soil = bed_soil(wong_soils[i]);
		double n = soil.bekker_n;
		for (double radius = 0.05; radius < 2; radius *= 3)
			for (double share = 0.001; share <= 1; share *= 10) {
				enum { RINGS = 20000 };
				double sinkage = radius * share, sum = 0, patch = sqrt(radius * radius - pow(radius - sinkage, 2));
				for (int ring = 0; ring < RINGS; ring++) {
					double at = (ring + 0.5) / RINGS * patch;
					double deep = sinkage - radius + sqrt(radius * radius - at * at);
					sum += pressure_of(&soil, patch, deep) * 2 * M_PI * at * patch / RINGS;
				}
				double load = reference_sphere_load(&soil, radius, sinkage);
				if (!(fabs(load / sum - 1) < 2e-5))
					fail_msg("%s: sphere %g m at %g m: %.9g N, wanted %.9g", wong_soils[i], radius, sinkage,
						 load, sum);
				double again = reference_sphere(&soil, load * (1 - 1e-12), radius);
				assert_true(fabs(again / sinkage - 1) < 1e-6);
			}
		/* Where nearly all of it is Bekker's curve. */
		double pressure = 50 * reference_yield(&soil, 0.3, reference_yield_crossing(&soil, 0.3));
		if (n >= 1)
			pressure = 20e3;
		double slow = reference_yield_sinkage(&soil, 0.3, pressure);
		if (n >= 0.5)
			bed_near("at once, and slowly", reference_plate_at_once(&soil, 0.3, pressure) / slow, pow(n + 1, 1 / n),
				 0.01);
		/* For any of them by its energy. */
		double most = reference_plate_at_once(&soil, 0.3, 20e3), work = 0;
		for (int step = 0; step < 100000; step++)
			work += pressure_of(&soil, 0.3, (step + 0.5) / 100000 * most) * most / 100000;
		bed_near("energy, J/m2", work, 20e3 * most, 1e-5);
	}
	assert_true(isnan(reference_sphere(&soft, 1e9, 0.1)));
}

TEST_PROGRAM(closed_forms)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(two_derivations_agree),
		cmocka_unit_test(chronos_soft_soil),
		cmocka_unit_test(a_kilonewton_on_dry_sand),
		cmocka_unit_test(simpsons_rule_says_the_same),
		cmocka_unit_test(the_sinkage_is_the_least),
		cmocka_unit_test(a_box_on_a_slope_is_in_balance),
		cmocka_unit_test(plates_and_spheres_settle),
	};
	return cmocka_run_group_tests_name("validation/closed_forms", tests, NULL, NULL);
}
