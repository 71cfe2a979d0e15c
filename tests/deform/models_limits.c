/*
 * Soils, objects and motions at the ends of what a scene may say (scene_schema.c's limits): whatever comes of them is numbers, whole
 * ones within their ranges, and nothing is lost.
 */
#include <float.h>

#include "ground.h"
#include "../support/program.h"

enum { CELLS = 32, TILES = 3, POSTS = CELLS * TILES + 1 };

/* Beyond this no offset goes, quanta. */
#define MOST (1 << 30)
#define DEGREES (M_PI / 180)

static const struct range {
	double low, high; /* a low of 0 is not reached: the least number that there is */
	bool from_zero;   /* it is */
	size_t at;
} ranges[] = {
	{0, 1e9, true, offsetof(struct soil_numbers, cohesion)},
	{0, 89 * DEGREES, true, offsetof(struct soil_numbers, friction_angle)},
	{0, 1e6, false, offsetof(struct soil_numbers, unit_weight)},
	{0, 90 * DEGREES, false, offsetof(struct soil_numbers, theta_in)},
	{0, 90 * DEGREES, false, offsetof(struct soil_numbers, theta_out)},
	{0, 90 * DEGREES, false, offsetof(struct soil_numbers, theta_stop)},
	{0, 0.2, false, offsetof(struct soil_numbers, roughness)},
	{0, 1, true, offsetof(struct soil_numbers, compression)},
};

static double any_of(double low, double high, bool from_zero)
{
	switch (any_word() % 4) {
	case 0:
		return low == 0 && !from_zero ? DBL_MIN : low;
	case 1:
		return high;
	case 2: /* of any size */
		return high * exp2(-60 * fabs(any_share()));
	default:
		return low + (high - low) * fabs(any_share());
	}
}

static struct soil_numbers any_soil(void)
{
	struct soil_numbers soil = {.cohesion = 0};
	for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++)
		*(double *)((char *)&soil + ranges[i].at) = any_of(ranges[i].low, ranges[i].high, ranges[i].from_zero);
	soil.theta_stop = fmax(soil.theta_stop, soil.theta_out);
	return soil;
}

static int32_t rough(int64_t x, int64_t y)
{
	uint32_t h = (uint32_t)x * 2654435761u ^ (uint32_t)y * 2246822519u;
	h ^= h >> 15;
	h *= 2654435761u;
	bool cliff = x > 60 && y > 40;
	return h % 97 == 0 ? BASE_NODATA : (int32_t)(h >> 16) + (cliff ? 300 << BASE_BITS : 0);
}

static struct deform_contact any_sweep(const struct ground *ground, const struct soil_shape *shape)
{
	double spacing = ground->params.spacing, x = 48 + 40 * any_share(), y = 48 + 40 * any_share();
	double height = any_word() % 8 == 0 ? 600 * any_share() : x > 60 && y > 40 ? 300 : 0;
	double z = height + soil_shape_reach(shape, 0, 0) - 4 * spacing * any_share();
	struct deform_contact sweep = {.shape = shape};
	sweep.from = ground_pose(ground, x, y, z);
	sweep.to = ground_pose(ground, x + 2 * any_share(), y + 2 * any_share(), z + spacing * any_share());
	sweep.to.yaw = 4 * any_share();
	double way = hypot(lattice_offset_metres(sweep.to.x - sweep.from.x), lattice_offset_metres(sweep.to.y - sweep.from.y));
	sweep.seconds = way / any_of(0, 1e4, false);
	if (shape->kind == SOIL_WHEEL)
		sweep.turned = way / (shape->radius * (1 - 0.99 * any_share()));
	return sweep;
}

/* Every plane in its range, holes as they were; the sum of offsets. */
static int64_t look(struct ground *ground)
{
	int64_t sum = 0;
	ground_read(ground);
	for (int64_t i = 0; i < ground->posts * ground->posts; i++) {
		sum += ground->offset[i];
		assert_true(ground->offset[i] >= -MOST && ground->offset[i] <= MOST);
		assert_true(ground->base[i] != BASE_NODATA || ground->offset[i] == 0);
	}
	return sum;
}

static void at_its_limits(enum deform_model model, int rounds)
{
	int64_t moved = 0;
	for (int round = 0; round < rounds; round++) {
		struct ground ground;
		struct deform_tally tally;
		test_seed = 100000u * (uint32_t)model + (uint32_t)round;
		double spacing = exp2(-(double)(round % 7));
		struct soil_shape shape = {.kind = (enum soil_shape_kind)(any_word() % 3)};
		shape.radius = fmax(0.001, spacing * exp2(4 * any_share()));
		shape.width = fmax(0.001, spacing * exp2(4 * any_share()));
		for (int k = 0; k < 3; k++)
			shape.size[k] = fmax(0.001, spacing * exp2(4 * any_share()));
		struct soil_numbers soil = any_soil();
		struct ground_params params = {
			.cells = CELLS, .tiles = TILES, .spacing = spacing, .height = rough, .model = model, .soils = &soil, .soil_count = 1,
			.iterations = 1 + (int)(any_word() % 8), .depth = any_word() % 2 ? 0 : any_of(0, 1024, false),
		};
		ground_init(&ground, &params);
		/* Not all of it stands: any of it may slide. */
		assert_ok(deform_wake(ground.deform, (struct post_rect){0, 0, POSTS, POSTS}));
		for (int k = 0; k < 6; k++) {
			struct deform_contact sweep = any_sweep(&ground, &shape);
			ground_sweep(&ground, &sweep);
			for (size_t i = 0; i < ground.window_count; i++)
				assert_ok(deform_wake(ground.deform, ground.windows[i].write));
			struct deform_rest rest = {.shape = &shape, .pose = sweep.to};
			ground_interval(&ground, &rest, 1);
		}
		int64_t sum = look(&ground);
		assert_ok(deform_tally(ground.deform, &tally));
		if (sum + tally.compacted != 0)
			fail_msg("round %d: the offsets' sum is %lld, %lld was compacted", round, (long long)sum, (long long)tally.compacted);
		for (int64_t i = 0; i < ground.posts * ground.posts; i++)
			moved += ground.offset[i] != 0;
		ground_finish(&ground);
	}
	assert_true(moved > 50 * rounds);
}

static void sumner_makes_nothing_but_numbers(void **state)
{
	(void)state;
	need_gpu();
	at_its_limits(DEFORM_SUMNER, 40);
}

static void slippage_makes_nothing_but_numbers(void **state)
{
	(void)state;
	need_gpu();
	at_its_limits(DEFORM_SLIPPAGE, 40);
}

TEST_PROGRAM(models_limits)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(sumner_makes_nothing_but_numbers),
		cmocka_unit_test(slippage_makes_nothing_but_numbers),
	};
	return cmocka_run_group_tests_name("deform/models_limits", tests, open_gpu, close_gpu);
}
