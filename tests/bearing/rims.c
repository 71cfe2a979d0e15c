/*
 * Rims of laid soil: they do not depend on the spacing or on where the body is, and what a wheel lays beside itself does not carry it. Directions of 0,
 * 22.5 and 45 degrees.
 */
#include "ground.h"

#include "../support/program.h"

static const double headings[] = {0, M_PI / 8, M_PI / 4};

static void init(struct ground *ground, double spacing, uint32_t tiles, const struct soil_numbers *soil, double bulldozing, double slip_sinkage)
{
	ground_init(ground, &(struct ground_params){.cells = 64, .tiles = tiles, .spacing = spacing, .soils = soil, .iterations = 1, .bulldozing = bulldozing,
						    .slip_sinkage = slip_sinkage, .stands = true});
}

static struct soil_numbers loose(void)
{
	struct soil_numbers soil = bed_soil("dry_sand");
	soil.cohesion = 0;
	return soil;
}

struct way {
	const struct soil_shape *shape;
	double x, y, heading, length, load; /* from its middle, m; N */
	double slip; /* of the rim's way to the axle's, less 1 and below 0 */
};

/* Drives a wheel along a straight way, with one spacing between samples. Returns the mean height of its centre over the second half. */
static double drive(struct ground *ground, const struct way *way)
{
	const double d = ground->params.spacing;
	const int samples = (int)lround(way->length / d);
	struct deform_contact contact = {.shape = way->shape, .load = way->load};
	double sum = 0;
	int counted = 0;
	for (int i = 0; i <= samples; i++) {
		const double along = i * d - way->length / 2;
		struct soil_pose pose = ground_pose(ground, (way->x + along * cos(way->heading)) / d, (way->y + along * sin(way->heading)) / d,
						    soil_shape_reach(way->shape, 0, 0));
		pose.yaw = way->heading;
		contact.from = i == 0 ? pose : contact.to;
		contact.to = pose;
		contact.turned = i == 0 ? 0 : (1 - way->slip) * d / way->shape->radius;
		const struct deform_forces forces = ground_forces(ground, &contact);
		if (i > samples / 2 && i < samples - 4) {
			sum += lattice_offset_metres(forces.z);
			counted++;
		}
	}
	ground_lost_nothing(ground);
	return sum / counted;
}

/* Finds the crest on each of 48 rays from the middle. Returns the lowest and the highest crest. */
static void crests(const struct ground *ground, const int32_t *offset, double x, double y, double *least, double *most)
{
	const double d = ground->params.spacing;
	*least = INFINITY;
	*most = 0;
	for (int ray = 0; ray < 48; ray++) {
		double crest = 0, u = cos(ray * M_PI / 24), v = sin(ray * M_PI / 24);
		for (double far = 0; far < 1.6; far += d / 4) {
			const double i = (x + far * u) / d, j = (y + far * v) / d, p = i - floor(i), q = j - floor(j);
			const int32_t *at = offset + (int64_t)j * ground->posts + (int64_t)i;
			const double height = (1 - q) * ((1 - p) * at[0] + p * at[1]) + q * ((1 - p) * at[ground->posts] + p * at[ground->posts + 1]);
			crest = support_most(crest, ldexp(height, -OFFSET_BITS));
		}
		*least = support_least(*least, crest);
		*most = support_most(*most, crest);
	}
}

static void crests_are_as_high_all_around(void **state)
{
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.6}, box = {.kind = SOIL_BOX, .size = {1.2, 0.8, 0.6}};
	const struct soil_numbers soil = loose();
	for (int k = 0; k < 12; k++) {
		const struct soil_shape *shape = k % 4 == 3 ? &ball : &box;
		const double d = 0.125 / (1 << k / 4), x = 4.013, y = 3.987;
		double least, most;
		struct ground ground;
		init(&ground, d, (uint32_t)(1 << k / 4), &soil, 1, 0);
		struct deform_contact contact = ground_stand(&ground, shape, x / d, y / d, soil_shape_reach(shape, 0, 0) - 0.3);
		contact.from.yaw = contact.to.yaw = k % 4 == 3 ? 0 : headings[k % 4];
		ground_forces(&ground, &contact);
		int32_t *offset = ground_plane(&ground, PLANE_OFFSET);
		crests(&ground, offset, x, y, &least, &most);
		if (!(most - least < 0.1 * most) || !(least > 0.03))
			fail_msg("%g m, case %d: crests from %.4g to %.4g m", d, k % 4, least, most);
		mem_free(offset);
		ground_finish(&ground);
	}
}

/* A plate of 5 m over posts 1/64 m apart: wherever it stands it leaves the same, to the unit. */
static void a_large_body_leaves_the_same_everywhere(void **state)
{
	static const int64_t moved[][2] = {{144, 0}, {0, 64}, {-37, 11}};
	const struct soil_shape plate = {.kind = SOIL_BOX, .size = {5, 5, 1}};
	const struct soil_numbers soil = loose();
	int32_t *first = NULL;
	for (int k = -1; k < 3; k++) {
		const int64_t x = k < 0 ? 0 : moved[k][0], y = k < 0 ? 0 : moved[k][1];
		int64_t differ = 0, raised = 0;
		struct ground ground;
		init(&ground, 0x1p-6, 16, &soil, 1, 0);
		struct deform_contact contact = ground_stand(&ground, &plate, 500.3 + (double)x, 512.6 + (double)y, 0.2);
		ground_forces(&ground, &contact);
		ground_go(&contact, 0x1p-6, 0, 0);
		ground_forces(&ground, &contact);
		int32_t *offset = ground_plane(&ground, PLANE_OFFSET);
		for (int64_t i = 0; i < ground.posts * ground.posts && k >= 0; i++) {
			const int64_t to_x = i % ground.posts + x, to_y = i / ground.posts + y;
			const bool inside = to_x >= 0 && to_y >= 0 && to_x < ground.posts && to_y < ground.posts;
			differ += first[i] != (inside ? offset[to_y * ground.posts + to_x] : 0);
			raised += first[i] > 0;
		}
		assert_true(differ == 0 && (k < 0 || raised > 50000));
		if (k < 0)
			first = offset;
		else
			mem_free(offset);
		ground_finish(&ground);
	}
	mem_free(first);
}

/* The default wheel of 800 N on dry sand: what is laid does not push it back, and it sinks no deeper with finer posts. */
static void a_loaded_wheel_sinks_as_deep_with_finer_posts(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.32, .width = 0.24};
	for (int k = 0; k < 3; k++) {
		double finest = 0;
		for (int step = 2; step >= 0; step--) {
			struct ground ground;
			init(&ground, 0.02 / (1 << step), (uint32_t)(1 << step), NULL, 0.5, 0);
			const struct way way = {.shape = &wheel, .x = 0.643, .y = 0.641, .heading = headings[k], .length = 0.5, .load = 800};
			const double sinkage = wheel.radius - drive(&ground, &way);
			finest = step == 2 ? sinkage : finest;
			print_message("%g degrees, %g m: %.5g m\n", way.heading / DEGREES, ground.params.spacing, sinkage);
			assert_near(sinkage, finest, (step == 1 ? 0.015 : 0.03) * finest);
			ground_finish(&ground);
		}
	}
}

/* Chrono's soft soil, 10 kN: a rut of 0.32 m. Its wheel does not climb what it lays beside itself, even where it lays all of it. */
static void a_heavy_wheel_does_not_climb_what_it_lays(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4};
	const struct soil_numbers soil = bed_soft();
	double sinkage[2];
	for (int lays = 0; lays < 2; lays++) {
		struct ground ground;
		init(&ground, 0.04, 2, &soil, lays, 0.55);
		const struct way way = {.shape = &wheel, .x = 2.51, .y = 2.53, .heading = headings[1], .length = 3.2, .load = 10000, .slip = -0.25};
		sinkage[lays] = wheel.radius - drive(&ground, &way);
		ground_finish(&ground);
	}
	print_message("%.6g m, without a rim %.6g m\n", sinkage[1], sinkage[0]);
	assert_true(sinkage[0] > 0.25 && fabs(sinkage[1] - sinkage[0]) < 0.001 * sinkage[0]);
}

/* Ten passes in one rut: each sinks a little deeper, by less than the first passes, and no pass jumps. */
static void ten_passes_deepen_a_rut_steadily(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.32, .width = 0.24};
	double sinkage[2][10];
	for (int k = 0; k < 2; k++) {
		struct ground ground;
		init(&ground, 0.016 / (1 << k), (uint32_t)(2 << k), NULL, 0.5, 0);
		const struct way way = {.shape = &wheel, .x = 1.003, .y = 1.001, .length = 0.5, .load = 1000, .slip = -0.25};
		for (int pass = 0; pass < 10; pass++) {
			sinkage[k][pass] = wheel.radius - drive(&ground, &way);
			assert_true(pass == 0 || sinkage[k][pass] > 0.99 * sinkage[k][pass - 1]);
			assert_true(pass < 2 || sinkage[k][pass] - sinkage[k][pass - 1] < 1.2 * (sinkage[k][1] - sinkage[k][0]));
		}
		print_message("%g m: %.4g, %.4g, ... %.4g m\n", ground.params.spacing, sinkage[k][0], sinkage[k][1], sinkage[k][9]);
		ground_finish(&ground);
	}
	assert_near(sinkage[0][9], sinkage[1][9], 0.06 * sinkage[1][9]);
}

TEST_PROGRAM(rims)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(crests_are_as_high_all_around),
		cmocka_unit_test(a_large_body_leaves_the_same_everywhere),
		cmocka_unit_test(a_loaded_wheel_sinks_as_deep_with_finer_posts),
		cmocka_unit_test(a_heavy_wheel_does_not_climb_what_it_lays),
		cmocka_unit_test(ten_passes_deepen_a_rut_steadily),
	};
	return cmocka_run_group_tests_name("bearing/rims", tests, NULL, NULL);
}
