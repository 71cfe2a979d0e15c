/* The motion of a body during a contact, and the posts below it. Pure. */
#ifndef FURROW_SOIL_MOTION_H
#define FURROW_SOIL_MOTION_H

#include "soil/soil.h"

/* Returns true if the body moves from one pose to the other. False: it is set down in the second, as it has not moved, or rises or falls by
 * more than BODY_RISE_MAX. */
bool soil_moves(const struct soil_pose *from, const struct soil_pose *to);
/* Returns the posts that the body may be above during the motion, with one post to spare for rounding. `from`: the same as `to` if it does
 * not move. spacing: m between posts. */
struct post_rect soil_shadow(const struct soil_shape *shape, const struct soil_pose *from, const struct soil_pose *to, double spacing);

#endif
