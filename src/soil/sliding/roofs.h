/*
 * Roofs: bodies at rest below which the ground has no room to rise. Soil that slides towards such a post fills the gap below the body, and then goes
 * elsewhere. So no ground is inside a body. A post whose ground is above the whole body has no roof.
 */
#ifndef FURROW_SOIL_ROOFS_H
#define FURROW_SOIL_ROOFS_H

#include "soil/soil.h"

#define SOIL_ROOF_NONE INT32_MAX

struct soil_roofs {
	const int32_t *highest; /* a plane of the planes' posts: the highest offset to which soil may bring a post, fixed-point units; SOIL_ROOF_NONE: any */
	void *scratch;          /* soil_roofs_scratch bytes */
};

/* Returns the bytes of scratch memory that are enough for these planes. Pure. */
size_t soil_roofs_scratch(const struct soil_planes *planes);

/* The same as soil_slide_window and soil_slide_region, below roofs. roofs: NULL: there are none. */
void soil_slide_window_below(const struct soil_sliding *rule, const struct soil_planes *planes, const struct soil_slide_window *window,
			     const struct soil_roofs *roofs, void *scratch, uint32_t *words, struct soil_slid *slid);
void soil_slide_region_below(const struct soil_sliding *rule, const struct soil_planes *planes, struct post_rect blocks, const struct soil_roofs *roofs,
			     void *scratch, uint32_t *words);

#endif
