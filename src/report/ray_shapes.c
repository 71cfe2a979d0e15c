/* Where a ray meets the shape of an object: closed forms, and triangles of meshes. Grousers and tyres do not count: a wheel is its cylinder. */
#include "report/ray_shapes.h"

#include <math.h>

#define LEAST 1e-12 /* m: a ray that begins on a surface does not meet it there again */

static double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Returns the smaller root above LEAST of a t^2 + 2 b t + c; INFINITY: none. */
static double first_root(double a, double b, double c)
{
	const double under = b * b - a * c;
	if (!(a > 0) || under < 0)
		return INFINITY;
	const double root = sqrt(under), near = (-b - root) / a, far = (-b + root) / a;
	return near > LEAST ? near : far > LEAST ? far : INFINITY;
}

/* An ellipsoid about the origin. */
static double of_ellipsoid(const double radii[3], const double origin[3], const double way[3])
{
	double from[3], along[3];
	for (int i = 0; i < 3; i++) {
		from[i] = origin[i] / radii[i];
		along[i] = way[i] / radii[i];
	}
	return first_root(dot(along, along), dot(from, along), dot(from, from) - 1);
}

static double of_box(const double size[3], const double origin[3], const double way[3])
{
	double in = -INFINITY, out = INFINITY;
	for (int i = 0; i < 3; i++) {
		const double half = size[i] / 2;
		if (way[i] == 0) {
			if (fabs(origin[i]) > half)
				return INFINITY;
			continue;
		}
		const double one = (-half - origin[i]) / way[i], other = (half - origin[i]) / way[i];
		in = fmax(in, fmin(one, other));
		out = fmin(out, fmax(one, other));
	}
	return in > out ? INFINITY : in > LEAST ? in : out > LEAST ? out : INFINITY;
}

static double of_ball_at(double z, double radius, const double origin[3], const double way[3])
{
	const double from[3] = {origin[0], origin[1], origin[2] - z};
	return first_root(dot(way, way), dot(from, way), dot(from, from) - radius * radius);
}

/* A cylinder about z. `round`: its ends are balls, as of a capsule, and not flat. */
static double of_rod(double radius, double length, bool round, const double origin[3], const double way[3])
{
	const double a = way[0] * way[0] + way[1] * way[1], b = origin[0] * way[0] + origin[1] * way[1], c = origin[0] * origin[0] + origin[1] * origin[1] - radius * radius;
	const double half = length / 2, under = b * b - a * c;
	double first = INFINITY;
	for (int side = -1; side <= 1 && a > 0 && under >= 0; side += 2) {
		const double t = (-b + side * sqrt(under)) / a;
		if (t > LEAST && fabs(origin[2] + t * way[2]) <= half)
			first = fmin(first, t);
	}
	for (int end = -1; end <= 1; end += 2) {
		const double t = round ? of_ball_at(end * half, radius, origin, way) : way[2] != 0 ? (end * half - origin[2]) / way[2] : INFINITY;
		const double x = origin[0] + t * way[0], y = origin[1] + t * way[1];
		if (t > LEAST && isfinite(t) && (round || x * x + y * y <= radius * radius))
			first = fmin(first, t);
	}
	return first;
}

/* Moeller and Trumbore 1997. */
static double of_triangle(const float *a, const float *b, const float *c, const double origin[3], const double way[3])
{
	const double e[3] = {b[0] - (double)a[0], b[1] - (double)a[1], b[2] - (double)a[2]}, f[3] = {c[0] - (double)a[0], c[1] - (double)a[1], c[2] - (double)a[2]};
	const double p[3] = {way[1] * f[2] - way[2] * f[1], way[2] * f[0] - way[0] * f[2], way[0] * f[1] - way[1] * f[0]};
	const double volume = dot(e, p);
	if (volume == 0)
		return INFINITY;
	const double s[3] = {origin[0] - a[0], origin[1] - a[1], origin[2] - a[2]}, u = dot(s, p) / volume;
	const double q[3] = {s[1] * e[2] - s[2] * e[1], s[2] * e[0] - s[0] * e[2], s[0] * e[1] - s[1] * e[0]}, v = dot(way, q) / volume;
	const double t = dot(f, q) / volume;
	return u >= 0 && v >= 0 && u + v <= 1 && t > LEAST ? t : INFINITY;
}

static double of_mesh(const struct soil_mesh *mesh, const double origin[3], const double way[3])
{
	double size[3], from[3], first = INFINITY;
	for (int i = 0; i < 3; i++) {
		size[i] = mesh->high[i] - mesh->low[i] + 1e-6;
		from[i] = origin[i] - (mesh->high[i] + mesh->low[i]) / 2;
	}
	if (isinf(of_box(size, from, way)))
		return INFINITY;
	for (uint32_t i = 0; i < mesh->triangle_count; i++) {
		const uint32_t *corners = mesh->triangles[i];
		first = fmin(first, of_triangle(mesh->vertices[corners[0]], mesh->vertices[corners[1]], mesh->vertices[corners[2]], origin, way));
	}
	return first;
}

double report_ray_shape(const struct soil_shape *shape, const double origin[3], const double way[3])
{
	switch (shape->kind) {
	case SOIL_SPHERE:
		return of_ball_at(0, shape->radius, origin, way);
	case SOIL_ELLIPSOID:
		return of_ellipsoid(shape->size, origin, way);
	case SOIL_BOX:
		return of_box(shape->size, origin, way);
	case SOIL_CYLINDER:
	case SOIL_CAPSULE:
		return of_rod(shape->radius, shape->length, shape->kind == SOIL_CAPSULE, origin, way);
	case SOIL_WHEEL: /* its axis is y */
		return of_rod(shape->radius, shape->width, false, (const double[]){origin[2], origin[0], origin[1]}, (const double[]){way[2], way[0], way[1]});
	default:
		return of_mesh(shape->mesh, origin, way);
	}
}
