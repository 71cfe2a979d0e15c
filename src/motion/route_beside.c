/*
 * The way of a point that is ahead of a path and beside it; see route.h.
 *
 * With attitudes it is fixed to the body whose path this is. Without, it goes along the same way, so many metres further, and beside it: at a
 * corner its way has a corner too (a mitre). It is abreast at any time, so it is faster on the outside of a turn. Before the path's first point
 * and after its last the way goes straight on.
 */
#include "motion/route.h"

#include <math.h>

#define TURN (2 * M_PI / 180) /* rad between poses, at most */
#define SHARPEST (150 * M_PI / 180) /* a corner that the way beside can go round */

/* A corner of the path, and of the way beside it. */
struct corner {
	double x, y, s; /* m; s: along the path from its first point */
	double beside[2];
};

struct beside {
	const struct scene_path *path;
	const char *name; /* of the object */
	const double *origin; /* of the path's numbers, m */
	struct route *route;
	struct corner *corners; /* with the way before the first point and after the last, if they are needed */
	size_t count;
	double length;   /* of the path, m */
	double *lengths; /* of each of its points */
};

/* --- poses with attitudes --- */

static double turn(double from, double to)
{
	return remainder(to - from, 2 * M_PI);
}

static enum status add_fixed(struct route *route, const double beside[2], struct scene_waypoint pose)
{
	double axes[3][3];
	soil_axes(pose.yaw, pose.pitch, pose.roll, 0, axes);
	pose.x += beside[0] * axes[0][0] + beside[1] * axes[1][0];
	pose.y += beside[0] * axes[0][1] + beside[1] * axes[1][1];
	pose.z += beside[0] * axes[0][2] + beside[1] * axes[1][2];
	return motion_route_add(route, pose);
}

/* Between two poses of the path the turn is even, so the point goes along an arc: more poses are put between. */
static enum status add_all_fixed(const struct scene_path *path, struct route *route)
{
	TRY(add_fixed(route, path->beside, path->points[0]));
	for (size_t i = 1; i < path->count; i++) {
		const struct scene_waypoint *a = &path->points[i - 1], *b = &path->points[i];
		const double yaw = turn(a->yaw, b->yaw), pitch = turn(a->pitch, b->pitch), roll = turn(a->roll, b->roll);
		const double most = fmax(fabs(yaw), fmax(fabs(pitch), fabs(roll)));
		const int pieces = (int)fmax(ceil(most / TURN), 1);
		for (int k = 1; k < pieces; k++) {
			const double share = (double)k / pieces;
			struct scene_waypoint pose = {a->t + share * (b->t - a->t), a->x + share * (b->x - a->x), a->y + share * (b->y - a->y),
						      a->z + share * (b->z - a->z), a->yaw + share * yaw, a->pitch + share * pitch, a->roll + share * roll};
			if (pose.t > route->path.points[route->path.count - 1].t && pose.t < b->t)
				TRY(add_fixed(route, path->beside, pose));
		}
		TRY(add_fixed(route, path->beside, *b));
	}
	return STATUS_OK;
}

/* --- the corners of a path, and of the way beside it --- */

static void add_corner(struct beside *beside, double x, double y)
{
	struct corner *last = beside->count > 0 ? &beside->corners[beside->count - 1] : NULL;
	const double step = last != NULL ? hypot(x - last->x, y - last->y) : 0;
	if (last == NULL || step > 0)
		beside->corners[beside->count++] = (struct corner){.x = x, .y = y, .s = last != NULL ? last->s + step : 0};
}

static enum status take_corners(struct beside *beside)
{
	const struct scene_path *path = beside->path;
	beside->corners = mem_alloc(path->count + 3, sizeof *beside->corners);
	beside->lengths = mem_alloc(path->count, sizeof *beside->lengths);
	TRY_MEM(beside->corners != NULL && beside->lengths != NULL, "a path");
	for (size_t i = 0; i < path->count; i++) {
		add_corner(beside, path->points[i].x, path->points[i].y);
		beside->lengths[i] = beside->corners[beside->count - 1].s;
	}
	if (path->loop)
		add_corner(beside, path->points[0].x, path->points[0].y); /* the last corner is the first, again */
	beside->length = beside->corners[beside->count - 1].s;
	return STATUS_OK;
}

/* Lengthens the first or last piece by what is missing there. */
static void extend(struct beside *beside)
{
	const double ahead = beside->path->beside[0];
	struct corner *corners = beside->corners;
	const size_t a = ahead < 0 ? 0 : beside->count - 1, b = ahead < 0 ? 1 : beside->count - 2;
	const double piece = fabs(corners[a].s - corners[b].s), share = fabs(ahead) / piece;
	const struct corner end = {.x = corners[a].x + share * (corners[a].x - corners[b].x), .y = corners[a].y + share * (corners[a].y - corners[b].y),
				   .s = corners[a].s + ahead};
	for (size_t i = beside->count; ahead < 0 && i > 0; i--)
		corners[i] = corners[i - 1];
	corners[ahead < 0 ? 0 : beside->count] = end;
	beside->count++;
}

static double heading(const struct beside *beside, size_t piece)
{
	const struct corner *a = &beside->corners[piece], *b = &beside->corners[piece + 1];
	return atan2(b->y - a->y, b->x - a->x);
}

static enum status too_tight(const struct beside *beside, const struct corner *corner, const char *why)
{
	return fail_with(STATUS_INPUT, "objects.%s.path: the path that it is relative to %s at %.6g, %.6g m, and %g m beside it there is no way; give that path "
				       "wider turns (smooth: true), or a smaller offset", beside->name, why, corner->x + beside->origin[0],
			 corner->y + beside->origin[1], fabs(beside->path->beside[1]));
}

/* Sets where the way beside is at each corner: on the bisector, at the offset's distance from both pieces. */
static enum status set_beside(struct beside *beside)
{
	const double left = beside->path->beside[1];
	const size_t last = beside->count - 1;
	for (size_t i = 0; i <= last; i++) {
		struct corner *corner = &beside->corners[i];
		const bool loop = beside->path->loop;
		const double in = heading(beside, i > 0 ? i - 1 : loop ? last - 1 : 0), out = heading(beside, i < last ? i : loop ? 0 : last - 1);
		const double half = turn(in, out) / 2, reach = left != 0 ? left / cos(half) : 0;
		if (left != 0 && fabs(half) > SHARPEST / 2)
			return too_tight(beside, corner, "turns back");
		corner->beside[0] = corner->x - reach * sin(in + half);
		corner->beside[1] = corner->y + reach * cos(in + half);
	}
	for (size_t i = 0; i < last && left != 0; i++) {
		const struct corner *a = &beside->corners[i], *b = &beside->corners[i + 1];
		if ((b->beside[0] - a->beside[0]) * (b->x - a->x) + (b->beside[1] - a->beside[1]) * (b->y - a->y) <= 0)
			return too_tight(beside, a, "turns tightly");
	}
	return STATUS_OK;
}

/* --- the way beside --- */

/* Gives the place at length s; *from: the piece to begin with, which never goes back. */
static void place_at(const struct beside *beside, double s, size_t *from, struct scene_waypoint *point)
{
	while (*from + 2 < beside->count && beside->corners[*from + 1].s <= s)
		++*from;
	const struct corner *a = &beside->corners[*from], *b = a + 1;
	const double share = fmin(fmax((s - a->s) / (b->s - a->s), 0), 1);
	point->x = a->beside[0] + share * (b->beside[0] - a->beside[0]);
	point->y = a->beside[1] + share * (b->beside[1] - a->beside[1]);
}

static enum status add_at(const struct beside *beside, double s, double t, double z, size_t *from)
{
	struct route *route = beside->route;
	struct scene_waypoint point = {.t = t, .z = z};
	place_at(beside, s, from, &point);
	if (route->path.timed && route->path.count > 0 && t <= route->path.points[route->path.count - 1].t)
		return STATUS_OK; /* two so near that their times are one */
	return motion_route_add(route, point);
}

/* Adds the ways between two times in which the path goes from s to `until`, evenly, with all corners of the way. */
static enum status add_stretch(const struct beside *beside, const double s[2], const double t[2], const double z[2], size_t *from)
{
	const double ahead = beside->path->beside[0];
	for (size_t i = *from; i < beside->count && beside->corners[i].s < s[1] + ahead; i++) {
		if (beside->corners[i].s <= s[0] + ahead)
			continue;
		const double share = (beside->corners[i].s - ahead - s[0]) / (s[1] - s[0]);
		TRY(add_at(beside, beside->corners[i].s, t[0] + share * (t[1] - t[0]), z[0] + share * (z[1] - z[0]), from));
	}
	return add_at(beside, s[1] + ahead, t[1], z[1], from);
}

/* With the path's own times. */
static enum status add_timed(const struct beside *beside)
{
	const struct scene_path *path = beside->path;
	const double ahead = path->beside[0];
	size_t from = 0;
	TRY(add_at(beside, ahead, path->points[0].t, path->points[0].z, &from));
	for (size_t i = 1; i < path->count; i++) {
		const struct scene_waypoint *a = &path->points[i - 1], *b = &path->points[i];
		TRY(add_stretch(beside, (const double[]){beside->lengths[i - 1], beside->lengths[i]}, (const double[]){a->t, b->t},
				(const double[]){a->z, b->z}, &from));
	}
	return STATUS_OK;
}

/* The path has one speed. Beside it the speed differs from turn to turn, so the way gets times. */
static enum status add_evenly(const struct beside *beside)
{
	const struct scene_path *path = beside->path;
	const double zero[2] = {0};
	size_t from = 0;
	beside->route->path.timed = beside->route->path.cornered = path->beside[1] != 0;
	TRY(add_at(beside, path->beside[0], 0, 0, &from));
	return add_stretch(beside, (const double[]){0, beside->length}, (const double[]){0, beside->length / path->speed}, zero, &from);
}

/* One lap from the place that is `ahead` of the first point. Laps take as long as the path's, at one speed. */
static enum status add_lap(const struct beside *beside)
{
	const struct scene_path *path = beside->path;
	const double ahead = path->beside[0] - floor(path->beside[0] / beside->length) * beside->length;
	const size_t last = beside->count - 1;
	double length = 0;
	size_t from = 0, first = 0;
	struct scene_waypoint start = {.t = 0};
	place_at(beside, ahead, &from, &start);
	enum status status = motion_route_add(beside->route, start);
	while (first < last && beside->corners[first].s <= ahead)
		first++;
	for (size_t i = 0; i < last && status == STATUS_OK; i++) {
		const struct corner *corner = &beside->corners[(first + i) % last];
		status = motion_route_add(beside->route, (struct scene_waypoint){.x = corner->beside[0], .y = corner->beside[1]});
	}
	for (size_t i = 0; i < last; i++)
		length += hypot(beside->corners[i + 1].beside[0] - beside->corners[i].beside[0], beside->corners[i + 1].beside[1] - beside->corners[i].beside[1]);
	beside->route->path.speed = path->speed * length / beside->length;
	return status;
}

/* A path that stays at its place looks east. */
static enum status add_standing(const struct beside *beside)
{
	for (size_t i = 0; i < beside->path->count; i++) {
		struct scene_waypoint point = beside->path->points[i];
		point.x += beside->path->beside[0];
		point.y += beside->path->beside[1];
		TRY(motion_route_add(beside->route, point));
	}
	return STATUS_OK;
}

enum status motion_route_beside(const struct scene_path *path, const char *name, const double origin[2], struct route *route)
{
	struct beside beside = {.path = path, .name = name, .origin = origin, .route = route};
	motion_route_begin(route, path);
	route->path.beside[0] = route->path.beside[1] = 0;
	if (path->has_attitude)
		return add_all_fixed(path, route);
	enum status status = take_corners(&beside);
	if (status == STATUS_OK && beside.count < 2) {
		status = add_standing(&beside);
	} else if (status == STATUS_OK) {
		if (!path->loop && path->beside[0] != 0)
			extend(&beside);
		status = set_beside(&beside);
		if (status == STATUS_OK)
			status = path->loop ? add_lap(&beside) : path->timed ? add_timed(&beside) : add_evenly(&beside);
	}
	mem_free_all(beside.corners, beside.lengths);
	return status;
}
