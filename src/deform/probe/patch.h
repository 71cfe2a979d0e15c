/* The ground under a body as a probe sees it: src/deform/probe/patch.c. */
#ifndef FURROW_DEFORM_PROBE_PATCH_H
#define FURROW_DEFORM_PROBE_PATCH_H

#include "deform/deform.h"

struct probe_soil {
	double k_c, k_phi, n, elastic, by_elastic; /* N/m^(n+1), N/m^(n+2), 1, Pa/m, m/Pa */
	double cohesion, tan_phi;                  /* Pa, 1 */
	double shear, by_shear, damping;           /* m, 1/m, Pa s/m */
};

/* A post, in the order in which the law reads it. */
struct probe_post {
	double height;      /* m, of the undisturbed surface above the patch's zero: base and deposited thickness */
	double deposited;   /* m, of it */
	double rise[2];     /* of the base, to the east and to the north */
	double up, by_up;   /* z of the base's normal, and its inverse */
	double was;         /* m, along the normal: the largest sinkage so far */
	double dug;         /* m */
	double shear[2];    /* mobilised shear to the east and to the north */
	double reached;     /* m above the patch's zero: the lowest place that the body reached above the post since the last contact; INFINITY: none */
	uint32_t soil;      /* index in the patch's soils */
	bool hole;
};

struct patch_part { /* of a tile */
	struct post_rect rect;
	size_t at;          /* its first byte in the staging buffer */
	bool classed, numbered; /* there are classes of soil, and levels of rasters */
	unsigned deformed;      /* a bit for each word of a post that was read; the others are zeros */
};
#define PATCH_PARTS 64

struct deform_patch {
	struct deform *deform;
	struct post_rect rect;   /* empty: nothing was read */
	size_t width, count;     /* posts in a row; posts */
	struct gpu_staging *staging;
	size_t staged;           /* its bytes */
	struct patch_part parts[PATCH_PARTS];
	size_t part_count;
	bool coming, whole;      /* a read is under way; it includes the base */
	bool known;              /* the posts are valid */
	int64_t zero;            /* 2^-20 m, absolute: height 0 of the posts */
	int32_t *bases;          /* as in slots */
	uint32_t *kinds;         /* class of soil, and levels of its rasters: what decides a post's soil */
	struct probe_post *posts;
	double *lows;            /* room for a probe: two for each post (low.h) */
	struct probe_soil *soils;
	uint32_t *soil_kinds;    /* of each of the soils */
	size_t soil_count, soil_room, room; /* room: posts */
};

#endif
