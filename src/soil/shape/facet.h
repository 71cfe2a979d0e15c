/*
 * A facet: a triangle in straight motion, as whole numbers. shaders/lib/facet.glsl computes its lowest height at a post. Pure.
 *
 * Horizontal positions are in 2^-FACET_BITS posts from an anchor, a post that depends on the object alone. A facet counts from its
 * own post, which is near it. So the bits at a post are the same in every window, wherever the object is.
 */
#ifndef FURROW_SOIL_FACET_H
#define FURROW_SOIL_FACET_H

#include <stdbool.h>
#include <stdint.h>

#define FACET_BITS 16

/* std430 twin of `struct facet` in shaders/lib/facet.glsl, which tells what the words hold. */
struct facet {
	int32_t corners[4], third[4], cover[4], base[4], plane[4], edges[3][4], sides[3][4];
};

/* A corner of a triangle. x, y: from the anchor, 2^-FACET_BITS posts; z: above the frame's zero, fixed-point units. */
struct facet_corner {
	int32_t x, y;
	double z;
};

/* The motion from start to end: x, y in 2^-FACET_BITS posts; z in fixed-point units. */
struct facet_motion {
	int32_t x, y, z;
};

/* The window's first post from the anchor, and its size; posts. */
struct facet_window {
	int64_t x0, y0;
	int32_t width, height;
};

/* Makes the facet of a triangle. `corners`: its position at the end. `resting`: the triangle remains there after the contact.
 * Returns false if it is above no post of the window; *facet is then undefined. A triangle that is almost vertical gives no facet,
 * since the triangles beside it have its edges. */
bool soil_facet_of(const struct facet_corner corners[3], const struct facet_motion *motion, bool resting,
	      const struct facet_window *window, struct facet *facet);

#endif
