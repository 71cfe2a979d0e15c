/* The rule by which displaced soil is laid: by closed forms, for several bodies in any order, in any window. */
#include <math.h>
#include <string.h>

#include "../support/program.h"
#include "soil/laying/laying.h"
#include "soil_test.h"

#define SIDE 96
#define POSTS (SIDE * SIDE)
#define BODIES 3

static struct ground {
	struct soil_planes planes;
	int32_t base[POSTS], deposits[POSTS];
	uint8_t contact[POSTS];
} ground, other;

/* One body's contact. */
struct body {
	struct soil_shape shape;
	struct soil_laying laying;
	struct soil_measured measured;
	uint8_t patch[POSTS];
};
static struct body bodies[BODIES];
static uint64_t scratch[POSTS * 2];

static void begin(struct ground *of, int64_t x0, int64_t y0)
{
	memset(of, 0, sizeof *of);
	of->planes = (struct soil_planes){.rect = {x0, y0, x0 + SIDE, y0 + SIDE}, .width = SIDE, .base = of->base, .contact = of->contact};
	assert_true(soil_lay_scratch(SIDE, SIDE) <= sizeof scratch);
}

static int64_t sum_of(const struct ground *of)
{
	int64_t sum = 0;
	for (int i = 0; i < POSTS; i++)
		sum += of->deposits[i];
	return sum;
}

static struct soil_pose pose_at(double x, double y, double yaw, double spacing)
{
	return (struct soil_pose){.x = lattice_offset(x * spacing), .y = lattice_offset(y * spacing), .yaw = yaw};
}

/* The body touches a rectangle of posts, each of which gives away so much, and is so deep. */
static void touch(struct ground *of, struct body *body, const struct soil_laid *soils, struct post_rect posts, int32_t carried, int32_t deep)
{
	int32_t amounts[SIDE], offsets[SIDE];
	memset(body->patch, 0, sizeof body->patch);
	soil_measured_begin(&body->measured);
	for (int i = 0; i < SIDE; i++) {
		amounts[i] = carried;
		offsets[i] = -deep;
	}
	for (int64_t y = posts.y0; y < posts.y1; y++) {
		const int64_t at = (y - of->planes.rect.y0) * SIDE;
		for (int64_t x = posts.x0; x < posts.x1; x++)
			of->contact[at + x - of->planes.rect.x0] = body->patch[at + x - of->planes.rect.x0] = SOIL_LOWERED;
		const struct soil_row row = {.x = of->planes.rect.x0, .y = y, .count = SIDE, .contact = body->patch + at, .carried = amounts, .offset = offsets};
		soil_measure_row(&body->measured, &body->laying, soils, &row);
	}
}

static struct soil_lay_result lay(struct ground *of, const struct body *body, const struct soil_laid *soils)
{
	struct soil_lay_result result;
	soil_lay(&body->laying, &body->measured, soils, &of->planes, body->patch, NULL, of->planes.rect, scratch, of->deposits, &result);
	return result;
}

/* A ball on one post: by the distance of each post from it, less half a post. */
static void a_post_gets_soil_by_its_distance(void **state)
{
	const double spacing = 0.5;
	const struct soil_laid soils[SOIL_CLASSES] = {soil_laid_of(0.1, 1, spacing)};
	struct body *ball = &bodies[0];
	(void)state;
	begin(&ground, 0, 0);
	ball->shape = (struct soil_shape){.kind = SOIL_SPHERE, .radius = 1};
	const struct soil_pose pose = pose_at(40, 40, 0, spacing);
	ball->laying = soil_laying_of(&ball->shape, &pose, &pose, 0, NULL, spacing);
	assert_true(ball->laying.around && ball->laying.widest == 128);
	touch(&ground, ball, soils, (struct post_rect){40, 40, 41, 41}, 1 << 20, 1 << 20);
	const struct soil_lay_result result = lay(&ground, ball, soils);
	assert_true(result.compacted == 0 && result.posts.x0 == 38 && result.posts.y1 == 43);
	/* The band is as wide as the ball's radius, 128 64ths of a post. Its profile rises to 42 of them, is level, and falls. */
	const int away[6][2] = {{1, 0}, {1, 1}, {2, 0}, {2, 1}, {2, 2}, {3, 0}}, weights[6] = {32, 42, 32, 17, 0, 0};
	const double sum = 4 * 32 + 4 * 42 + 4 * 32 + 8 * 17;
	for (int k = 0; k < 6; k++)
		for (int turn = 0; turn < 8; turn++) {
			const int x = away[k][turn % 2] * (turn & 2 ? -1 : 1), y = away[k][1 - turn % 2] * (turn & 4 ? -1 : 1);
			assert_true(fabs(ground.deposits[(40 + y) * SIDE + 40 + x] - weights[k] / sum * 0x1p20) < 6);
		}
	assert_true(sum_of(&ground) == 1 << 20);
}

/* Sums of a wheel's laid soil ahead of its patch, behind it, to its left and right. */
static void sums_of_wheel(double slip, double aside, double sums[SOIL_FACES], int *ahead_of_axle)
{
	const double spacing = 0.0625;
	const struct soil_laid soils[SOIL_CLASSES] = {soil_laid_of(0.5, 1, spacing)};
	struct body *wheel = &bodies[0];
	begin(&ground, 0, 0);
	wheel->shape = (struct soil_shape){.kind = SOIL_WHEEL, .radius = 0.6, .width = 0.55};
	const struct soil_pose from = pose_at(40, 40 - aside, 0, spacing), to = pose_at(41, 40, 0, spacing);
	wheel->laying = soil_laying_of(&wheel->shape, &from, &to, (1 - slip) * spacing / wheel->shape.radius, NULL, spacing);
	touch(&ground, wheel, soils, (struct post_rect){37, 36, 46, 45}, 1 << 18, 1 << 18);
	assert_true(lay(&ground, wheel, soils).compacted == 0 && sum_of(&ground) == 81 << 18);
	memset(sums, 0, SOIL_FACES * sizeof *sums);
	*ahead_of_axle = 0;
	for (int i = 0; i < POSTS; i++) {
		const int x = i % SIDE, y = i / SIDE, face = y > 44 ? SOIL_LEFT : y < 36 ? SOIL_RIGHT : x > 41 ? SOIL_AHEAD : SOIL_BEHIND;
		sums[face] += ground.deposits[i] / (81 * 0x1p18);
		*ahead_of_axle += face >= SOIL_LEFT && x > 41 && ground.deposits[i] > 0;
	}
}

static void each_side_gets_its_share(void **state)
{
	double sums[SOIL_FACES];
	int ahead;
	(void)state;
	/* It rolls: half to each side, and only behind its axle. */
	sums_of_wheel(0, 0, sums, &ahead);
	assert_true(fabs(sums[SOIL_LEFT] - 0.5) < 1e-4 && fabs(sums[SOIL_RIGHT] - 0.5) < 1e-4 && sums[SOIL_AHEAD] + sums[SOIL_BEHIND] == 0 && ahead == 0);
	/* It is locked: half ahead, a quarter to each side. */
	sums_of_wheel(1, 0, sums, &ahead);
	assert_true(fabs(sums[SOIL_AHEAD] - 0.5) < 1e-4 && fabs(sums[SOIL_LEFT] - 0.25) < 1e-4 && fabs(sums[SOIL_RIGHT] - 0.25) < 1e-4);
	/* It slides to the left as far as it goes on: y2 = 1/2. */
	sums_of_wheel(0, 1, sums, &ahead);
	assert_true(fabs(sums[SOIL_LEFT] - 0.5) < 1e-4 && fabs(sums[SOIL_RIGHT] - 0.25) < 1e-4);
	assert_true(fabs(sums[SOIL_AHEAD] - 0.125) < 1e-4 && fabs(sums[SOIL_BEHIND] - 0.125) < 1e-4);
}

/* A ball that is set down, a wheel that rolls beside it, a box that is pushed. Their bands overlap. */
static void make_bodies(int64_t x0, int64_t y0, double spacing, const struct soil_laid *soils)
{
	static const struct soil_shape shapes[BODIES] = {{.kind = SOIL_SPHERE, .radius = 0.75}, {.kind = SOIL_WHEEL, .radius = 0.75, .width = 0.5},
							 {.kind = SOIL_BOX, .size = {1, 0.75, 0.5}}};
	static const double places[BODIES][3] = {{30.3, 40.2, 0}, {46.7, 38.1, 0.4}, {60.1, 45.9, 2.1}};
	begin(&ground, x0, y0);
	for (int i = 0; i < POSTS; i++)
		ground.base[i] = i % 37 == 0 ? BASE_NODATA : i;
	for (int k = 0; k < BODIES; k++) {
		struct body *body = &bodies[k];
		const int64_t x = x0 + (int64_t)places[k][0], y = y0 + (int64_t)places[k][1];
		const struct soil_pose to = pose_at((double)x0 + places[k][0], (double)y0 + places[k][1], places[k][2], spacing);
		struct soil_pose from = to;
		from.x -= k > 0 ? lattice_offset(spacing * cos(places[k][2])) : 0;
		from.y -= k > 0 ? lattice_offset(spacing * sin(places[k][2])) : 0;
		body->shape = shapes[k];
		body->laying = soil_laying_of(&shapes[k], &from, &to, spacing / 0.75, NULL, spacing);
		touch(&ground, body, soils, (struct post_rect){x - 5, y - 4 + k, x + 6, y + 5}, 12345 + k, 1 << 16);
	}
}

static void the_order_of_bodies_does_not_show(void **state)
{
	static const int orders[6][BODIES] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
	static int32_t first[POSTS];
	const double spacing = 0.0625;
	const struct soil_laid soils[SOIL_CLASSES] = {soil_laid_of(0.3, 1, spacing)};
	int shared = 0;
	(void)state;
	make_bodies(0, 0, spacing, soils);
	for (int order = 0; order < 6; order++) {
		int64_t wanted = 0;
		memset(ground.deposits, 0, sizeof ground.deposits);
		for (int k = 0; k < BODIES; k++) {
			const struct body *body = &bodies[orders[order][k]];
			const struct soil_lay_result result = lay(&ground, body, soils);
			wanted += body->measured.carried - result.compacted;
		}
		assert_true(sum_of(&ground) == wanted && wanted > 3 * 80 * 12345);
		for (int i = 0; i < POSTS; i++)
			assert_true((ground.contact[i] == 0 && ground.base[i] != BASE_NODATA) || ground.deposits[i] == 0);
		if (order == 0)
			memcpy(first, ground.deposits, sizeof first);
		assert_memory_equal(first, ground.deposits, sizeof first);
	}
	/* Some posts have soil of two bodies. */
	for (int k = 0; k < BODIES; k++) {
		memset(ground.deposits, 0, sizeof ground.deposits);
		lay(&ground, &bodies[k], soils);
		for (int i = 0; i < POSTS; i++)
			shared += ground.deposits[i] > 0 && ground.deposits[i] < first[i];
	}
	assert_true(shared > 20);
}

/* In a window that lies otherwise around it, and 2^24 posts from the origin. */
static void the_window_does_not_show(void **state)
{
	static const int64_t moves[][2] = {{1 << 24, 3 << 22}, {7, -3}, {-12, 5}};
	const double spacing = 0.0625;
	const struct soil_laid soils[SOIL_CLASSES] = {soil_laid_of(0.3, 1, spacing)};
	(void)state;
	make_bodies(0, 0, spacing, soils);
	for (int k = 0; k < BODIES; k++)
		lay(&ground, &bodies[k], soils);
	other = ground;
	for (int move = 0; move < 3; move++) {
		const int64_t x = moves[move][0], y = moves[move][1];
		if (move == 0) {
			make_bodies(x, y, spacing, soils);
		} else { /* the same place, in other planes */
			make_bodies(0, 0, spacing, soils);
			static struct ground whole;
			static uint8_t patches[BODIES][POSTS];
			whole = ground;
			for (int k = 0; k < BODIES; k++) {
				memcpy(patches[k], bodies[k].patch, POSTS);
				memset(bodies[k].patch, 0, POSTS);
			}
			begin(&ground, x, y);
			for (int i = 0; i < POSTS; i++) {
				const int64_t from_x = i % SIDE + x, from_y = i / SIDE + y;
				const bool in = from_x >= 0 && from_y >= 0 && from_x < SIDE && from_y < SIDE;
				const int64_t from = from_y * SIDE + from_x;
				ground.base[i] = in ? whole.base[from] : BASE_NODATA;
				ground.contact[i] = in ? whole.contact[from] : 0;
				for (int k = 0; k < BODIES && in; k++)
					bodies[k].patch[i] = patches[k][from];
			}
		}
		for (int k = 0; k < BODIES; k++)
			lay(&ground, &bodies[k], soils);
		for (int i = 0; i < POSTS; i++) {
			const int64_t to_x = i % SIDE - (move > 0 ? x : 0), to_y = i / SIDE - (move > 0 ? y : 0);
			const bool in = to_x >= 0 && to_y >= 0 && to_x < SIDE && to_y < SIDE;
			assert_int_equal(other.deposits[i], in ? ground.deposits[to_y * SIDE + to_x] : 0);
		}
	}
}

TEST_PROGRAM(laying_rules)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_post_gets_soil_by_its_distance),
		cmocka_unit_test(each_side_gets_its_share),
		cmocka_unit_test(the_order_of_bodies_does_not_show),
		cmocka_unit_test(the_window_does_not_show),
	};
	return cmocka_run_group_tests_name("soil/laying_rules", tests, NULL, NULL);
}
