/*
 * Forces at a slip angle beside integrals along the rim, in which the soil shears by the sum of both displacements (Wong and Reece; Ishigami
 * and others 2007). The curves of the wheel are those of the same integrals without a slip angle, at the curves' loads and slips.
 */
#include <math.h>

#include "../support.h"
#include "../support/near.h"
#include "../support/program.h"
#include "trials/trials.h"

#define RADIANS (3.14159265358979323846 / 180)
#define PARTS 400

/* Numbers of docs/SOILS.md. */
struct soil {
	const char *name;
	double kc, kphi, n, cohesion, friction, shear;
};
static const struct soil soils[] = {
	{"dry_sand", 990, 1528430, 1.1, 1040, 28, 0.02}, {"sandy_loam_15", 5270, 1515040, 0.7, 1720, 29, 0.02}, {"lunar", 1400, 820000, 1, 170, 35, 0.018},
};

struct forces {
	double vertical, drawbar, side, torque;
};

static struct forces at_sinkage(const struct soil *soil, double radius, double width, double sinkage, double slip, double tangent)
{
	const double stiffness = soil->kc / width + soil->kphi, first = acos(1 - sinkage / radius), part = first / PARTS;
	struct forces sum = {0, 0, 0, 0};
	for (int i = 0; i < PARTS; i++) {
		const double theta = (i + 0.5) * part, area = radius * width * part;
		const double pressure = stiffness * pow(radius * (cos(theta) - cos(first)), soil->n);
		const double along = radius * (first - theta - (1 - slip) * (sin(first) - sin(theta))), across = radius * (1 - slip) * (first - theta) * tangent;
		const double way = hypot(along, across);
		const double shear = (soil->cohesion + pressure * tan(soil->friction * RADIANS)) * (1 - exp(-way / soil->shear));
		const double pulls = way > 0 ? shear * along / way : 0;
		sum.vertical += area * (pressure * cos(theta) + pulls * sin(theta));
		sum.drawbar += area * (pulls * cos(theta) - pressure * sin(theta));
		sum.side += way > 0 ? area * shear * across / way : 0;
		sum.torque += area * pulls * radius;
	}
	return sum;
}

/* Returns the sinkage at which it carries the load. */
static double sinkage_of(const struct soil *soil, double radius, double width, double load, double slip, double tangent)
{
	double low = 1e-5, high = radius / 2;
	for (int i = 0; i < 50; i++) {
		const double middle = (low + high) / 2;
		*(at_sinkage(soil, radius, width, middle, slip, tangent).vertical < load ? &low : &high) = middle;
	}
	return (low + high) / 2;
}

static void fill(const struct soil *soil, double mean, struct mobility_wheel_curves *curves)
{
	for (size_t l = 0; l < MOBILITY_LOADS; l++) {
		curves->loads[l] = mean * (0.2 + 0.4 * (double)l);
		for (size_t s = 0; s < MOBILITY_SLIPS; s++) {
			const double sinkage = sinkage_of(soil, curves->radius, curves->width, curves->loads[l], trials_slips[s], 0);
			const struct forces forces = at_sinkage(soil, curves->radius, curves->width, sinkage, trials_slips[s], 0);
			curves->points[l][s] = (struct mobility_point){forces.drawbar, forces.torque, sinkage, sinkage, true};
		}
	}
}

static void a_slip_angle_gives_the_forces_of_the_integrals(void **state)
{
	static const double sizes[][3] = {{0.32, 0.24, 1000}, {0.4, 0.2, 2500}, {0.15, 0.15, 120}}; /* radius, width, mean load */
	double worst_of_all = 0;
	(void)state;
	for (size_t i = 0; i < sizeof soils / sizeof *soils; i++)
		for (size_t k = 0; k < 3; k++) {
			struct mobility_wheel_curves curves = {.radius = sizes[k][0], .width = sizes[k][1]};
			double worst = 0, side_worst = 0, rim_worst = 0;
			fill(&soils[i], sizes[k][2], &curves);
			for (double angle = 2; angle < 40; angle += 9)
				for (double slip = 0.05; slip < 0.7; slip += 0.2) {
					const double load = sizes[k][2] * 1.4, tangent = tan(angle * RADIANS);
					const double sinkage = sinkage_of(&soils[i], curves.radius, curves.width, load, slip, tangent);
					const struct forces wanted = at_sinkage(&soils[i], curves.radius, curves.width, sinkage, slip, tangent);
					struct mobility_wheel wheel;
					trials_wheel_load(&curves, load, &wheel);
					const struct mobility_pull got = trials_wheel_at(&wheel, slip, tangent);
					worst = support_most(worst, fabs(got.drawbar - wanted.drawbar) / load);
					side_worst = support_most(side_worst, fabs(got.side - wanted.side) / load);
					rim_worst = support_most(rim_worst, fabs(got.torque - wanted.torque) / curves.radius / load);
				}
			print_message("%s, r %g m: drawbar within %.3f of the load, side force within %.3f, torque within %.3f of it times r\n", soils[i].name,
				      curves.radius, worst, side_worst, rim_worst);
			worst_of_all = support_most(worst_of_all, support_most(worst, support_most(side_worst, rim_worst)));
		}
	assert_true(worst_of_all < 0.085);
}

/* That a braked wheel digs itself in says nothing of one that is driven, at a slip angle either. */
static void a_driven_wheel_digs_by_its_own_curve(void **state)
{
	struct mobility_wheel_curves curves = {.radius = 0.32, .width = 0.24};
	struct mobility_wheel wheel;
	(void)state;
	fill(&soils[0], 1000, &curves);
	for (size_t l = 0; l < MOBILITY_LOADS; l++)
		for (size_t s = 0; trials_slips[s] < 0; s++)
			curves.points[l][s].steady = false;
	trials_wheel_load(&curves, 1000, &wheel);
	assert_true(trials_wheel_at(&wheel, 0.2, 0.1).steady && !trials_wheel_at(&wheel, -0.2, 0.1).steady);
	for (size_t l = 0; l < MOBILITY_LOADS; l++)
		for (size_t s = 0; s < MOBILITY_SLIPS; s++)
			curves.points[l][s].steady = trials_slips[s] < 0.2;
	trials_wheel_load(&curves, 1000, &wheel);
	/* Sliding aside shears as much as a slip of 0.4. */
	assert_true(trials_wheel_at(&wheel, 0.05, 0.05).steady && !trials_wheel_at(&wheel, 0.05, 0.4).steady);
}

static void without_a_slip_angle_it_is_the_curve(void **state)
{
	struct mobility_wheel_curves curves = {.radius = 0.32, .width = 0.24};
	(void)state;
	fill(&soils[0], 1000, &curves);
	struct mobility_wheel wheel;
	for (size_t l = 0; l < MOBILITY_LOADS; l++)
		for (size_t s = 0; s < MOBILITY_SLIPS; s++) {
			const struct mobility_point *point = &curves.points[l][s];
			trials_wheel_load(&curves, curves.loads[l], &wheel);
			const struct mobility_pull straight = trials_wheel_at(&wheel, trials_slips[s], 0);
			/* A tiny angle changes nothing. */
			const struct mobility_pull nearly = trials_wheel_at(&wheel, trials_slips[s], 1e-9);
			assert_true(straight.side == 0 && fabs(straight.drawbar - point->drawbar) < 1e-6 && fabs(straight.torque - point->torque) < 1e-6);
			assert_true(fabs(nearly.drawbar - straight.drawbar) < 1e-3 && fabs(nearly.side) < 1e-3);
		}
	trials_wheel_load(&curves, 1000, &wheel);
	const double slip = trials_wheel_free_slip(&wheel);
	assert_true(slip < 0 && fabs(trials_wheel_straight(&wheel, slip).torque) < 1e-6);
}

TEST_PROGRAM(wheel)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_slip_angle_gives_the_forces_of_the_integrals),
		cmocka_unit_test(a_driven_wheel_digs_by_its_own_curve),
		cmocka_unit_test(without_a_slip_angle_it_is_the_curve),
	};
	return cmocka_run_group_tests_name("trials/wheel", tests, NULL, NULL);
}
