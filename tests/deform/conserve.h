/* The law of the conserving models over random sweeps: the sum of offsets and of what was compacted stays. */
#ifndef FURROW_TESTS_DEFORM_CONSERVE_H
#define FURROW_TESTS_DEFORM_CONSERVE_H

#include "ground.h"

static inline int64_t conserve_sum(struct ground *ground)
{
	int64_t sum = 0;
	ground_read(ground);
	for (int64_t i = 0; i < ground->posts * ground->posts; i++) {
		if (ground->base[i] == BASE_NODATA)
			assert_int_equal(ground->offset[i], 0);
		sum += ground->offset[i];
	}
	return sum;
}

static inline int32_t conserve_rough(int64_t x, int64_t y)
{
	uint32_t h = (uint32_t)x * 2654435761u ^ (uint32_t)y * 2246822519u;
	h ^= h >> 15;
	h *= 2654435761u;
	return (int32_t)(h >> 17); /* 0 .. 0.125 m */
}

static inline int32_t conserve_holed(int64_t x, int64_t y)
{
	return (x * 5 + y * 3) % 11 == 0 ? BASE_NODATA : conserve_rough(x, y);
}

static inline int32_t conserve_cliff(int64_t x, int64_t y)
{
	return x > 40 ? (1000 << 18) + conserve_rough(x, y) : y > 50 ? BASE_NODATA : conserve_rough(x, y);
}

/* Wheels, spheres and boxes, some of several windows, some half over the world's edge or far above, some that jump. */
static inline void conserve_every_quantum(enum deform_model model)
{
	static const resident_ground_height heights[] = {NULL, conserve_rough, conserve_holed, conserve_cliff};
	int64_t moved = 0, pieces = 0;
	for (int round = 0; round < 12; round++) {
		struct ground ground;
		struct ground_params params = {.cells = 32, .tiles = round % 3 == 2 ? 10 : 3, .spacing = 0.125,
					       .height = heights[round % 4], .model = model, .iterations = 1 + round % 8};
		params.depth = round % 5 == 4 ? 0.05 : 0;
		ground_init(&ground, &params);
		int64_t sum = 0, compacted = 0;
		bool large = params.tiles == 10;
		for (int k = 0; k < (large ? 2 : 6); k++) {
			struct soil_shape shape = {.kind = (enum soil_shape_kind)(any_word() % 3)};
			shape.radius = large ? 18 : 0.2 + 0.5 * fabs(any_share());
			shape.width = large ? 30 : 0.2 + 0.5 * fabs(any_share());
			for (int i = 0; i < 3; i++)
				shape.size[i] = large ? 30 : 0.3 + fabs(any_share());
			double middle = (double)ground.posts / 2, x = middle * (1 + any_share()), y = middle * (1 + any_share());
			double z = (heights[round % 4] == conserve_cliff && x > 40 ? 1000 : 0) +
				   soil_shape_reach(&shape, 0, 0) - 0.3 * fabs(any_share());
			struct deform_contact sweep = {.shape = &shape, .from = ground_pose(&ground, x, y, z)};
			sweep.to = ground_pose(&ground, x + 2 * any_share(), y + 2 * any_share(), z - 0.05 * any_share());
			sweep.to.yaw = 3 * any_share();
			if (shape.kind == SOIL_BOX)
				sweep.to.pitch = 0.3 * any_share();
			if (k % 3 == 2)
				sweep.from = sweep.to;
			ground_sweep(&ground, &sweep);
			pieces += (int64_t)ground.window_count;
			struct deform_tally tally;
			assert_ok(deform_tally(ground.deform, &tally));
			int64_t now = conserve_sum(&ground);
			if (now - sum != compacted - tally.compacted)
				fail_msg("round %d, sweep %d: the offsets' sum changed by %lld, %lld was compacted", round, k,
					 (long long)(now - sum), (long long)(tally.compacted - compacted));
			sum = now;
			compacted = tally.compacted;
			for (int64_t i = 0; i < ground.posts * ground.posts; i++)
				moved += ground.offset[i] != 0;
		}
		ground_finish(&ground);
	}
	assert_true(moved > 20000 && pieces > 60);
}

#endif
