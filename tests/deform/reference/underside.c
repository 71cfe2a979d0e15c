/*
 * An object's lower envelope along its way: at each time t (0 at the start, 1 at the end) the object
 * is above a point of the ground or not, and so far from being so that the distance is convex in
 * t, as is the height of its lower envelope while it is. So: search for the time at which it is most
 * above the point, bisect for when it comes and goes, search for the lowest between.
 */
#include <math.h>

#include "deform/reference/reference.h"

struct way {
	const struct deform_contact *sweep;
	long double dx, dy, dz; /* start to end, metres */
	long double x, y;       /* the point, from the start */
	long double axes[3][3]; /* the object's own x, y, z */
};

/* At one time: how far the object is from being above the point (<= 0: it is), and its lower envelope
 * there, from the centre's height at the start. */
struct sight {
	long double outside, z;
};

/* Axis k of the object: x, y or z turned right side down, then nose up, then by the yaw. */
static void turn(const struct soil_pose *pose, int k, long double v[3])
{
	long double a[3] = {k == 0, k == 1, k == 2}, b[3];
	long double cr = cosl(pose->roll), sr = sinl(pose->roll), cp = cosl(pose->pitch), sp = sinl(pose->pitch);
	long double cy = cosl(pose->yaw), sy = sinl(pose->yaw);
	b[0] = a[0];
	b[1] = a[1] * cr - a[2] * sr;
	b[2] = a[1] * sr + a[2] * cr;
	a[0] = b[0] * cp - b[2] * sp;
	a[1] = b[1];
	a[2] = b[0] * sp + b[2] * cp;
	v[0] = a[0] * cy - a[1] * sy;
	v[1] = a[0] * sy + a[1] * cy;
	v[2] = a[2];
}

static struct sight see_wheel(const struct way *way, long double x, long double y)
{
	const struct soil_shape *shape = way->sweep->shape;
	long double along = x * way->axes[0][0] + y * way->axes[0][1];
	long double across = x * way->axes[1][0] + y * way->axes[1][1];
	long double r = shape->radius;
	return (struct sight){fmaxl(fabsl(along) - r, fabsl(across) - shape->width / 2.0L),
			      -sqrtl(fmaxl(r * r - along * along, 0))};
}

static struct sight see_sphere(const struct way *way, long double x, long double y)
{
	long double r = way->sweep->shape->radius;
	return (struct sight){hypotl(x, y) - r, -sqrtl(fmaxl(r * r - x * x - y * y, 0))};
}

/* The vertical line through the point, cut by the box's three pairs of faces. */
static struct sight see_box(const struct way *way, long double x, long double y)
{
	long double enter = -1e30L, leave = 1e30L, beside = -1e30L;
	for (int k = 0; k < 3; k++) {
		const long double *v = way->axes[k];
		long double half = way->sweep->shape->size[k] / 2.0L;
		long double at = v[0] * x + v[1] * y;
		if (fabsl(v[2]) < 1e-12L) {
			beside = fmaxl(beside, fabsl(at) - half);
			continue;
		}
		long double a = (-half - at) / v[2], b = (half - at) / v[2];
		enter = fmaxl(enter, fminl(a, b));
		leave = fminl(leave, fmaxl(a, b));
	}
	return (struct sight){fmaxl(enter - leave, beside), enter};
}

/* Where the vertical line is inside a quadric: a z^2 + 2 b z + c <= 0. */
static struct sight inside(long double a, long double b, long double c)
{
	return (struct sight){0, (-b - sqrtl(fmaxl(b * b - a * c, 0))) / a};
}

static void axis_of(const struct way *way, long double w[3])
{
	const long double *own = way->axes[way->sweep->shape->kind == SOIL_WHEEL ? 1 : 2];
	for (int k = 0; k < 3; k++)
		w[k] = own[2] < 0 ? -own[k] : own[k];
}

/* The vertical line cut by an endless cylinder, and by the planes of its ends. It meets the cylinder if it meets one of the discs between
 * its ends, which are ellipses in plan. */
static struct sight see_cylinder(const struct way *way, long double x, long double y)
{
	const struct soil_shape *shape = way->sweep->shape;
	long double w[3], half = (shape->kind == SOIL_WHEEL ? shape->width : shape->length) / 2.0L, r = shape->radius;
	axis_of(way, w);
	long double c = hypotl(w[0], w[1]), along = x * w[0] + y * w[1], across = c > 0 ? (y * w[0] - x * w[1]) / c : 0;
	struct sight sight = {0, -1e30L};
	if (w[2] < 1e-15L)
		sight.outside = fmaxl(fabsl(across) - r, fabsl(along) - half);
	else
		sight.outside = c > 0 ? hypotl(fmaxl(fabsl(along / c / w[2]) - half * c / w[2], 0), across) - r : hypotl(x, y) - r;
	if (c > 0)
		sight.z = inside(c * c, -along * w[2], x * x + y * y - along * along - r * r).z;
	if (w[2] > 1e-15L)
		sight.z = fmaxl(sight.z, (-half - along) / w[2]);
	return sight;
}

/* The lowest of the side and of the two balls. */
static struct sight see_capsule(const struct way *way, long double x, long double y)
{
	const struct soil_shape *shape = way->sweep->shape;
	long double w[3], half = shape->length / 2.0L, r = shape->radius;
	axis_of(way, w);
	long double c = hypotl(w[0], w[1]), along = c > 0 ? (x * w[0] + y * w[1]) / c : 0, across = c > 0 ? (y * w[0] - x * w[1]) / c : hypotl(x, y);
	struct sight sight = {hypotl(fmaxl(fabsl(along) - half * c, 0), across) - r, 1e30L};
	for (int end = -1; end <= 1; end += 2) {
		long double dx = x - end * half * w[0], dy = y - end * half * w[1], squares = r * r - dx * dx - dy * dy;
		if (squares >= 0)
			sight.z = fminl(sight.z, end * half * w[2] - sqrtl(squares));
	}
	long double side = c > 0 && fabsl(across) <= r ? inside(c * c, -along * c * w[2], x * x + y * y - along * along * c * c - r * r).z : 1e30L;
	if (fabsl(along * c + side * w[2]) <= half)
		sight.z = fminl(sight.z, side);
	return sight;
}

static struct sight see_ellipsoid(const struct way *way, long double x, long double y)
{
	long double a = 0, b = 0, c = 0;
	for (int k = 0; k < 3; k++) {
		const long double *axis = way->axes[k];
		long double size = way->sweep->shape->size[k], level = (axis[0] * x + axis[1] * y) / size, up = axis[2] / size;
		a += up * up;
		b += up * level;
		c += level * level;
	}
	struct sight sight = inside(a, b, c - 1);
	sight.outside = sqrtl(fmaxl(c - b * b / a, 0)) - 1;
	return sight;
}

static struct sight see(const struct way *way, long double t)
{
	long double x = way->x - t * way->dx, y = way->y - t * way->dy;
	struct sight sight = {0, 0};
	switch (way->sweep->shape->kind) {
	case SOIL_WHEEL:
		sight = way->sweep->to.roll == 0 ? see_wheel(way, x, y) : see_cylinder(way, x, y);
		break;
	case SOIL_CYLINDER:
		sight = see_cylinder(way, x, y);
		break;
	case SOIL_CAPSULE:
		sight = see_capsule(way, x, y);
		break;
	case SOIL_ELLIPSOID:
		sight = see_ellipsoid(way, x, y);
		break;
	case SOIL_SPHERE:
		sight = see_sphere(way, x, y);
		break;
	case SOIL_BOX:
		sight = see_box(way, x, y);
		break;
	case SOIL_MESH:
	case SOIL_SHAPES:
		break;
	}
	sight.z += t * way->dz;
	return sight;
}

static long double measured(const struct way *way, long double t, bool height)
{
	struct sight sight = see(way, t);
	return height ? sight.z : sight.outside;
}

/* When the convex `height` or distance is least between two times. */
static long double least(const struct way *way, long double a, long double b, bool height)
{
	for (int i = 0; i < 110; i++) {
		long double p = a + (b - a) / 3, q = b - (b - a) / 3;
		if (measured(way, p, height) < measured(way, q, height))
			b = q;
		else
			a = p;
	}
	return (a + b) / 2;
}

/* The time nearest to `out` at which the object is above the point, as it is at `in`. */
static long double edge(const struct way *way, long double in, long double out)
{
	if (see(way, out).outside <= 0)
		return out;
	for (int i = 0; i < 70; i++) {
		long double middle = (in + out) / 2;
		if (see(way, middle).outside <= 0)
			in = middle;
		else
			out = middle;
	}
	return in;
}

/* Returns whether the point is too far from the whole way for the object ever to be above it. */
static bool is_far(const struct way *way)
{
	long double reach = (long double)soil_shape_bound(way->sweep->shape) + 1e-3L;
	return way->x < fminl(way->dx, 0) - reach || way->x > fmaxl(way->dx, 0) + reach || way->y < fminl(way->dy, 0) - reach ||
	       way->y > fmaxl(way->dy, 0) + reach;
}

static bool smooth(const struct way *way, long double *z)
{
	if (is_far(way))
		return false;
	if (way->dx == 0 && way->dy == 0 && way->dz == 0) {
		struct sight sight = see(way, 0);
		*z = sight.z;
		return sight.outside <= 0;
	}
	long double above = least(way, 0, 1, false);
	for (int end = 0; end < 2; end++)
		if (see(way, end).outside < see(way, above).outside)
			above = end;
	if (see(way, above).outside > 0)
		return false;
	long double first = edge(way, above, 0), last = edge(way, above, 1);
	long double lowest = see(way, least(way, first, last, true)).z;
	*z = fminl(lowest, fminl(see(way, first).z, see(way, last).z));
	return true;
}

bool reference_underside(const struct deform_contact *sweep, long double x, long double y, long double *z)
{
	struct way way = {
		.sweep = sweep,
		.dx = ldexpl((long double)(sweep->to.x - sweep->from.x), -OFFSET_BITS),
		.dy = ldexpl((long double)(sweep->to.y - sweep->from.y), -OFFSET_BITS),
		.dz = ldexpl((long double)(sweep->to.z - sweep->from.z), -OFFSET_BITS),
		.x = x,
		.y = y,
	};
	struct soil_pose level = sweep->to;
	if (sweep->shape->kind == SOIL_WHEEL) /* its pitch only spins it */
		level.pitch = 0;
	for (int k = 0; k < 3; k++)
		turn(&level, k, way.axes[k]);
	const long double whole[3] = {way.dx, way.dy, way.dz};
	if (sweep->shape->kind == SOIL_MESH)
		return reference_mesh(sweep, way.axes, whole, x, y, z);
	long double lug;
	bool covered = smooth(&way, z);
	if (sweep->shape->kind != SOIL_WHEEL || sweep->shape->grousers == 0 || !reference_lugs(sweep, way.axes, whole, x, y, &lug))
		return covered;
	*z = covered ? fminl(*z, lug) : lug;
	return true;
}
