/* The motion of a body during a contact, and the posts below it. See motion.h. */
#include "soil/shape/motion.h"

#include <math.h>

#include "soil/shape/body.h"

bool soil_moves(const struct soil_pose *from, const struct soil_pose *to)
{
	const int64_t rise = to->z - from->z;
	return (to->x != from->x || to->y != from->y || rise != 0) && rise <= BODY_RISE_MAX && rise >= -BODY_RISE_MAX;
}

/* Finds the posts between a and b, `extent` metres more on both sides. */
static void span(int64_t a, int64_t b, double extent, double spacing, int64_t *first, int64_t *last)
{
	const double low = lattice_offset_metres(a < b ? a : b) - extent, high = lattice_offset_metres(a > b ? a : b) + extent;
	*first = (int64_t)floor(low / spacing);
	*last = (int64_t)ceil(high / spacing) + 1;
}

struct post_rect soil_shadow(const struct soil_shape *shape, const struct soil_pose *from, const struct soil_pose *to, double spacing)
{
	double extent[2];
	struct post_rect shadow;
	soil_body_extent(shape, to, extent);
	span(from->x, to->x, extent[0], spacing, &shadow.x0, &shadow.x1);
	span(from->y, to->y, extent[1], spacing, &shadow.y0, &shadow.y1);
	return shadow;
}
