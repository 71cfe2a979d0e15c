/* A wheel's grousers along its way: the wheel rolls evenly from one turn to the other, and is looked at many times. */
#include <math.h>

#include "deform/reference/reference.h"

#define LOOKS 100

/* The vertical line at (x, y) from the axle, cut by the bar at an angle: its lower end. axes: the wheel's, at no turn. */
static bool cut(const struct soil_shape *shape, long double axes[3][3], long double angle, long double x, long double y, long double *z)
{
	long double half = shape->grouser_thickness / 2.0L, outer = shape->radius + (long double)shape->grouser_height, c = cosl(angle), s = sinl(angle);
	const long double least[3] = {0, -half, -shape->width / 2.0L}, most[3] = {outer, half, shape->width / 2.0L};
	long double low = -1e30L, high = 1e30L;
	for (int k = 0; k < 3; k++) {
		long double v[3]; /* outwards, along the rim, along the axle */
		for (int i = 0; i < 3; i++)
			v[i] = k == 0 ? -s * axes[0][i] - c * axes[2][i] : k == 1 ? -c * axes[0][i] + s * axes[2][i] : axes[1][i];
		long double at = v[0] * x + v[1] * y;
		if (fabsl(v[2]) < 1e-15L) {
			if (at < least[k] || at > most[k])
				return false;
			continue;
		}
		long double a = (least[k] - at) / v[2], b = (most[k] - at) / v[2];
		low = fmaxl(low, fminl(a, b));
		high = fminl(high, fmaxl(a, b));
	}
	*z = low;
	return low <= high;
}

bool reference_lugs(const struct deform_contact *sweep, long double axes[3][3], const long double way[3], long double x, long double y,
		    long double *z)
{
	const struct soil_shape *shape = sweep->shape;
	bool found = false, moves = way[0] != 0 || way[1] != 0 || way[2] != 0 || sweep->turned != 0;
	for (int look = moves ? 0 : LOOKS; look <= LOOKS; look++) {
		long double t = (long double)look / LOOKS, w;
		for (int i = 0; i < shape->grousers; i++) {
			long double angle = sweep->to.turn - (1 - t) * sweep->turned + 2 * 3.14159265358979323846264L * i / shape->grousers;
			if (!cut(shape, axes, angle, x - t * way[0], y - t * way[1], &w))
				continue;
			*z = found ? fminl(*z, w + t * way[2]) : w + t * way[2];
			found = true;
		}
	}
	return found;
}
