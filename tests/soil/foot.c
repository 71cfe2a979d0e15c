/*
 * A box that is tilted, as a foot is: its sole and its walls balance. Forces of a box that sinks straight down are compared with an integral over its lower
 * faces in doubles, at 64 places within a post, and with each other as the box moves a little.
 */
#include "bed.h"
#include "../support/near.h"
#include "../support/program.h"

#define SIDE 64
#define PLACES 8
#define DEPTH 0.03 /* m */
#define STEPS 100

struct foot {
	double size[3], pitch, roll, yaw; /* m; degrees */
};

/* Forces and moments along the foot's heading, to its left, up. N, N m. */
struct felt {
	double at[6];
};

static struct bed bed_of(double spacing)
{
	struct bed bed;
	struct soil_numbers soil = bed_soil("dry_sand");
	bed_init(&bed, &soil, spacing, SIDE, 0, 0);
	bed.law.bulldozing = 0;
	return bed;
}

/* Returns how far its lowest corner is below its centre, m. */
static double reach_of(const struct foot *foot)
{
	double axes[3][3], reach = 0;
	soil_axes(0, foot->pitch * DEGREES, foot->roll * DEGREES, 0, axes);
	for (int k = 0; k < 3; k++)
		reach += fabs(axes[k][2]) * foot->size[k] / 2;
	return reach;
}

/* Lowers the foot straight down in so many motions, so that its lowest corner is `depth` below the ground, and returns what it feels. */
static struct felt felt_at(struct bed *bed, const struct foot *foot, double x, double y, double depth, int motions, bool friction)
{
	const struct soil_shape shape = {.kind = SOIL_BOX, .size = {foot->size[0], foot->size[1], foot->size[2]}};
	const double top = bed->height + reach_of(foot), yaw = foot->yaw * DEGREES, c = cos(yaw), s = sin(yaw);
	struct soil_motion motion;
	bed_reset(bed);
	for (int i = 0; i < motions; i++) {
		const struct bed_state from = bed_state(x, y, top + 0.001 - (depth + 0.001) * i / motions, yaw, foot->pitch * DEGREES, foot->roll * DEGREES);
		const struct bed_state to = bed_state(x, y, top + 0.001 - (depth + 0.001) * (i + 1) / motions, yaw, foot->pitch * DEGREES, foot->roll * DEGREES);
		motion = bed_motion(&shape, &from, &to, NULL);
		motion.interface.has_friction = motion.interface.has_adhesion = !friction;
		if (i + 1 < motions)
			bed_press(bed, &motion, 0);
	}
	const struct soil_forces f = bed_feel(bed, &motion, 0);
	return (struct felt){{c * f.force[0] + s * f.force[1], c * f.force[1] - s * f.force[0], f.force[2], c * f.moment[0] + s * f.moment[1], c * f.moment[1] - s * f.moment[0], f.moment[2]}};
}

struct range {
	struct felt low, high, mean;
};

static struct range felt_at_all(const struct foot *foot, double spacing, int motions, bool friction)
{
	struct bed bed = bed_of(spacing);
	struct range range = {.mean = {{0}}};
	for (int i = 0; i < PLACES * PLACES; i++) {
		const double x = spacing * (SIDE / 2 + 0.013 + (double)(i % PLACES) / PLACES), y = spacing * (SIDE / 2 + 0.017 + (double)(i / PLACES) / PLACES);
		const struct felt felt = felt_at(&bed, foot, x, y, DEPTH, motions, friction);
		for (int k = 0; k < 6; k++) {
			range.low.at[k] = i == 0 ? felt.at[k] : fmin(range.low.at[k], felt.at[k]);
			range.high.at[k] = i == 0 ? felt.at[k] : fmax(range.high.at[k], felt.at[k]);
			range.mean.at[k] += felt.at[k] / (PLACES * PLACES);
		}
	}
	bed_finish(&bed);
	return range;
}

static double largest(const struct range *range, int k)
{
	return fmax(fabs(range->low.at[k]), fabs(range->high.at[k]));
}

static double spread(const struct range *range, int k)
{
	return range->high.at[k] - range->low.at[k];
}

/* --- the integral --- */

/* Adds what a lower face bears: a parallelogram of small parts. normal: into the box. */
static void add_face(const double corner[3], const double u[3], const double v[3], const double normal[3], const struct soil_numbers *soil, double k, bool friction, struct felt *sum)
{
	const int parts = 250;
	const double area = fabs(u[0] * v[1] - u[1] * v[0]) / (parts * parts), slides = sqrt(1 - normal[2] * normal[2]);
	for (int i = 0; i < parts; i++)
		for (int j = 0; j < parts; j++) {
			double at[3], force[3];
			for (int n = 0; n < 3; n++)
				at[n] = corner[n] + (i + 0.5) / parts * u[n] + (j + 0.5) / parts * v[n];
			const double deep = -at[2];
			if (deep <= 0)
				continue;
			const double p = k * pow(deep, soil->bekker_n), strength = fmin(1, p / soil->cohesion) * soil->cohesion + p * tan(soil->friction_angle);
			const double shear = friction ? strength * (1 - exp(-deep * slides / soil->janosi_shear)) : 0;
			for (int n = 0; n < 3; n++)
				force[n] = area / normal[2] * (p * normal[n] + shear * ((n == 2) - normal[2] * normal[n]) / fmax(slides, 1e-12));
			for (int n = 0; n < 3; n++) {
				sum->at[n] += force[n];
				sum->at[3 + n] += at[(n + 1) % 3] * force[(n + 2) % 3] - at[(n + 2) % 3] * force[(n + 1) % 3];
			}
		}
}

/* The same as felt_at of a foot of which the ends that look up are out of the soil. Moments are about its centre. */
static struct felt integral(const struct foot *foot, bool friction)
{
	const struct soil_numbers soil = bed_soil("dry_sand");
	const double k = soil.bekker_kc / fmin(foot->size[0], foot->size[1]) + soil.bekker_kphi, up = reach_of(foot) - DEPTH;
	double a[3][3];
	struct felt sum = {{0}};
	soil_axes(0, foot->pitch * DEGREES, foot->roll * DEGREES, 0, a);
	for (int i = 0; i < 3; i++) {
		const int m = (i + 1) % 3, n = (i + 2) % 3;
		double corner[3], u[3], v[3], normal[3];
		for (int c = 0; c < 3; c++) {
			const double sign[3] = {a[0][2] < 0 ? -1 : 1, a[1][2] < 0 ? -1 : 1, a[2][2] < 0 ? -1 : 1};
			normal[c] = sign[i] * a[i][c];
			u[c] = sign[m] * a[m][c] * foot->size[m];
			v[c] = sign[n] * a[n][c] * foot->size[n];
			corner[c] = -0.5 * (normal[c] * foot->size[i] + u[c] + v[c]) + (c == 2 ? up : 0);
		}
		if (normal[2] > 1e-9)
			add_face(corner, u, v, normal, &soil, k, friction, &sum);
	}
	/* From the ground below the centre to the centre. */
	sum.at[3] += up * sum.at[1];
	sum.at[4] -= up * sum.at[0];
	return sum;
}

/* --- tests --- */

static const double spacings[] = {0.031, 0.016, 0.008};

static void without_friction_no_level_force_is_left(void **state)
{
	static const struct foot feet[] = {
		{{0.2, 0.1, 0.1}, -10, 0, 0}, {{0.2, 0.1, 0.1}, -10, 0, 30}, {{0.1, 0.1, 0.1}, -10, 0, 45}, {{0.2, 0.1, 0.1}, -2, 0, 30}, {{0.1, 0.2, 0.1}, 5, 0, 10},
		{{0.2, 0.1, 0.1}, -20, 0, 45}, {{0.2, 0.1, 0.1}, -30, 0, 0}, {{0.2, 0.1, 0.1}, -10, 8, 30}, {{0.2, 0.1, 0.1}, 1.2, -0.3, 70},
	};
	for (size_t i = 0; i < COUNT(feet); i++)
		for (size_t k = 0; k < COUNT(spacings); k++) {
			const struct range r = felt_at_all(&feet[i], spacings[k], k == 1 ? 8 : 1, false);
			const double load = r.mean.at[2];
			print_message("foot %g m, pitch %g, roll %g, yaw %g, posts of %g mm: %.1f N, level forces up to %.2f and %.2f %%, spread of the load %.2f %%\n", feet[i].size[0], feet[i].pitch,
				      feet[i].roll, feet[i].yaw, spacings[k] * 1e3, load, 100 * largest(&r, 0) / load, 100 * largest(&r, 1) / load, 100 * spread(&r, 2) / load);
			assert_true(largest(&r, 0) < 0.01 * load && largest(&r, 1) < 0.01 * load);
			assert_true(spread(&r, 2) < 0.01 * load);
		}
}

static void load_and_moment_are_those_of_the_integral(void **state)
{
	static const struct foot feet[] = {{{0.2, 0.1, 0.1}, -10, 0, 0}, {{0.2, 0.1, 0.1}, -10, 0, 30}, {{0.2, 0.1, 0.1}, -20, 0, 45}, {{0.2, 0.2, 0.1}, -12, 10, 20}};
	for (size_t i = 0; i < COUNT(feet); i++)
		for (int friction = 0; friction < 2; friction++) {
			const struct felt wanted = integral(&feet[i], friction == 1);
			const double load = wanted.at[2], moment = hypot(wanted.at[3], wanted.at[4]);
			for (size_t k = 0; k < COUNT(spacings); k++) {
				const struct range r = felt_at_all(&feet[i], spacings[k], friction == 1 ? 10 : 1, friction == 1);
				print_message("pitch %g, roll %g, yaw %g, friction %d, posts of %g mm: %.1f %.1f %.1f N, %.2f %.2f N m, integral %.1f %.1f %.1f N, %.2f %.2f N m\n", feet[i].pitch, feet[i].roll,
					      feet[i].yaw, friction, spacings[k] * 1e3, r.mean.at[0], r.mean.at[1], r.mean.at[2], r.mean.at[3], r.mean.at[4], wanted.at[0], wanted.at[1], wanted.at[2],
					      wanted.at[3], wanted.at[4]);
				for (int n = 0; n < 3; n++) {
					assert_near(r.low.at[n], wanted.at[n], 0.02 * load);
					assert_near(r.high.at[n], wanted.at[n], 0.02 * load);
				}
				for (int n = 3; n < 5; n++) {
					assert_near(r.low.at[n], wanted.at[n], 0.02 * moment);
					assert_near(r.high.at[n], wanted.at[n], 0.02 * moment);
				}
			}
		}
}

static void with_friction_places_differ_little(void **state)
{
	static const double pitches[] = {-2, -5, -10, -20};
	for (size_t i = 0; i < COUNT(pitches); i++)
		for (size_t k = 0; k < COUNT(spacings); k++) {
			const struct foot foot = {{0.2, 0.1, 0.1}, pitches[i], 0, i % 2 == 0 ? 0 : 30};
			const struct range r = felt_at_all(&foot, spacings[k], k == 0 ? 10 : 1, true);
			print_message("pitch %g, posts of %g mm: spreads %.2f %.2f %.2f %%\n", foot.pitch, spacings[k] * 1e3, 100 * spread(&r, 0) / r.mean.at[2], 100 * spread(&r, 1) / r.mean.at[2],
				      100 * spread(&r, 2) / r.mean.at[2]);
			assert_true(spread(&r, 2) < 0.02 * r.mean.at[2]);
		}
}

/* As a foot moves by micrometres, or turns as little, no force jumps by more than half a percent of its load. It turns through level, too. */
static void nothing_jumps(void **state)
{
	for (size_t k = 0; k < COUNT(spacings); k++)
		for (int turn = 0; turn < 4; turn++) {
			struct bed bed = bed_of(spacings[k]);
			struct felt last = {{0}};
			double most = 0;
			for (int i = 0; i < STEPS; i++) {
				struct foot foot = {{0.2, 0.1, 0.1}, -10, 2, 25};
				foot.pitch += turn == 1 ? 0.002 * i : turn == 2 ? 10 + 0.002 * (i - STEPS / 2) : 0;
				foot.roll += turn == 2 ? -2 : 0;
				foot.yaw += turn == 3 ? 0.002 * i : 0;
				const double x = spacings[k] * (SIDE / 2 + 0.1) + (turn == 0 ? 3e-6 * i : 0), y = spacings[k] * (SIDE / 2 + 0.3);
				const struct felt felt = felt_at(&bed, &foot, x, y, DEPTH, 10, true);
				for (int n = 0; n < 3 && i > 0; n++)
					most = support_most(most, fabs(felt.at[n] - last.at[n]) / felt.at[2]);
				last = felt;
			}
			print_message("posts of %g mm, %d: steps of at most %.3f %%\n", spacings[k] * 1e3, turn, 100 * most);
			assert_true(most < 0.005);
			bed_finish(&bed);
		}
}

TEST_PROGRAM(foot)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(without_friction_no_level_force_is_left),
		cmocka_unit_test(load_and_moment_are_those_of_the_integral),
		cmocka_unit_test(with_friction_places_differ_little),
		cmocka_unit_test(nothing_jumps),
	};
	return cmocka_run_group_tests_name("soil/foot", tests, NULL, NULL);
}
