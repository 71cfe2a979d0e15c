/* Convex polygons of the ground, in plan: cut along lines, and summed. Pure. */
#ifndef FURROW_SOIL_POLYGON_H
#define FURROW_SOIL_POLYGON_H

#include "soil/law/form.h"

#define CORNERS 12     /* of a cell that is cut by a parallelogram: eight, and some to spare */

struct polygon {
	int count;
	double at[CORNERS][2];
};

/* Leaves what is on the side of a line where normal . at <= limit. */
static inline void cut_polygon(const double normal[2], double limit, struct polygon *p)
{
	struct polygon cut = {.count = 0};
	for (int i = 0; i < p->count; i++) {
		const double *a = p->at[i], *b = p->at[(i + 1) % p->count];
		const double from = normal[0] * a[0] + normal[1] * a[1] - limit, to = normal[0] * b[0] + normal[1] * b[1] - limit;
		if (from <= 0 && cut.count < CORNERS) {
			cut.at[cut.count][0] = a[0];
			cut.at[cut.count++][1] = a[1];
		}
		if (((from < 0 && to > 0) || (from > 0 && to < 0)) && cut.count < CORNERS) {
			const double share = from / (from - to);
			for (int k = 0; k < 2; k++)
				cut.at[cut.count][k] = a[k] + share * (b[k] - a[k]);
			cut.count++;
		}
	}
	*p = cut;
}

/* The area of a part of the ground, and its moments: x, y, xx, xy, yy. */
struct amounts {
	double area, by[5];
};

/* Adds those of a polygon, seen from the origin. */
static inline struct amounts amounts_of(const struct polygon *p)
{
	struct amounts sum = {.area = 0};
	for (int i = 1; i + 1 < p->count; i++) {
		const double *a = p->at[0], *b = p->at[i], *c = p->at[i + 1];
		const double area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]));
		/* A triangle has the moments of its sides' middles. */
		for (int k = 0; k < 3; k++) {
			const double *u = k == 0 ? a : k == 1 ? b : c, *v = k == 0 ? b : k == 1 ? c : a, x = 0.5 * (u[0] + v[0]), y = 0.5 * (u[1] + v[1]), third = area / 3;
			sum.by[0] += third * x;
			sum.by[1] += third * y;
			sum.by[2] += third * x * x;
			sum.by[3] += third * x * y;
			sum.by[4] += third * y * y;
		}
		sum.area += area;
	}
	return sum;
}

#endif
