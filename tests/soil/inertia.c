/*
 * The inertia of soil that a fast body throws away: lambda rho v^2 on each face that moves into the soil at v along its normal. The closed form is of a box
 * whose faces are upright: the momentum that its faces give to the soil ahead of them each second.
 */
#include "bed.h"
#include "../support/near.h"
#include "../support/program.h"

#define SIDE 192
#define DEPTH 0.15

static const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.03, 0.06, 0.6}}, wheel = {.kind = SOIL_WHEEL, .radius = 0.25, .width = 0.1};

static struct bed bed_of(double spacing)
{
	struct bed bed;
	struct soil_numbers soil = bed_soil("dry_sand");
	bed_init(&bed, &soil, spacing, SIDE, 0, 0);
	bed.law.faces = true;
	return bed;
}

/* Pushes a body along at a depth, and returns the motion of the last half of a post, whose contact was not made. heading, yaw: rad; turn: a wheel's, rad for each metre. */
static struct soil_motion pushed(struct bed *bed, const struct soil_shape *shape, double heading, double yaw, double turn)
{
	const double step = 0.5 * bed->law.spacing, middle = SIDE / 2 * bed->law.spacing, c = cos(heading), s = sin(heading), reach = shape->kind == SOIL_BOX ? 0.3 : 0.25;
	const int steps = (int)ceil(0.15 / step);
	struct soil_trend trend = {.whole = {.ran = 0}};
	struct soil_motion motion = {.shape = shape};
	for (int i = 1; i <= steps; i++) {
		const double from = (i - 1 - steps) * step, to = (i - steps) * step, z = bed->height + reach - (shape->kind == SOIL_BOX ? DEPTH : 0.06);
		const struct bed_state a = bed_state(middle + from * c, middle + from * s, z, yaw, 0, 0), b = bed_state(middle + to * c, middle + to * s, z, yaw, 0, 0);
		motion = bed_motion(shape, &a, &b, NULL);
		motion.turned = turn * step;
		motion.trend = trend;
		if (i < steps) {
			bed_press(bed, &motion, 0);
			trend = soil_trend_after(&bed->law, &motion);
		}
	}
	return motion;
}

/* Returns what inertia adds to the force, N: by a contact and by a probe of the same motion, which must agree. */
static void adds(struct bed *bed, const struct soil_motion *motion, double lambda, double more[3])
{
	struct soil_forces forces[2];
	for (int i = 0; i < 2; i++) {
		bed->law.inertia = i * lambda;
		forces[i] = bed_feel(bed, motion, 0);
	}
	for (int k = 0; k < 3; k++)
		more[k] = forces[1].force[k] - forces[0].force[k];
}

static void a_plate_throws_soil_away(void **state)
{
	static const double speeds[] = {0.05, 1, 5}, yaws[] = {0, 30, 60}, spacings[] = {0.008, 0.004};
	const double density = bed_soil("dry_sand").density;
	(void)state;
	for (int n = 0; n < 2; n++)
		for (int k = 0; k < 3; k++) {
			struct bed bed = bed_of(spacings[n]);
			const double heading = 0.2, yaw = yaws[k] * DEGREES, sides[2] = {0.06, 0.03}, into[2] = {cos(yaw), sin(yaw)};
			struct soil_motion motion = pushed(&bed, &plate, heading, heading - yaw, 0);
			const double still = hypot(bed_feel(&bed, &motion, 0).force[0], bed_feel(&bed, &motion, 0).force[1]);
			for (int i = 0; i < 3; i++) {
				double more[2][3], wanted[2] = {0, 0};
				struct soil_motion fast = motion;
				fast.linear[0] = speeds[i] * cos(heading);
				fast.linear[1] = speeds[i] * sin(heading);
				adds(&bed, &fast, 1.1, more[0]);
				fast = motion; /* on a path: the same speed by the time that the motion took */
				fast.seconds = 0.5 * spacings[n] / speeds[i];
				adds(&bed, &fast, 1.1, more[1]);
				for (int face = 0; face < 2; face++) {
					const double area = sides[face] * DEPTH, pressure = 1.1 * density * pow(speeds[i] * into[face], 2);
					const double out = heading - yaw + face * M_PI / 2;
					wanted[0] -= pressure * area * cos(out);
					wanted[1] -= pressure * area * sin(out);
				}
				print_message("posts of %g mm, yawed by %g degrees, %g m/s: %.4f %.4f N more, closed form %.4f %.4f N, without it %.1f N\n", spacings[n] * 1e3, yaws[k], speeds[i],
					      more[0][0], more[0][1], wanted[0], wanted[1], still);
				for (int a = 0; a < 2; a++) {
					assert_near(more[a][0], wanted[0], 0.01 * hypot(wanted[0], wanted[1]) + 0.003);
					assert_near(more[a][1], wanted[1], 0.01 * hypot(wanted[0], wanted[1]) + 0.003);
					assert_near(more[a][2], 0, 0.01 * hypot(wanted[0], wanted[1]) + 0.003);
				}
				if (speeds[i] < 0.1)
					assert_true(hypot(more[0][0], more[0][1]) < 1e-3 * still);
			}
			bed_finish(&bed);
		}
}

static void without_a_speed_the_bits_are_the_same(void **state)
{
	struct bed bed = bed_of(0.008);
	const struct soil_motion motions[] = {pushed(&bed, &plate, 0.2, 0.6, 0), pushed(&bed, &wheel, 0.2, 0.7, 2)};
	(void)state;
	for (int i = 0; i < 2; i++) {
		bed.law.inertia = 0;
		const struct soil_forces none = bed_feel(&bed, &motions[i], 0);
		bed.law.inertia = 1;
		const struct soil_forces some = bed_feel(&bed, &motions[i], 0);
		assert_memory_equal(none.force, some.force, sizeof none.force);
		assert_memory_equal(none.moment, some.moment, sizeof none.moment);
	}
	bed_finish(&bed);
}

/* However a body moves and turns, it takes energy alone. And a probe tells how it grows with the speed. */
static void it_takes_energy_and_is_told_as_damping(void **state)
{
	struct bed bed = bed_of(0.01);
	const struct soil_motion motions[] = {pushed(&bed, &plate, 0.2, 0.6, 0), pushed(&bed, &wheel, 0.2, 0.7, 2)};
	unsigned seed = 7;
	double most = 0;
	(void)state;
	for (int i = 0; i < 60; i++) {
		struct soil_motion motion = motions[i % 2];
		struct soil_probed probed[2];
		double power = 0, off = 0, size = 0;
		for (int k = 0; k < 3; k++) {
			seed = seed * 1664525 + 1013904223;
			motion.linear[k] = (double)(seed >> 8) / (1 << 23) - 1;
			seed = seed * 1664525 + 1013904223;
			motion.angular[k] = 4 * ((double)(seed >> 8) / (1 << 23) - 1);
		}
		for (int n = 0; n < 2; n++) {
			bed.law.inertia = n;
			probed[n] = bed_probe(&bed, &motion);
		}
		for (int k = 0; k < 3; k++)
			power += (probed[1].force[k] - probed[0].force[k]) * motion.linear[k] + (probed[1].moment[k] - probed[0].moment[k]) * motion.angular[k];
		assert_true(power <= 0);
		most = support_most(most, -power);
		/* What the matrix has more, times the speed, is twice the force: it grows as the square of the speed. */
		for (int k = 0; k < 3; k++) {
			double told = 0;
			for (int j = 0; j < 3; j++) {
				told += (probed[1].damping[k][j] - probed[0].damping[k][j]) * motion.linear[j];
				told += (probed[1].damping[k][3 + j] - probed[0].damping[k][3 + j]) * motion.angular[j];
			}
			off = support_most(off, fabs(told - 2 * (probed[1].force[k] - probed[0].force[k])));
			size = support_most(size, fabs(told));
		}
		assert_true(off < 1e-3 * size + 0.01);
	}
	print_message("it takes up to %.1f W\n", most);
	assert_true(most > 10);
	bed_finish(&bed);
}

TEST_PROGRAM(inertia)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_plate_throws_soil_away),
		cmocka_unit_test(without_a_speed_the_bits_are_the_same),
		cmocka_unit_test(it_takes_energy_and_is_told_as_damping),
	};
	return cmocka_run_group_tests_name("soil/inertia", tests, NULL, NULL);
}
