/* Used inside motion only. Makes routes from paths; see route.c. */
#ifndef FURROW_MOTION_ROUTE_H
#define FURROW_MOTION_ROUTE_H

#include "motion/motion.h"

#define ROUTE_POINTS ((size_t)1 << 24) /* the most of one path */

/* A path that is being made. x, y are local metres. */
struct route {
	struct scene_path path;
	size_t room;
};
void motion_route_begin(struct route *route, const struct scene_path *from);
enum status motion_route_add(struct route *route, struct scene_waypoint point) FURROW_CHECKED;

/* Each makes `route` from `path`, whose points are local metres. The caller frees route->path.points, even on failure. */

/*
 * A curve through all points: centripetal Catmull-Rom. It has no loops and no cusps between points. It is cut into straight pieces that are
 * off by at most a millimetre. Sources: Barry and Goldman, SIGGRAPH 1988; Yuksel et al., Computer-Aided Design 43, 2011.
 */
enum status motion_route_curve(const struct scene_path *path, struct route *route) FURROW_CHECKED;
/* The way of a point that is path->beside from it. For messages: `name`, of its object, and `origin`, which is added to places. STATUS_INPUT:
 * the path turns too tightly. */
enum status motion_route_beside(const struct scene_path *path, const char *name, const double origin[2], struct route *route) FURROW_CHECKED;

#endif
