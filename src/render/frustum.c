/* Boxes against a camera: planes, visibility, distance; and the ground a tile covers. */
#include "render/select.h"

#include <math.h>

void render_box(const struct extent *extent, struct tile tile, double low[2], double high[2])
{
	double side = extent_spacing(extent, tile.level) * extent->cells;
	low[0] = tile.x * side;
	low[1] = tile.y * side;
	high[0] = fmin(low[0] + side, (double)(extent->width - 1) * extent->spacing);
	high[1] = fmin(low[1] + side, (double)(extent->height - 1) * extent->spacing);
}

static void plane_through(const double eye[3], const double normal[3], double plane[4])
{
	double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
	for (int i = 0; i < 3; i++)
		plane[i] = normal[i] / length;
	plane[3] = -(plane[0] * eye[0] + plane[1] * eye[1] + plane[2] * eye[2]);
}

void render_frustum(const double eye[3], const double forward[3], const double right[3],
		     const double up[3], double fov, double aspect, double far, double planes[5][4])
{
	double high = tan(fov / 2), wide = high * aspect;
	double normals[4][3];
	for (int i = 0; i < 3; i++) {
		normals[0][i] = wide * forward[i] + right[i];
		normals[1][i] = wide * forward[i] - right[i];
		normals[2][i] = high * forward[i] + up[i];
		normals[3][i] = high * forward[i] - up[i];
	}
	for (int i = 0; i < 4; i++)
		plane_through(eye, normals[i], planes[i]);
	double end[3], back[3];
	for (int i = 0; i < 3; i++) {
		end[i] = eye[i] + far * forward[i];
		back[i] = -forward[i];
	}
	plane_through(end, back, planes[4]);
}

bool render_box_visible(const double planes[5][4], const double low[3], const double high[3])
{
	for (int p = 0; p < 5; p++) {
		/* The corner furthest along the plane's normal; hidden if even that is outside. */
		double reach = planes[p][3];
		for (int i = 0; i < 3; i++)
			reach += planes[p][i] * (planes[p][i] > 0 ? high[i] : low[i]);
		if (reach < 0)
			return false;
	}
	return true;
}

double render_box_distance(const double eye[3], const double low[3], const double high[3])
{
	double sum = 0;
	for (int i = 0; i < 3; i++) {
		double gap = fmax(fmax(low[i] - eye[i], eye[i] - high[i]), 0);
		sum += gap * gap;
	}
	return sqrt(sum);
}
