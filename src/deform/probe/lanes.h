/*
 * A batch of posts while a probe computes them, an array for each number: lane i of all arrays is one post. Each step of the law is a loop
 * over the lanes without a branch, which a compiler turns into vector instructions.
 *
 * Lanes that no post fills hold the numbers of an earlier post, with `share` 0: they bear nothing, and all of their numbers are finite. No lane
 * reads another one. So a post's numbers do not depend on the posts beside it in the batch.
 */
#ifndef FURROW_DEFORM_PROBE_LANES_H
#define FURROW_DEFORM_PROBE_LANES_H

#include <stdbool.h>
#include <stddef.h>

#define LANES 16
/* A function that is compiled for several instruction sets (meson.build); and one that is part of each function that calls it. */
#if FURROW_CLONES
#define LANES_CLONED __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define LANES_CLONED
#endif
#define LANES_INLINED __attribute__((always_inline))

/* The lower envelope at a place of each lane. */
struct lane_faces {
	double height[LANES], slope[2][LANES], normal[3][LANES];
};

/* Heights and depths are in metres, in the body's frame. Yes is 1, no is 0. */
struct lanes {
	int count, used;         /* lanes with a post; lanes that had one in this batch or an earlier one */
	size_t number[LANES];    /* of the post in the patch */
	double at[2][LANES];
	/* The ground. */
	double height[LANES];    /* above the body's centre, less what slip digs */
	double base[LANES];      /* without what is deposited */
	double rise[2][LANES], up[LANES], by_up[LANES]; /* z of the base's normal, and its inverse */
	double was[LANES];       /* the largest sinkage before, along the normal, less what slip digs */
	double dug[LANES], shear[2][LANES]; /* before */
	double reached[LANES];   /* m: the lowest place that the body reached above the post since the last contact */
	/* Its soil. k: k_c / b + k_phi, N/m^(n+2), b the width of the contact patch. Others as in struct probe_soil. */
	double k[LANES], n[LANES], elastic[LANES], by_elastic[LANES], cohesion[LANES], tan_phi[LANES];
	double modulus[LANES], by_modulus[LANES], damping[LANES];
	/* The body at the post. */
	double own[2][LANES];    /* deform_form_own */
	double over[LANES], rests[LANES], lowest[LANES]; /* deform_form_over */
	struct lane_faces face;
	double depth[LANES];     /* of the end pose below the ground */
	double share[LANES], middle[2][LANES], sides[4][LANES]; /* deform_form_part */
	/* What the post remembers. */
	double plastic[LANES];   /* the plastic part of `was`, along the normal */
	double excess[LANES];    /* m, vertically: by how much the body was deeper since the last contact than in this motion */
	double passed[LANES];    /* the last share of the motion during which the body was deeper than before: deform_form_share */
	double slides[LANES];    /* the way of the surface in the motion, in units of the shear modulus */
	double lasts[LANES];     /* 0: the whole cell has been in contact as long as the post; 1: as long as the body has been above it */
	double stamped[LANES];   /* 1: the hollow has the lower envelope's shape; 0: it is flat */
	double printed[LANES], print_height[LANES]; /* how much of it has the shape that the lower envelope had before the motion, whose height was this */
	double lowered[LANES], back[LANES]; /* how much lower the body was in the motion; how many metres ago that may be */
	/* The line across the cell: its middle, its end from there, and the part of it that bears, -1 .. 1. */
	double centre[2][LANES], end[2][LANES], first[LANES], last[LANES];
};

#endif
