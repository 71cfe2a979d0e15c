/*
 * Routes: what a scene says of a path becomes waypoints in local metres, ready for a track. In this order: a curve through the points
 * (route_curve.c), the turn and the move of the whole path, and the way beside it (route_beside.c).
 */
#include "motion/route.h"

#include <math.h>
#include <string.h>

enum status motion_route_add(struct route *route, struct scene_waypoint point)
{
	TRY_MEM(mem_room(route->room, 0) <= ROUTE_POINTS || route->path.count < route->room, "a path");
	TRY(mem_grow(&route->path.points, &route->room, route->path.count + 1, sizeof *route->path.points, "a path"));
	route->path.points[route->path.count++] = point;
	return STATUS_OK;
}

/* The rest of `from`, without points. */
void motion_route_begin(struct route *route, const struct scene_path *from)
{
	*route = (struct route){.path = *from};
	route->path.points = NULL;
	route->path.count = 0;
}

/* Turns the whole path about its first point, and moves it. Quarter turns are exact. Yaws are turned already. */
static void move_points(struct scene_path *path)
{
	const double quarters = path->rotate / (M_PI / 2), first[2] = {path->points[0].x, path->points[0].y};
	double c = cos(path->rotate), s = sin(path->rotate);
	if (fabs(quarters - round(quarters)) < 1e-12) {
		c = round(c);
		s = round(s);
	}
	for (size_t i = 0; i < path->count; i++) {
		const double x = path->points[i].x - first[0], y = path->points[i].y - first[1];
		path->points[i].x = first[0] + (c * x - s * y) + path->offset[0];
		path->points[i].y = first[1] + (s * x + c * y) + path->offset[1];
	}
	path->rotate = path->offset[0] = path->offset[1] = 0;
}

static enum status replace(struct scene_path *path, enum status status, struct route *by)
{
	mem_free(status == STATUS_OK ? path->points : by->path.points);
	if (status == STATUS_OK)
		*path = by->path;
	return status;
}

enum status motion_route_create(const struct scene_path *from, const char *name, const double (*points)[2], struct scene_path *path)
{
	struct route next;
	enum status status = STATUS_OK;
	*path = *from;
	TRY(mem_make(&path->points, from->count, sizeof *path->points, "a path"));
	memcpy(path->points, from->points, from->count * sizeof *path->points);
	/* Numbers are kept small, so that a path has the same shape wherever it lies. */
	const double origin[2] = {lattice_offset_metres(lattice_offset(points[0][0])), lattice_offset_metres(lattice_offset(points[0][1]))};
	const bool derived = path->smooth || path->beside[0] != 0 || path->beside[1] != 0;
	for (size_t i = 0; i < path->count; i++) {
		path->points[i].x = points[i][0] - (derived ? origin[0] : 0);
		path->points[i].y = points[i][1] - (derived ? origin[1] : 0);
	}
	path->degrees = false;
	if (path->rotate != 0 || path->offset[0] != 0 || path->offset[1] != 0)
		move_points(path);
	if (path->smooth && path->count > 1)
		status = replace(path, motion_route_curve(path, &next), &next);
	if (status == STATUS_OK && (path->beside[0] != 0 || path->beside[1] != 0))
		status = replace(path, motion_route_beside(path, name, origin, &next), &next);
	for (size_t i = 0; status == STATUS_OK && derived && i < path->count; i++) {
		path->points[i].x += origin[0];
		path->points[i].y += origin[1];
	}
	if (status != STATUS_OK)
		motion_route_finish(path);
	return status;
}

void motion_route_finish(struct scene_path *path)
{
	mem_free(path->points);
	*path = (struct scene_path){.count = 0};
}
