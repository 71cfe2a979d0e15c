/*
 * The lower envelope of a shape with a closed form at posts of a row, in whole numbers: the same bits as shaders/lib/envelope.glsl computes.
 * That file tells what the numbers of a struct body are. Pure.
 */
#ifndef FURROW_SOIL_CLOSED_H
#define FURROW_SOIL_CLOSED_H

#include "soil/shape/body.h"

/* A moving shape: its body over the motion, and over a motion of no length that ends in the same pose. */
struct closed_form {
	struct body motion, end;
	enum soil_shape_kind form; /* soil_kind_in(): not SOIL_MESH */
};

/* Posts of a window: `count` posts of each of `rows` rows, from (x, y) on, which is counted from the bodies' first post. */
struct closed_posts {
	int32_t x, y;
	int count, rows;
};

/*
 * Computes heights above the window's zero, fixed-point units: `under` of the whole motion, `rest` of the end pose. UNDER_NONE: the shape is not
 * above the post. `stride`: elements from one row to the next, a multiple of LANES and at least `count`; all of them are written.
 */
void soil_closed(const struct closed_form *shape, const struct closed_posts *posts, size_t stride, int32_t *under, int32_t *rest);
/* The same for a cylinder, a capsule, and a wheel whose axle is not level. soil_closed calls it. */
void soil_closed_rod(const struct closed_form *shape, const struct closed_posts *posts, size_t stride, int32_t *under, int32_t *rest);

#endif
