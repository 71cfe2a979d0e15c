/*
 * A mesh's lower envelope along its way, a triangle at a time: in straight motion a triangle fills the convex hull of its
 * three corners where it was and where it is. The lowest of a hull above a point lies in some triangle of three of its
 * corners, so all twenty are tried.
 */
#include <math.h>

#include "deform/reference/reference.h"

typedef long double place[3];

static long double side_of(const place a, const place b, long double x, long double y)
{
	return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
}

static bool height_in(const place a, const place b, const place c, long double x, long double y, long double *z)
{
	long double area = side_of(a, b, c[0], c[1]);
	long double u = side_of(b, c, x, y) / area, v = side_of(c, a, x, y) / area, w = side_of(a, b, x, y) / area;
	if (fabsl(area) < 1e-15L || u < 0 || v < 0 || w < 0)
		return false;
	*z = u * a[2] + v * b[2] + w * c[2];
	return true;
}

static bool above(const place hull[6], long double x, long double y, long double *lowest)
{
	bool found = false;
	int beside[4] = {0, 0, 0, 0};
	for (int i = 0; i < 6; i++) {
		beside[0] += hull[i][0] < x;
		beside[1] += hull[i][0] > x;
		beside[2] += hull[i][1] < y;
		beside[3] += hull[i][1] > y;
	}
	for (int k = 0; k < 4; k++)
		if (beside[k] == 6)
			return false;
	for (int i = 0; i < 6; i++)
		for (int j = i + 1; j < 6; j++)
			for (int k = j + 1; k < 6; k++) {
				long double z;
				if (!height_in(hull[i], hull[j], hull[k], x, y, &z))
					continue;
				*lowest = found ? fminl(*lowest, z) : z;
				found = true;
			}
	return found;
}

bool reference_mesh(const struct deform_contact *sweep, long double axes[3][3], const long double way[3], long double x,
		    long double y, long double *z)
{
	const struct soil_mesh *mesh = sweep->shape->mesh;
	bool found = false;
	for (uint32_t t = 0; t < mesh->triangle_count; t++) {
		place hull[6];
		long double lowest = 0;
		for (int i = 0; i < 6; i++)
			for (int k = 0; k < 3; k++) {
				const float *v = mesh->vertices[mesh->triangles[t][i % 3]];
				hull[i][k] = v[0] * axes[0][k] + v[1] * axes[1][k] + v[2] * axes[2][k] + (i < 3 ? 0 : way[k]);
			}
		if (!above((const place *)hull, x, y, &lowest))
			continue;
		*z = found ? fminl(*z, lowest) : lowest;
		found = true;
	}
	return found;
}
