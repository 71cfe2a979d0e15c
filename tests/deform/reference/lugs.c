/* A wheel's grousers along its way: the wheel rolls evenly from one turn to the other, and is looked at many times. */
#include <math.h>

#include "deform/reference/reference.h"

#define LOOKS 100

/* The vertical line at `u` of the wheel's own plane, cut by the bar at an angle: its lower end. */
static bool cut(const struct deform_shape *shape, long double angle, long double u, long double *w)
{
	const long double out[2] = {-sinl(angle), -cosl(angle)}, along[2] = {-cosl(angle), sinl(angle)};
	long double half = shape->grouser_thickness / 2.0L, outer = shape->radius + (long double)shape->grouser_height;
	long double low = -1e30L, high = 1e30L;
	for (int k = 0; k < 2; k++) {
		const long double *v = k == 0 ? out : along;
		long double least = k == 0 ? 0 : -half, most = k == 0 ? outer : half;
		if (fabsl(v[1]) < 1e-15L) {
			if (v[0] * u < least || v[0] * u > most)
				return false;
			continue;
		}
		long double a = (least - v[0] * u) / v[1], b = (most - v[0] * u) / v[1];
		low = fmaxl(low, fminl(a, b));
		high = fminl(high, fmaxl(a, b));
	}
	*w = low;
	return low <= high;
}

bool reference_lugs(const struct deform_contact *sweep, const long double way[3], long double x, long double y,
		    long double *z)
{
	const struct deform_shape *shape = sweep->shape;
	long double c = cosl(sweep->to.yaw), s = sinl(sweep->to.yaw), turned = sweep->turned;
	bool found = false, moves = way[0] != 0 || way[1] != 0 || way[2] != 0 || turned != 0;
	for (int look = moves ? 0 : LOOKS; look <= LOOKS; look++) {
		long double t = (long double)look / LOOKS, px = x - t * way[0], py = y - t * way[1], w;
		if (fabsl(py * c - px * s) > shape->width / 2.0L)
			continue;
		for (int i = 0; i < shape->grousers; i++) {
			long double angle = sweep->to.turn - (1 - t) * turned + 2 * 3.14159265358979323846264L * i / shape->grousers;
			if (!cut(shape, angle, px * c + py * s, &w))
				continue;
			*z = found ? fminl(*z, w + t * way[2]) : w + t * way[2];
			found = true;
		}
	}
	return found;
}
