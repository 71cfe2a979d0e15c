/*
 * A triangle in straight motion as whole numbers: what shaders/lib/facet.glsl evaluates at a post. Pure.
 *
 * Places along the ground are in 2^-FACET_BITS posts from an anchor, a post that the object alone determines; a
 * facet counts from a post of its own near it. So the bits at a post are the same in every window and
 * wherever the object is.
 */
#ifndef FURROW_DEFORM_FACET_H
#define FURROW_DEFORM_FACET_H

#include <stdbool.h>
#include <stdint.h>

#define FACET_BITS 16

/* std430 twin of `struct facet`: what its words hold is told there. */
struct facet {
	int32_t corners[4], third[4], cover[4], base[4], plane[4], edges[3][4], sides[3][4];
};

/* x, y from the anchor in 2^-FACET_BITS posts; z in fixed-point units above the frame's zero. */
struct facet_corner {
	int32_t x, y;
	double z;
};

/* From where it was to where it is at the end: in 2^-FACET_BITS posts, and fixed-point units. */
struct facet_motion {
	int32_t x, y, z;
};

/* The window from the anchor, and its size: posts. */
struct facet_window {
	int64_t x0, y0;
	int32_t width, height;
};

/* `resting`: it is there at the contact's end. False if it is above no post of the window: nothing is
 * written. A triangle seen edge-on from above, or all but so, is none: its edges are its
 * neighbours' too. */
bool deform_facet_of(const struct facet_corner corners[3], const struct facet_motion *motion, bool resting,
	      const struct facet_window *window, struct facet *facet);

#endif
