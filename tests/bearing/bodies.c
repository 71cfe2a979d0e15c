/* Bodies of any attitude under scm: cylinders, capsules, ellipsoids. Wheels with camber: camber.c. */
#include "ground.h"

#include "soil/shape/lower_envelope.h"
#include "../support/program.h"

static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2};

static void init(struct ground *ground, const struct soil_numbers *soil, double spacing)
{
	ground_init(ground, &(struct ground_params){.cells = 64, .tiles = 2, .first = 2, .spacing = spacing, .soils = soil});
}

/* --- shapes that are others --- */

static struct deform_forces press(struct ground *ground, const struct soil_shape *shape, const struct soil_pose *attitude, double deep,
				  const double way[3], int steps)
{
	struct deform_contact contact = {.shape = shape};
	contact.to = ground_pose(ground, 64.2, 64.7, soil_shape_reach(shape, attitude->pitch, attitude->roll) - deep);
	contact.to.yaw = attitude->yaw;
	contact.to.pitch = attitude->pitch;
	contact.to.roll = attitude->roll;
	contact.from = contact.to;
	struct deform_forces forces = ground_forces(ground, &contact);
	for (int i = 0; i < steps; i++) {
		ground_go(&contact, way[0], way[1], way[2]);
		forces = ground_forces(ground, &contact);
	}
	return forces;
}

static double size_of(const double v[3])
{
	return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static void assert_forces_near(const struct deform_forces *got, const struct deform_forces *wanted, double within, double arm, const char *what)
{
	double size = size_of(wanted->force);
	for (int i = 0; i < 3; i++)
		if (!(fabs(got->force[i] - wanted->force[i]) <= within * size) || !(fabs(got->moment[i] - wanted->moment[i]) <= fmax(within, 1e-4) * size * arm))
			fail_msg("%s: %d: %.7g N, %.7g N m, not %.7g, %.7g", what, i, got->force[i], got->moment[i], wanted->force[i], wanted->moment[i]);
}

/* Set down, pressed down, and with 4 ways moved up and down a slope: the forces are the same, to a share of their size. */
static void compare(const struct soil_shape *a, const struct soil_pose *as, const struct soil_shape *b, const struct soil_pose *bs, int count,
		    const char *what)
{
	static const double ways[][3] = {{0, 0, 0}, {0, 0, -0.004}, {0.02, 0.011, 0.001}, {-0.015, 0.02, -0.002}}, spacings[] = {0.04, 0.03, 0.02};
	const struct soil_numbers soil = bed_soft();
	for (int k = 0; k < count; k++)
		for (int s = 0; s < 3; s++) {
			struct ground one, other;
			init(&one, &soil, spacings[s]);
			init(&other, &soil, spacings[s]);
			struct deform_forces wanted = press(&one, a, as, 0.05, ways[k], 4), got = press(&other, b, bs, 0.05, ways[k], 4);
			assert_forces_near(&got, &wanted, 2e-5, soil_shape_bound(a), what);
			ground_finish(&one);
			ground_finish(&other);
		}
}

static void a_level_cylinder_is_a_wheel_that_does_not_turn(void **state)
{
	for (int k = 0; k < 3; k++) {
		const double yaw = (const double[]){0, 0.6, -2}[k];
		const struct soil_shape log = {.kind = SOIL_CYLINDER, .radius = wheel.radius, .length = wheel.width};
		compare(&wheel, &(struct soil_pose){.yaw = yaw}, &log, &(struct soil_pose){.yaw = yaw, .roll = M_PI / 2}, 4, "cylinder");
	}
}

static void an_ellipsoid_of_equal_radii_is_a_sphere(void **state)
{
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.25}, egg = {.kind = SOIL_ELLIPSOID, .size = {0.25, 0.25, 0.25}};
	compare(&ball, &(struct soil_pose){.yaw = 0}, &egg, &(struct soil_pose){.yaw = 1, .pitch = 0.4, .roll = 2}, 4, "ellipsoid");
}

/* One that moves differs by up to 3.3 % of its force. */
static void a_capsule_without_length_is_a_sphere(void **state)
{
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.25}, pill = {.kind = SOIL_CAPSULE, .radius = 0.25};
	compare(&ball, &(struct soil_pose){.yaw = 0}, &pill, &(struct soil_pose){.yaw = 1, .pitch = 0.4, .roll = 2}, 2, "capsule");
}

/* --- against integrals --- */

static double yields(const struct soil_numbers *soil, double width, double sinkage)
{
	return sinkage > 0 ? reference_yield(soil, width, sinkage) : 0;
}

struct sum {
	double force[3], moment[3];
};

static void add(struct sum *sum, const double arm[3], const double force[3])
{
	for (int k = 0; k < 3; k++) {
		sum->force[k] += force[k];
		sum->moment[k] += arm[(k + 1) % 3] * force[(k + 2) % 3] - arm[(k + 2) % 3] * force[(k + 1) % 3];
	}
}

/* Any body that is set down on level soil: normal stress p(z) over its lower envelope, in doubles, on a grid of half a millimetre. A flat end of a
 * cylinder counts by its area in plan. */
static struct sum grid_of(const struct soil_numbers *soil, const struct soil_shape *shape, const struct soil_pose *pose, double deep)
{
	struct lower_envelope lower;
	struct lower_place place;
	struct sum sum = {.force = {0}};
	const double step = 5e-4, height = soil_shape_reach(shape, pose->pitch, pose->roll) - deep;
	const int side = (int)(soil_shape_bound(shape) / step) + 1;
	soil_lower_of(shape, pose, &lower);
	for (int i = -side; i < side; i++)
		for (int k = -side; k < side; k++) {
			double x = (i + 0.5) * step, y = (k + 0.5) * step;
			if (!soil_lower_at(&lower, x, y, &place) || height + place.z >= 0)
				continue;
			const bool end = shape->kind == SOIL_CYLINDER && memcmp(place.normal, lower.axis, sizeof lower.axis) == 0;
			double p = yields(soil, 1, -height - place.z), area = step * step / (end ? 1 : fmax(place.normal[2], 0.05));
			const double arm[3] = {x, y, place.z};
			add(&sum, arm, (const double[]){p * area * place.normal[0], p * area * place.normal[1], p * area * place.normal[2]});
		}
	return sum;
}

static void bodies_set_down_are_the_integral_over_their_lower_envelopes(void **state)
{
	static const struct soil_shape shapes[] = {
		{.kind = SOIL_CYLINDER, .radius = 0.2, .length = 0.5},
		{.kind = SOIL_CAPSULE, .radius = 0.2, .length = 0.4},
		{.kind = SOIL_ELLIPSOID, .size = {0.4, 0.25, 0.2}},
	};
	static const double spacings[] = {0.03, 0.02, 0.01};
	/* Lying, tilted a little, tilted much, and nearly upright. */
	static const struct soil_pose poses[] = {{.roll = M_PI / 2, .yaw = 0.4}, {.roll = M_PI / 2 - 0.2, .yaw = 2}, {.roll = M_PI / 2 + 0.7, .pitch = 0.3}, {.roll = 0.15, .pitch = -0.1, .yaw = -1}};
	const struct soil_numbers soil = bed_soft();
	for (int i = 0; i < 3; i++)
		for (int n = 0; n < 4; n++) {
			struct sum wanted = grid_of(&soil, &shapes[i], &poses[n], 0.04);
			for (int k = 0; k < 3; k++) {
				struct ground ground;
				ground_init(&ground, &(struct ground_params){.cells = 128, .tiles = 1, .first = 2, .spacing = spacings[k], .soils = &soil});
				struct deform_forces forces = press(&ground, &shapes[i], &poses[n], 0.04, (const double[]){0, 0, 0}, 0);
				/* A cylinder's edges are where they are to a post, if its end bears as much as its side. */
				double size = size_of(wanted.force), edges = (const double[]){0.12, 0.08, 0.02}[k], within = (i == 0 && n > 1 ? edges : 0.012) * size;
				for (int m = 0; m < 3; m++)
					if (!(fabs(forces.force[m] - wanted.force[m]) <= within) || !(fabs(forces.moment[m] - wanted.moment[m]) <= within * 0.4))
						fail_msg("shape %d, pose %d, %g m: %d: %.5g N, %.5g N m; integral %.5g, %.5g; all %.5g N", i, n, spacings[k], m,
							 forces.force[m], forces.moment[m], wanted.force[m], wanted.moment[m], size);
				ground_finish(&ground);
			}
		}
}

TEST_PROGRAM(bodies)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_level_cylinder_is_a_wheel_that_does_not_turn),
		cmocka_unit_test(an_ellipsoid_of_equal_radii_is_a_sphere),
		cmocka_unit_test(a_capsule_without_length_is_a_sphere),
		cmocka_unit_test(bodies_set_down_are_the_integral_over_their_lower_envelopes),
	};
	return cmocka_run_group_tests_name("bearing/bodies", tests, NULL, NULL);
}
