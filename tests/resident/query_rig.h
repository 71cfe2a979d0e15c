/*
 * What the tests of queries share: a small rough ground with holes and finer tiles here and there, every face of it, and
 * plain answers from all of these faces. query_rig.c is an oracle: see tests/meson.build.
 */
#ifndef FURROW_TESTS_RESIDENT_QUERY_RIG_H
#define FURROW_TESTS_RESIDENT_QUERY_RIG_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "resident/heights.h"

enum { RIG_CELLS_MOST = 32 };

struct rig {
	struct extent extent;
	uint64_t seed;
	int finest;
	unsigned holes;         /* posts of level 0 in 1,000 that are nodata */
	unsigned fine;          /* tiles of the finest level in 100 that are there */
	double relief, rut;     /* metres */
	double crack;           /* metres: the finest tiles stand so much higher, at their edges too */
	int64_t far;            /* posts from the south-west one to the one that is as post 0 is elsewhere */
	struct resident_source ground;
	double heights[(RIG_CELLS_MOST + 1) * (RIG_CELLS_MOST + 1)], blocks[16][2];
	uint64_t reads;         /* posts asked for */
	uint64_t fails_at;      /* the posts asked for that fail; 0: none */
};

/* A cell with all four posts, bilinear between south-west, south-east, north-west and north-east; or a triangle that a cell with a
 * hole is left with, whose corners are south-west, the other, north-east. */
struct rig_face {
	double corner[4][3];
	bool cell;
	int level;
};

/* A ray and all faces: the nearest that it meets. */
struct rig_strike {
	long double first; /* metres from the origin; INFINITY: none */
	const struct rig_face *face;
};

/* --- chance --- */

uint64_t rig_mix(uint64_t value);
double rig_unit(uint64_t *state); /* 0 to 1 */
double rig_between(uint64_t *state, double low, double high);

/* --- ground --- */

/* Sets rig->ground. */
void rig_open(struct rig *rig);
/* The height of a post of level 0, a multiple of 2^-18 m; NAN: a hole. */
double rig_post(const struct rig *rig, int64_t x, int64_t y);
bool rig_present(const struct rig *rig, struct tile tile);
/* All of the ground, in the finest tile there. Returns how many; *out is freed by the caller. */
size_t rig_faces(const struct rig *rig, struct rig_face **out);

/* --- plain answers --- */

/* Every face is made larger by `slack`, smaller if negative. */
struct rig_strike rig_strike(const struct rig_face *all, size_t count, const struct resident_ray *ray, long double slack);
/* The face over a point, which lies inside by `slack`; NULL: none. *height: metres. normal: of length 1, upward. */
const struct rig_face *rig_over(const struct rig_face *all, size_t count, struct resident_point point, double slack, double *height,
				double normal[3]);
/* The normal of a face at a point: by differences of its height, for a cell. */
void rig_normal(const struct rig_face *face, long double x, long double y, double normal[3]);

#endif
