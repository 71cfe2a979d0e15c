/* What posts become by a contact: src/soil/law/after.c. */
#ifndef FURROW_SOIL_AFTER_H
#define FURROW_SOIL_AFTER_H

#include "soil/law/bear.h"

#define AFTER_SHEAR_ENDS 2.0 /* posts: where a body is less far above the surface, the shear that a post stores ends */

/* What a block of posts becomes. */
struct soil_after {
	int32_t offset[POSTS_LANES], deposited[POSTS_LANES], sinkage[POSTS_LANES], shear[POSTS_LANES], dug[POSTS_LANES], carried[POSTS_LANES], lost[POSTS_LANES];
	int32_t below[POSTS_LANES], gap[POSTS_LANES]; /* 1: it is below the body, which does not touch it; how far below its surface, fixed-point units */
	int32_t loose[POSTS_LANES], floor[POSTS_LANES], density[POSTS_LANES];
	int32_t touched[POSTS_LANES], held[POSTS_LANES], refused[POSTS_LANES], ends[POSTS_LANES]; /* 1: yes */
};

/* Computes the new state of the block of posts that begins at post `b`. axis: the frame's x axis, east and north; raised: of the body, as in soil_bear;
 * kept: what that kept of an evaluation at this height. Pure. */
void soil_after(const struct soil_form *form, const float axis[2], int32_t raised, const struct soil_posts *posts, size_t b, const struct soil_kept *kept,
		float bulldozing, float slides, struct soil_after *after);
#if !SOIL_LAYERED
/* The same of posts with layers: after_layered.c. */
void soil_after_layered(const struct soil_form *form, const float axis[2], int32_t raised, const struct soil_posts *posts, size_t b, const struct soil_kept *kept,
			float bulldozing, float slides, struct soil_after *after);
#endif

#endif
