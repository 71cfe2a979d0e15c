/*
 * Bands of laid soil: their size, shape and place do not depend on the spacing, on the axes or on windows. The tests use directions of
 * 0, 22.5 and 45 degrees, and halve the spacing twice.
 */
#include "../support/near.h"
#include "ground.h"
#include "../support/program.h"

static const double headings[] = {0, M_PI / 8, M_PI / 4};

static struct ground_params soil_of(enum deform_model model, double spacing, uint32_t tiles, const struct soil_numbers *soil)
{
	return (struct ground_params){.cells = 64, .tiles = tiles, .spacing = spacing, .model = model, .soils = soil, .soil_count = 1,
				      .iterations = 1, .stands = true};
}

static struct soil_numbers loose(enum deform_model model)
{
	struct soil_numbers soil;
	assert_ok(soil_named(model == DEFORM_SUMNER ? "sand" : "dry_sand", &soil));
	soil.cohesion = 0;
	soil.compression = 0.3; /* so that sumner's rim is high: of sand it has less than half of this */
	return soil;
}

/* Computes where a post of the block lies from a line's start: metres along the line and to its left. */
static void place_of(const struct ground *ground, int64_t at, double x, double y, double heading, double place[2])
{
	double east = (double)(at % ground->posts) * ground->params.spacing - x, north = (double)(at / ground->posts) * ground->params.spacing - y;
	place[0] = east * cos(heading) + north * sin(heading);
	place[1] = north * cos(heading) - east * sin(heading);
}

struct way {
	const struct soil_shape *shape;
	double x, y, heading, length, sink; /* from its middle, m */
	double slip; /* 1: locked */
};

/* Drives a body along a straight way, with one spacing between samples. */
static void drive(struct ground *ground, const struct way *way)
{
	const double d = ground->params.spacing;
	const int samples = (int)lround(way->length / d);
	struct deform_contact sweep = {.shape = way->shape};
	for (int i = 0; i <= samples; i++) {
		double along = i * d - way->length / 2;
		struct soil_pose pose = ground_pose(ground, (way->x + along * cos(way->heading)) / d, (way->y + along * sin(way->heading)) / d,
						    soil_shape_reach(way->shape, 0, 0) - way->sink);
		pose.yaw = way->heading;
		sweep.from = i == 0 ? pose : sweep.to;
		sweep.to = pose;
		sweep.turned = i == 0 ? 0 : (1 - way->slip) * d / way->shape->radius;
		ground_sweep(ground, &sweep);
	}
	ground_read(ground);
}

struct berm {
	double left, right, widest, crest, corridor, hollow; /* m2: sections; m; m2 raised in the corridor; m2 lowered */
};

static struct berm berm_of(const struct ground *ground, const struct way *way, double half_width, double from, double to)
{
	struct berm berm = {0};
	double area = ground->params.spacing * ground->params.spacing;
	for (int64_t i = 0; i < ground->posts * ground->posts; i++) {
		double place[2], height = lattice_offset_metres(ground->offset[i]);
		place_of(ground, i, way->x, way->y, way->heading, place);
		if (place[0] < from || place[0] >= to || height == 0)
			continue;
		double section = height * area / (to - from);
		if (height < 0)
			berm.hollow -= section;
		else if (fabs(place[1]) <= half_width)
			berm.corridor += section;
		else if (place[1] > 0)
			berm.left += section;
		else
			berm.right += section;
		if (height > 0.0005)
			berm.widest = support_most(berm.widest, fabs(place[1]) - half_width);
		berm.crest = support_most(berm.crest, height);
	}
	return berm;
}

/* All that a rolling wheel displaces lies beside its way: half on each side, in a band as wide as the rule says. A wheel lays up to its radius
 * behind its axle, so the way is longer than what is looked at. */
static void a_rolling_wheel_lays_the_same_berm_at_every_spacing(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.5};
	const struct soil_numbers soil = loose(DEFORM_SLIPPAGE);
	double sink = 0.02, half = wheel.width / 2, width = sqrt(4.5 * sink * half / tan(soil.friction_angle));
	(void)state;
	need_gpu();
	for (int k = 0; k < 9; k++) {
		double d = 0.04 / (1 << k / 3);
		struct ground ground;
		const struct ground_params params = soil_of(DEFORM_SLIPPAGE, d, (uint32_t)(1 << k / 3), &soil);
		ground_init(&ground, &params);
		const struct way way = {.shape = &wheel, .x = 1.283, .y = 1.271, .heading = headings[k % 3], .length = 1.6, .sink = sink};
		drive(&ground, &way);
		struct berm berm = berm_of(&ground, &way, half, -0.25, 0.25);
		double wanted = sink * wheel.width / 2;
		print_message("%g m, %g degrees: %.5g and %.5g m2 of %.5g; %.3g m wide of %.3g, %.4g m high\n", d, way.heading * 180 / M_PI,
			      berm.left, berm.right, wanted, berm.widest, width, berm.crest);
		assert_true(fabs(berm.left + berm.right - berm.hollow) < 0.03 * berm.hollow);
		assert_true(fabs(berm.left - berm.right) < 0.06 * berm.left && fabs(berm.hollow - 2 * wanted) < (0.03 + 1.2 * d) * 2 * wanted);
		assert_true(fabs(berm.widest - width) < 0.05 * width + d);
		/* Its section is two thirds of its width times its height. */
		assert_true(fabs(berm.crest - 1.5 * wanted / width) < (0.12 + 3 * d) * 1.5 * wanted / width);
		assert_true(berm.corridor == 0);
		ground_finish(&ground);
	}
}

/* A locked wheel is a sledge: half of what it displaces goes ahead. The heap stops growing when as much goes aside as is cut. */
static void the_heap_ahead_of_a_sledge_is_bounded(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.5};
	const struct soil_numbers soil = loose(DEFORM_SLIPPAGE);
	double highest[2][2];
	(void)state;
	need_gpu();
	for (int k = 0; k < 4; k++) {
		struct ground ground;
		const struct ground_params params = soil_of(DEFORM_SLIPPAGE, k / 2 == 0 ? 0.04 : 0.02, k / 2 == 0 ? 2 : 4, &soil);
		ground_init(&ground, &params);
		const struct way way = {.shape = &wheel, .x = 1.8 + 0.25 * (k % 2), .y = 2.5, .length = 1 + 0.5 * (k % 2), .sink = 0.02,
					.slip = 1, .heading = 0};
		drive(&ground, &way);
		highest[k / 2][k % 2] = 0;
		for (int64_t i = 0; i < ground.posts * ground.posts; i++) {
			double place[2];
			place_of(&ground, i, way.x, way.y, 0, place);
			if (fabs(place[1]) < 0.2 && place[0] > way.length / 2)
				highest[k / 2][k % 2] = support_most(highest[k / 2][k % 2], lattice_offset_metres(ground.offset[i]));
		}
		ground_finish(&ground);
	}
	print_message("ahead %.4g and %.4g m high after 1 and 1.5 m; at half the spacing %.4g and %.4g\n", highest[0][0], highest[0][1],
		      highest[1][0], highest[1][1]);
	for (int k = 0; k < 2; k++)
		assert_true(highest[k][0] > 0.008 && highest[k][1] < 1.1 * highest[k][0] && highest[k][1] < 0.04);
	assert_true(fabs(highest[0][1] - highest[1][1]) < 0.2 * highest[1][1]);
}

/* Finds the crest on each of 48 rays from the middle. Returns the lowest and the highest crest. */
static void crests(const struct ground *ground, double x, double y, double *least, double *most)
{
	double d = ground->params.spacing;
	*least = INFINITY;
	*most = 0;
	for (int ray = 0; ray < 48; ray++) {
		double crest = 0, u = cos(ray * M_PI / 24), v = sin(ray * M_PI / 24);
		for (double far = 0; far < 1.6; far += d / 4) {
			double i = (x + far * u) / d, j = (y + far * v) / d, p = i - floor(i), q = j - floor(j);
			const int32_t *at = ground->offset + (int64_t)j * ground->posts + (int64_t)i;
			double height = (1 - q) * ((1 - p) * at[0] + p * at[1]) + q * ((1 - p) * at[ground->posts] + p * at[ground->posts + 1]);
			crest = support_most(crest, ldexp(height, -OFFSET_BITS));
		}
		*least = support_least(*least, crest);
		*most = support_most(*most, crest);
	}
}

static void crests_are_as_high_all_around(void **state)
{
	static const enum deform_model models[] = {DEFORM_SLIPPAGE, DEFORM_SUMNER};
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.6}, box = {.kind = SOIL_BOX, .size = {1.2, 0.8, 0.6}};
	(void)state;
	need_gpu();
	for (int m = 0; m < 2; m++)
		for (int k = 0; k < 12; k++) {
			const struct soil_shape *shape = k % 4 == 3 ? &ball : &box;
			double d = 0.125 / (1 << k / 4), least, most, x = 4.013, y = 3.987;
			const struct soil_numbers soil = loose(models[m]);
			const struct ground_params params = soil_of(models[m], d, (uint32_t)(1 << k / 4), &soil);
			struct ground ground;
			ground_init(&ground, &params);
			struct deform_contact sweep = {.shape = shape,
						       .from = ground_pose(&ground, x / d, y / d, soil_shape_reach(shape, 0, 0) - 0.3)};
			sweep.from.yaw = k % 4 == 3 ? 0 : headings[k % 4];
			sweep.to = sweep.from;
			ground_sweep(&ground, &sweep);
			ground_read(&ground);
			crests(&ground, x, y, &least, &most);
			if (!(most - least < 0.1 * most) || !(least > 0.03))
				fail_msg("%s, %g m, case %d: crests from %.4g to %.4g m", deform_model_row(models[m])->name, d, k % 4, least, most);
			ground_finish(&ground);
		}
}

/* A plate of 5 m over posts 1/64 m apart needs parts of a window. Wherever it stands it leaves the same, to the unit. */
static void parts_of_a_window_leave_no_trace(void **state)
{
	static const enum deform_model models[] = {DEFORM_SLIPPAGE, DEFORM_SUMNER};
	static const int64_t moved[][2] = {{144, 0}, {0, 64}, {-37, 11}};
	const struct soil_shape plate = {.kind = SOIL_BOX, .size = {5, 5, 1}};
	(void)state;
	need_gpu();
	for (int m = 0; m < 2; m++) {
		const struct soil_numbers soil = loose(models[m]);
		struct ground_params params = soil_of(models[m], 0x1p-6, 4, &soil);
		struct ground first, other;
		params.cells = 256;
		ground_init(&first, &params);
		for (int k = -1; k < 3; k++) {
			struct ground *ground = k < 0 ? &first : &other;
			int64_t x = k < 0 ? 0 : moved[k][0], y = k < 0 ? 0 : moved[k][1], differ = 0, raised = 0;
			if (k >= 0)
				ground_init(&other, &params);
			struct deform_contact sweep = {.shape = &plate, .from = ground_pose(ground, 500.3 + (double)x, 512.6 + (double)y, 0.2)};
			sweep.to = sweep.from;
			ground_sweep(ground, &sweep);
			sweep.to.x += lattice_offset(0x1p-6);
			ground_sweep(ground, &sweep);
			assert_true(ground->window_count > 1);
			ground_read(ground);
			for (int64_t i = 0; i < first.posts * first.posts && k >= 0; i++) {
				int64_t to_x = i % first.posts + x, to_y = i / first.posts + y;
				bool inside = to_x >= 0 && to_y >= 0 && to_x < first.posts && to_y < first.posts;
				differ += first.offset[i] != (inside ? other.offset[to_y * first.posts + to_x] : 0);
				raised += first.offset[i] > 0;
			}
			assert_true(differ == 0 && (k < 0 || raised > 50000));
			if (k >= 0)
				ground_finish(&other);
		}
		ground_finish(&first);
	}
}

TEST_PROGRAM(bands)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_rolling_wheel_lays_the_same_berm_at_every_spacing),
		cmocka_unit_test(the_heap_ahead_of_a_sledge_is_bounded),
		cmocka_unit_test(crests_are_as_high_all_around),
		cmocka_unit_test(parts_of_a_window_leave_no_trace),
	};
	return cmocka_run_group_tests_name("deform/bands", tests, open_gpu, close_gpu);
}
