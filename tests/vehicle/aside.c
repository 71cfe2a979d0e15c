/*
 * A wheel on a straight guide, at an angle to its way, beside integrals along its rim in which the soil shears by the sum of both displacements
 * (Wong and Reece; Ishigami and others, Journal of Field Robotics 24, 2007). Without slip sinkage and faces, since the integrals have none.
 */
#include <math.h>

#include "drive.h"
#include "../support/program.h"

#define RADIUS 0.32
#define WIDTH 0.24
#define LOAD 1000.0
#define SPEED 0.4 /* m/s */
#define PARTS 400
#define RADIANS (3.14159265358979323846 / 180)

static const struct extent extent = {33, 33, 0.5, 64};

static double level(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return 100;
}

struct soil {
	const char *name;
	double kc, kphi, n, cohesion, friction, shear; /* docs/SOILS.md */
};
static const struct soil dry_sand = {"dry_sand", 990, 1528430, 1.1, 1040, 28, 0.02};
static const struct soil loam = {"sandy_loam_15", 5270, 1515040, 0.7, 1720, 29, 0.02};

/* The vertical force and the side force at a sinkage. */
static double vertical_at(const struct soil *soil, double sinkage, double slip, double tangent, double *side)
{
	const double stiffness = soil->kc / WIDTH + soil->kphi, first = acos(1 - sinkage / RADIUS), part = first / PARTS;
	double vertical = 0;
	*side = 0;
	for (int i = 0; i < PARTS; i++) {
		const double theta = (i + 0.5) * part, area = RADIUS * WIDTH * part, pressure = stiffness * pow(RADIUS * (cos(theta) - cos(first)), soil->n);
		const double along = RADIUS * (first - theta - (1 - slip) * (sin(first) - sin(theta))), across = RADIUS * (1 - slip) * (first - theta) * tangent;
		const double way = hypot(along, across), shear = (soil->cohesion + pressure * tan(soil->friction * RADIANS)) * (1 - exp(-way / soil->shear));
		vertical += area * (pressure * cos(theta) + shear * along / way * sin(theta));
		*side += area * shear * across / way;
	}
	return vertical;
}

static double side_of(const struct soil *soil, double slip, double tangent)
{
	double low = 1e-4, high = 0.2, side;
	for (int i = 0; i < 50; i++) {
		const double middle = (low + high) / 2;
		*(vertical_at(soil, middle, slip, tangent, &side) < LOAD ? &low : &high) = middle;
	}
	return side;
}

/* The mean of the soil's force across the wheel, to its left, over the last second. */
static double driven(const struct soil *soil, double slip, double angle)
{
	char text[2048];
	const char *store = support_path("level.furrow");
	snprintf(text, sizeof text,
		 "<mujoco><option timestep=\"0.002\" integrator=\"implicit\"/><worldbody><body name=\"carriage\" pos=\"0 0 0.5\">"
		 "<joint name=\"x\" type=\"slide\" axis=\"1 0 0\"/><joint name=\"z\" type=\"slide\" axis=\"0 0 1\"/>"
		 "<inertial pos=\"0 0 0\" mass=\"%g\" diaginertia=\"5 5 5\"/><body euler=\"0 0 %g\"><joint name=\"turn\" axis=\"0 1 0\" armature=\"0.5\"/>"
		 "<geom name=\"wheel\" type=\"cylinder\" size=\"%g %g\" euler=\"90 0 0\" mass=\"30\"/></body></body></worldbody><actuator>"
		 "<velocity name=\"drive\" joint=\"turn\" kv=\"20000\"/><velocity name=\"go\" joint=\"x\" kv=\"200000\"/></actuator></mujoco>",
		 LOAD / 9.81 - 30, -angle, RADIUS, WIDTH / 2);
	support_write(support_path("wheel.xml"), text);
	snprintf(text, sizeof text, "t,drive,go\n0,0,0\n0.5,%g,%g\n", SPEED * cos(angle * RADIANS) / RADIUS / (1 - slip), SPEED);
	support_write(support_path("controls.csv"), text);
	snprintf(text, sizeof text, "scene: 1\nend_time: 4\ntime_step: 0.002\nspacing: 0.02\nsoil: {name: %s, damping: 0}\n"
				    "redistribute: {model: scm, slip_sinkage: 0, faces: off}\nvehicles:\n  - {name: v, model: wheel.xml, start: {at: [5, 8]}, "
				    "driver: {controls: controls.csv}}\noutput: {vehicles: 20, forces: 20}\n", soil->name);
	support_write(support_path("scene.yaml"), text);
	support_store(store, extent, level);
	must(make_drive(support_path("scene.yaml"), store, NULL, &(struct drive_cut){.out = support_path("out")}, NULL));
	char *rows = support_text(support_path("out/objects.csv"));
	double sum = 0, count = 0;
	for (char *line = strchr(rows, '\n'); line != NULL && line[1] != '\0'; line = strchr(line + 1, '\n')) {
		double t, fx, fy;
		assert_int_equal(sscanf(line + 1, "%lf,%*[^,],%*f,%*f,%*f,%*f,%lf,%lf", &t, &fx, &fy), 3);
		if (t <= 3)
			continue;
		sum += fx * sin(angle * RADIANS) + fy * cos(angle * RADIANS);
		count++;
	}
	free(rows);
	assert_true(count >= 19);
	return sum / count;
}

static void a_wheel_at_an_angle_has_the_side_force_of_the_integrals(void **state)
{
	static const struct {
		const struct soil *soil;
		double slip, angle;
	} trials[] = {{&dry_sand, 0.2, 5}, {&dry_sand, 0.4, 15}, {&loam, 0.1, 10}};
	(void)state;
	for (size_t i = 0; i < sizeof trials / sizeof *trials; i++) {
		const double wanted = side_of(trials[i].soil, trials[i].slip, tan(trials[i].angle * RADIANS));
		const double got = -driven(trials[i].soil, trials[i].slip, trials[i].angle);
		print_message("%s, slip %g, %g degrees: %.1f N across, by the integral %.1f N\n", trials[i].soil->name, trials[i].slip, trials[i].angle, got, wanted);
		assert_true(fabs(got - wanted) < 0.15 * wanted); /* soil that springs back behind the axle bears, too: the integrals end at the lowest point */
	}
}

TEST_PROGRAM(aside)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(a_wheel_at_an_angle_has_the_side_force_of_the_integrals)};
	return cmocka_run_group_tests_name("a wheel at an angle to its way", tests, support_enter, support_leave);
}
