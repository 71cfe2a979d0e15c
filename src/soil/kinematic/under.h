/* The lower envelope of a moving body over a rectangle of posts, of any shape. Pure. */
#ifndef FURROW_SOIL_UNDER_H
#define FURROW_SOIL_UNDER_H

#include "soil/shape/facet.h"
#include "soil/soil.h"

/* A body's motion, and the posts where its lower envelope is wanted. */
struct under_motion {
	const struct soil_shape *shape;
	const struct soil_pose *from, *to; /* the same: it does not move */
	double turned;                     /* as in struct soil_kinematic_contact */
	double spacing;                    /* m between posts */
	struct post_rect posts;
};

/* Returns the elements from one row to the next, for so many posts in a row. */
size_t soil_under_stride(int64_t posts);

/* Computes heights above to->z, fixed-point units: `under` of the whole motion, `rest` of the end pose. UNDER_NONE (rows.h): the body is
 * not above the post. Each has soil_under_stride() elements for each row. corners: room for the vertices of a mesh; not read for others. */
void soil_under(const struct under_motion *motion, struct facet_corner *corners, int32_t *under, int32_t *rest);

#endif
