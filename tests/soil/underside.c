/* The lower envelope in doubles is that of the reference, and its normals are those of its slopes. */
#include "soil_test.h"

#include "deform/reference/reference.h"
#include "soil/shape/body.h"
#include "soil/shape/lower_envelope.h"
#include "../support/program.h"

#define SHAPES 7
#define PLACES 400
#define HAIR 1e-7 /* m: over so little slopes are measured */

static struct soil_mesh mesh;

static struct soil_shape any_shape(enum soil_shape_kind kind)
{
	double size = 0.3 * exp2(2 * any_share());
	struct soil_shape shape = {.kind = kind, .radius = size * exp2(any_share()), .width = size * exp2(any_share()), .length = 2 * size * exp2(any_share()), .mesh = &mesh};
	for (int k = 0; k < 3; k++)
		shape.size[k] = size * exp2(any_share());
	return shape;
}

static double height_at(const struct deform_contact *standing, double x, double y)
{
	long double z = INFINITY;
	return reference_underside(standing, x, y, &z) ? (double)z : INFINITY;
}

/* The normal's slopes are those of the reference, where it is smooth. Returns whether it was. */
static bool compare_normal(const struct deform_contact *standing, const struct lower_place *place, double x, double y)
{
	double length = 0;
	for (int k = 0; k < 3; k++)
		length += place->normal[k] * place->normal[k];
	assert_true(fabs(length - 1) < 1e-9 && place->normal[2] >= 0);
	for (int k = 0; k < 2; k++) {
		double dx = k == 0 ? HAIR : 0, dy = k == 0 ? 0 : HAIR;
		double before = height_at(standing, x - dx, y - dy), after = height_at(standing, x + dx, y + dy), here = height_at(standing, x, y);
		double slope = (after - before) / (2 * HAIR), bends = fabs(after - 2 * here + before) / HAIR;
		if (!(bends < 1e-4) || fabs(slope) > 50)
			return false;
		assert_true(fabs(slope * place->normal[2] + place->normal[k]) < 1e-4);
	}
	return true;
}

/* Wheels with and without camber; each fourth attitude is straight. */
static void it_is_that_of_the_reference(void **state)
{
	static float vertices[4][3] = {{0.4f, 0.1f, 0.3f}, {-0.3f, 0.2f, -0.1f}, {0.1f, -0.5f, 0.2f}, {0, 0, -0.4f}};
	static uint32_t triangles[4][3] = {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {0, 2, 3}};
	static const double straight[] = {0, M_PI / 2, -M_PI / 2, 1e-4};
	int above[SHAPES] = {0}, smooth[SHAPES] = {0};
	(void)state;
	mesh = (struct soil_mesh){.vertices = vertices, .triangles = triangles, .vertex_count = 4, .triangle_count = 4, .low = {-0.3, -0.5, -0.4}, .high = {0.4, 0.2, 0.3}};
	for (int kind = 0; kind < SHAPES; kind++)
		for (int i = 0; i < 24; i++) {
			struct soil_shape shape = any_shape((enum soil_shape_kind)kind);
			struct deform_contact standing = {.shape = &shape};
			struct lower_envelope lower;
			standing.to.yaw = 4 * any_share();
			standing.to.pitch = i % 4 == 0 ? straight[i / 4 % 4] : 4 * any_share();
			standing.to.roll = i % 4 == 0 || (kind == SOIL_WHEEL && i % 4 == 1) ? straight[i / 8 % 4] : 4 * any_share();
			standing.from = standing.to;
			soil_lower_of(&shape, &standing.to, &lower);
			double bound = soil_shape_bound(&shape);
			for (int k = 0; k < PLACES; k++) {
				double x = bound * any_share(), y = bound * any_share(), wanted = height_at(&standing, x, y);
				struct lower_place place;
				if (soil_lower_at(&lower, x, y, &place) != (wanted < INFINITY)) {
					double beside = height_at(&standing, x + 1e-9, y);
					assert_true((beside < INFINITY) != (wanted < INFINITY)); /* on the silhouette */
					continue;
				}
				if (!(wanted < INFINITY))
					continue;
				above[kind]++;
				if (!(fabs(place.z - wanted) <= 1e-9 * (1 + 1 / fmax(place.normal[2], 1e-9))))
					fail_msg("shape %d: %.12g at %g, %g; by the reference %.12g; pitch %.17g, roll %.17g", kind, place.z, x, y, wanted,
						 standing.to.pitch, standing.to.roll);
				smooth[kind] += compare_normal(&standing, &place, x, y);
			}
		}
	for (int kind = 0; kind < SHAPES; kind++)
		assert_true(above[kind] > 500 && smooth[kind] > 400);
}

/* The lowest place of a shape is soil_shape_reach below its centre, and nothing of it lies beyond soil_body_extent. */
static void reach_and_extent_are_its_own(void **state)
{
	(void)state;
	for (int kind = 0; kind < SHAPES; kind++)
		for (int i = 0; i < 40; i++) {
			if (kind == SOIL_MESH)
				continue;
			struct soil_shape shape = any_shape((enum soil_shape_kind)kind);
			struct soil_pose pose = {.yaw = 4 * any_share(), .pitch = 4 * any_share(), .roll = 4 * any_share()};
			struct lower_envelope lower;
			struct lower_place place;
			double lowest = 0, bound = soil_shape_bound(&shape), far[2] = {0, 0}, extent[2];
			soil_lower_of(&shape, &pose, &lower);
			soil_body_extent(&shape, &pose, extent);
			for (int k = 0; k < 201 * 201; k++) {
				double x = bound * (k % 201 - 100) / 100, y = bound * (k / 201 - 100) / 100;
				if (!soil_lower_at(&lower, x, y, &place))
					continue;
				lowest = support_least(lowest, place.z);
				far[0] = support_most(far[0], fabs(x));
				far[1] = support_most(far[1], fabs(y));
			}
			double reach = soil_shape_reach(&shape, pose.pitch, pose.roll);
			assert_true(lowest >= -reach - 1e-9 && lowest <= -reach + 0.03 * bound);
			for (int k = 0; k < 2; k++)
				assert_true(far[k] <= extent[k] + 1e-9 && far[k] >= extent[k] - 0.06 * bound);
		}
}

/* Grousers in doubles are those of the reference; under a wheel with camber they reach as far below as the wheel's outer radius does. */
static void grousers_are_those_of_the_reference(void **state)
{
	(void)state;
	int alike = 0;
	for (int i = 0; i < 20; i++) {
		struct soil_shape shape = any_shape(SOIL_WHEEL);
		shape.grousers = 12;
		shape.grouser_height = 0.1 * shape.radius;
		shape.grouser_thickness = 0.1 * shape.radius;
		struct deform_contact standing = {.shape = &shape, .to = {.yaw = 4 * any_share(), .turn = 4 * any_share()}};
		struct lower_envelope lower;
		struct lower_place place;
		standing.from = standing.to;
		soil_lower_of(&shape, &standing.to, &lower);
		double bound = soil_shape_bound(&shape);
		for (int k = 0; k < PLACES; k++) {
			double x = bound * any_share(), y = bound * any_share(), wanted = height_at(&standing, x, y);
			if (!soil_lower_at(&lower, x, y, &place) || !(wanted < INFINITY))
				continue;
			alike += fabs(place.z - wanted) < 1e-9;
			assert_true(fabs(place.z - wanted) < 1e-9 || fabs(height_at(&standing, x + 1e-8, y) - wanted) > 1e-6 ||
				    fabs(height_at(&standing, x, y + 1e-8) - wanted) > 1e-6);
		}
		standing.to.roll = 0.3;
		soil_lower_of(&shape, &standing.to, &lower);
		double lowest = 0, outer = hypot(shape.radius + shape.grouser_height, shape.grouser_thickness / 2);
		for (int k = 0; k < 401 * 401; k++)
			if (soil_lower_at(&lower, bound * (k % 401 - 200) / 200, bound * (k / 401 - 200) / 200, &place))
				lowest = support_least(lowest, place.z);
		double most = outer * cos(0.3) + shape.width / 2 * sin(0.3), least = shape.radius * cos(0.3) + shape.width / 2 * sin(0.3);
		assert_true(lowest >= -most && lowest < -least);
	}
	assert_true(alike > 2000);
}

TEST_PROGRAM(underside)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(it_is_that_of_the_reference),
		cmocka_unit_test(reach_and_extent_are_its_own),
		cmocka_unit_test(grousers_are_those_of_the_reference),
	};
	return cmocka_run_group_tests_name("soil/underside", tests, NULL, NULL);
}
