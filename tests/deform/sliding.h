/* Ground that goes on sliding: it is disturbed, and intervals pass. */
#ifndef FURROW_TESTS_DEFORM_SLIDING_H
#define FURROW_TESTS_DEFORM_SLIDING_H

#include "conserve.h"

struct setup {
	enum deform_model model;
	uint32_t cells, tiles;
	double spacing, depth;
	int iterations;
	resident_ground_height height;
};

static inline int32_t hills(int64_t x, int64_t y)
{
	return (int32_t)(lrint(30000 * sin((double)x * 0.21) * cos((double)y * 0.17))) + conserve_rough(x, y) / 64; /* it stands */
}

static inline void start(struct ground *ground, const struct setup *setup)
{
	struct soil_numbers soil;
	assert_ok(soil_named("dry_sand", &soil));
	soil.cohesion = 0;
	soil.theta_stop = soil.theta_out + 0.1;
	ground_init(ground, &(struct ground_params){.cells = setup->cells, .tiles = setup->tiles, .spacing = setup->spacing,
						    .model = setup->model, .iterations = setup->iterations, .soils = &soil,
						    .soil_count = 1, .depth = setup->depth, .height = setup->height,
						    /* A world known to be low has the narrower rim. */
						    .relief = setup->iterations == 1 || setup->cells == 64 ? 100 : 0});
}

/* A mound and a pit across the corners of tiles and blocks, and the ground awake there. The ball that made them is gone at once. */
static inline struct post_rect disturb(struct ground *ground, int64_t x, int64_t y, double height)
{
	struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 6 * ground->params.spacing};
	double z = ldexp(ground->base[y * ground->posts + x], -BASE_BITS) + ball.radius - height;
	struct deform_contact sweep = {.shape = &ball, .from = ground_pose(ground, (double)x, (double)y, z)};
	sweep.to = sweep.from;
	ground_sweep(ground, &sweep);
	for (size_t i = 0; i < ground->window_count; i++) {
		assert_ok(deform_wake_swept(ground->deform, &ground->windows[i], (uint32_t)i));
		assert_ok(deform_wake(ground->deform, ground->windows[i].write));
	}
	return ground->windows[0].write;
}

static inline size_t interval(struct ground *ground, const struct deform_rest *objects, size_t count)
{
	return ground_interval(ground, objects, count).blocks;
}

static inline struct post_rect all_of(const struct ground *ground)
{
	return (struct post_rect){0, 0, ground->posts, ground->posts};
}

static inline void assert_same(struct ground *a, struct ground *b, int n)
{
	ground_read(a);
	ground_read(b);
	for (int64_t i = 0; i < a->posts * a->posts; i++)
		if (a->offset[i] != b->offset[i])
			fail_msg("interval %d, post %lld, %lld: %d, not %d", n, (long long)(i % a->posts), (long long)(i / a->posts),
				 a->offset[i], b->offset[i]);
}

#endif
