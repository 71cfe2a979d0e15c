/* A smooth curve through the points of a path; see route.h. */
#include "motion/route.h"

#include <math.h>

#define TOLERANCE 1e-3 /* m */
#define SINE 0.05      /* of the angle between two pieces, at most */
#define HALVINGS 12    /* of one stretch */

/* Four points of the curve, and the places of its parameter there: it goes from b to c. */
struct stretch {
	double points[4][2];
	double knots[4];
};

struct curve {
	struct route *route;
	struct stretch stretch;
};

/* Barry and Goldman's pyramid: three rounds of linear interpolation. */
static void at(const struct stretch *stretch, double t, double point[2])
{
	const double *k = stretch->knots;
	for (int i = 0; i < 2; i++) {
		double level[4];
		for (int j = 0; j < 4; j++)
			level[j] = stretch->points[j][i];
		for (int round = 1; round < 4; round++)
			for (int j = 0; j < 4 - round; j++) {
				const double low = k[round < 3 ? j : 1], high = k[round < 3 ? j + round : 2];
				level[j] = ((high - t) * level[j] + (t - low) * level[j + 1]) / (high - low);
			}
		point[i] = level[0];
	}
}

static double square_from_line(const double a[2], const double b[2], const double p[2])
{
	const double dx = b[0] - a[0], dy = b[1] - a[1], length = dx * dx + dy * dy;
	const double cross = dx * (p[1] - a[1]) - dy * (p[0] - a[0]);
	return length > 0 ? cross * cross / length : (p[0] - a[0]) * (p[0] - a[0]) + (p[1] - a[1]) * (p[1] - a[1]);
}

/* Tells whether the straight piece from a to b is near enough to the curve, whose middle is m. */
static bool is_straight(const struct stretch *stretch, double low, double high, const double a[2], const double m[2], const double b[2])
{
	double p[2];
	for (int i = 1; i < 4; i++) {
		at(stretch, low + (high - low) * i / 4, p);
		if (square_from_line(a, b, p) > TOLERANCE * TOLERANCE)
			return false;
	}
	const double ux = m[0] - a[0], uy = m[1] - a[1], vx = b[0] - m[0], vy = b[1] - m[1], cross = ux * vy - uy * vx;
	return cross * cross <= SINE * SINE * (ux * ux + uy * uy) * (vx * vx + vy * vy) && ux * vx + uy * vy >= 0;
}

/* Adds the points after `low` up to `high`. */
static enum status divide(const struct curve *curve, double low, double high, const double a[2], const double b[2], int halvings)
{
	const struct stretch *stretch = &curve->stretch;
	const double middle = (low + high) / 2;
	double m[2];
	at(stretch, middle, m);
	if (halvings < HALVINGS && (halvings == 0 || !is_straight(stretch, low, high, a, m, b))) {
		TRY(divide(curve, low, middle, a, m, halvings + 1));
		return divide(curve, middle, high, m, b, halvings + 1);
	}
	return motion_route_add(curve->route, (struct scene_waypoint){.x = b[0], .y = b[1]});
}

static double gap(const double a[2], const double b[2])
{
	return sqrt(hypot(b[0] - a[0], b[1] - a[1]));
}

/* Gives the pieces from `first` on their times and heights: even along the way between the two waypoints. */
static void spread(struct scene_path *path, size_t first, const struct scene_waypoint *from, const struct scene_waypoint *to)
{
	double length = 0, gone = 0;
	for (size_t i = first; i < path->count; i++)
		length += hypot(path->points[i].x - path->points[i - 1].x, path->points[i].y - path->points[i - 1].y);
	for (size_t i = first; i < path->count; i++) {
		struct scene_waypoint *point = &path->points[i];
		gone += hypot(point->x - path->points[i - 1].x, point->y - path->points[i - 1].y);
		const double share = i + 1 == path->count ? 1 : gone / length;
		point->t = share < 1 ? from->t + share * (to->t - from->t) : to->t;
		point->z = share < 1 ? from->z + share * (to->z - from->z) : to->z;
	}
}

/* The points before and after an end of an open path go straight on. */
static void beyond(const double a[2], const double b[2], double out[2])
{
	for (int i = 0; i < 2; i++)
		out[i] = 2 * a[i] - b[i];
}

static enum status add_stretch(const struct scene_path *path, const struct scene_waypoint *const around[4], struct route *route)
{
	struct curve curve = {.route = route};
	struct stretch *stretch = &curve.stretch;
	for (int i = 0; i < 4; i++)
		if (around[i] != NULL) {
			stretch->points[i][0] = around[i]->x;
			stretch->points[i][1] = around[i]->y;
		}
	if (around[0] == NULL)
		beyond(stretch->points[1], stretch->points[2], stretch->points[0]);
	if (around[3] == NULL)
		beyond(stretch->points[2], stretch->points[1], stretch->points[3]);
	for (int i = 1; i < 4; i++)
		stretch->knots[i] = stretch->knots[i - 1] + gap(stretch->points[i - 1], stretch->points[i]);
	const size_t first = route->path.count;
	TRY(divide(&curve, stretch->knots[1], stretch->knots[2], stretch->points[1], stretch->points[2], 0));
	if (path->timed || path->has_z)
		spread(&route->path, first, around[1], around[2]);
	return STATUS_OK;
}

static bool is_at(const struct scene_waypoint *a, const struct scene_waypoint *b)
{
	return a->x == b->x && a->y == b->y;
}

/* The next point at another place, in the direction `step`; NULL: there is none. */
static const struct scene_waypoint *other(const struct scene_path *path, size_t index, int step)
{
	const size_t count = path->count;
	for (size_t i = 0, at = index; i < count; i++) {
		if (!path->loop && at == (step > 0 ? count - 1 : 0))
			return NULL;
		at = (at + (step > 0 ? 1 : count - 1)) % count;
		if (!is_at(&path->points[at], &path->points[index]))
			return &path->points[at];
	}
	return NULL;
}

enum status motion_route_curve(const struct scene_path *path, struct route *route)
{
	motion_route_begin(route, path);
	enum status status;
	TRY_OR(done, motion_route_add(route, path->points[0]));
	const size_t stretches = path->count - (path->loop ? 0 : 1);
	for (size_t i = 0; i < stretches; i++) {
		const size_t next = (i + 1) % path->count;
		const struct scene_waypoint *const around[4] = {other(path, i, -1), &path->points[i], &path->points[next], other(path, next, 1)};
		if (is_at(around[1], around[2])) /* a pause, or a point twice */
			TRY_OR(done, motion_route_add(route, *around[2]));
		else
			TRY_OR(done, add_stretch(path, around, route));
	}
	/* A loop closes itself. */
	if (path->loop && route->path.count > 1)
		route->path.count--;
done:
	route->path.smooth = false;
	return status;
}
