/* What the tests of selection share: a world with a ground, and views of it. */
#ifndef FURROW_TESTS_RENDER_SELECTION_FAKE_H
#define FURROW_TESTS_RENDER_SELECTION_FAKE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "render/select.h"

/* A world whose ground is a sum of waves; some tiles below level 0 exist, some tiles are resident. */
struct fake {
	struct extent extent;
	uint64_t seed;
	int deepest;          /* offset tiles exist down to this level */
	unsigned resident_of; /* resident if hash % 100 < this; the coarsest by root_resident */
	bool root_resident;
	bool everything_below; /* every tile below level 0 exists */
};

static inline uint64_t mix(uint64_t v)
{
	v = (v ^ v >> 31) * 0x7fb5d329728ea185ull;
	v = (v ^ v >> 27) * 0x81dadef4bc2dd44dull;
	return v ^ v >> 33;
}

static inline double unit(uint64_t *state)
{
	*state = mix(*state + 0x9e3779b97f4a7c15ull);
	return (double)(*state >> 11) * 0x1p-53;
}

static inline double fake_height(double x, double y)
{
	return 40 * sin(x / 90) * cos(y / 70) + 6 * sin(x / 11 + y / 17);
}

/* Exists below zero: the tile and every tile above it up to level -1 are in the hash's half. */
static inline bool exists(const struct fake *fake, struct tile tile)
{
	if (!extent_has(&fake->extent, tile))
		return false;
	for (int level = tile.level; level < 0; level++) {
		struct tile at = tile_ancestor(tile, level);
		if (at.level < fake->deepest)
			return false;
		if (!fake->everything_below && mix(tile_key(at) ^ fake->seed) % 100 < 45)
			return false;
	}
	return true;
}

static inline bool fake_bounds(void *user, struct tile tile, double *low, double *high)
{
	const struct fake *fake = user;
	double from[2], to[2];
	if (!exists(fake, tile))
		return false;
	render_box(&fake->extent, tile, from, to);
	/* Loose but true: the waves' own slope bounds how far the middle can be missed. */
	double x = (from[0] + to[0]) / 2, y = (from[1] + to[1]) / 2;
	double reach = ((to[0] - from[0]) + (to[1] - from[1])) * 0.9;
	*low = fmax(fake_height(x, y) - reach, -46);
	*high = fmin(fake_height(x, y) + reach, 46);
	return true;
}

static inline bool fake_resident(void *user, struct tile tile, uint32_t *slot)
{
	const struct fake *fake = user;
	assert_true(exists(fake, tile));
	*slot = (uint32_t)mix(tile_key(tile)) & 0xffff;
	if (tile.level == extent_coarsest(&fake->extent))
		return fake->root_resident;
	return mix(tile_key(tile) * 3 + fake->seed) % 100 < fake->resident_of;
}

static inline bool fake_divisible(void *user, struct tile tile)
{
	const struct fake *fake = user;
	if (tile.level > 0)
		return true;
	for (unsigned q = 0; q < 4; q++)
		if (exists(fake, (struct tile){tile.level - 1, 2 * tile.x + (q & 1), 2 * tile.y + (q >> 1)}))
			return true;
	return false;
}

/* Metres: rough to the north-east, and no simple function of the level. A parent's is no less than a child's. */
static inline double fake_error(void *user, struct tile tile)
{
	const struct fake *fake = user;
	assert_true(exists(fake, tile));
	double side = extent_spacing(&fake->extent, tile.level) * fake->extent.cells, error = 0;
	for (int level = fake->deepest - 1; level <= tile.level; level++) {
		/* What each finer level adds where it is roughest: its north-east end. */
		double grown = (double)(mix((uint64_t)(level + 32) ^ fake->seed) % 100) / 100;
		error += ldexp(grown, level) * fake->extent.spacing * 0.5;
	}
	return fake_divisible(user, tile) ? error * (1 + (tile.x + 1) * side / 400 + (tile.y + 1) * side / 300) : 0;
}

static inline void look(const double eye[3], const double target[3], double radius, struct render_view *view)
{
	double f[3], length = 0;
	for (int i = 0; i < 3; i++)
		length += (target[i] - eye[i]) * (target[i] - eye[i]);
	for (int i = 0; i < 3; i++)
		f[i] = (target[i] - eye[i]) / sqrt(length);
	double flat = sqrt(f[0] * f[0] + f[1] * f[1]);
	double right[3] = {flat > 1e-6 ? f[1] / flat : 1, flat > 1e-6 ? -f[0] / flat : 0, 0};
	double up[3] = {right[1] * f[2] - right[2] * f[1], right[2] * f[0] - right[0] * f[2],
			right[0] * f[1] - right[1] * f[0]};
	render_frustum(eye, f, right, up, 0.9, 1.5, 5000, view->planes);
	memcpy(view->eye, eye, sizeof view->eye);
	view->radius = radius;
	view->by_error = false;
	view->finest = TILE_LEVEL_MIN;
}

static inline void random_view(const struct fake *fake, uint64_t *random, struct render_view *view)
{
	double w = (double)(fake->extent.width - 1) * fake->extent.spacing;
	double h = (double)(fake->extent.height - 1) * fake->extent.spacing;
	double eye[3] = {w * (1.4 * unit(random) - 0.2), h * (1.4 * unit(random) - 0.2), 0};
	double target[3] = {w * unit(random), h * unit(random), 0};
	eye[2] = fake_height(eye[0], eye[1]) + 1 + 150 * unit(random) * unit(random);
	look(eye, target, 0.3 + 1.5 * unit(random), view);
}

static inline void random_fake(uint64_t *random, struct fake *fake)
{
	*fake = (struct fake){
		.extent = {.width = 2 + (int64_t)(400 * unit(random)), .height = 2 + (int64_t)(300 * unit(random)),
			  .spacing = 0.5 + 4 * unit(random), .cells = 8u << (int)(3 * unit(random))},
		.seed = mix(*random), .deepest = -(int)(4 * unit(random)),
		.resident_of = (unsigned)(101 * unit(random)), .root_resident = true,
	};
}

static inline struct render_source source_of(struct fake *fake)
{
	return (struct render_source){fake, fake_bounds, fake_resident, fake_divisible, fake_error, NULL};
}

#endif
