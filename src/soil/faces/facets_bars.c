/* Facets of a wheel's bars (grousers) at turn 0, where the first bar is straight below the axle. shape/bars.c defines their section. */
#include "soil/faces/facets_making.h"

/* Returns the angle from a bar's middle to its edge, on the rim. */
static double half_angle(const struct soil_shape *shape)
{
	return asin(fmin(shape->grouser_thickness / 2 / shape->radius, 1));
}

double soil_facets_free_rim(const struct soil_shape *shape)
{
	return shape->grousers > 0 ? fmax(0, 1 - shape->grousers * half_angle(shape) / M_PI) : 1;
}

/* Returns the area of the wheel's section between its middle plane and a line `along` from it, on one side. */
static double area_to(double radius, double along)
{
	const double t = fmax(fmin(along, radius), -radius);
	return (t * sqrt(radius * radius - t * t) + radius * radius * asin(t / radius)) / 2;
}

/* The two ends of a bar: strips from the rim to the tip. out, back: unit vectors in the wheel's plane. */
static void put_ends(struct facets_making *m, const double out[3], const double back[3])
{
	const struct soil_shape *s = m->shape;
	const double half = s->grouser_thickness / 2, tip = s->radius + s->grouser_height;
	const int along = facets_parts(2 * half, m->size), up = facets_parts(s->grouser_height, m->size);
	for (int i = 0; i < along && !facets_full(m); i++) {
		const double from = half * (2.0 * i / along - 1), to = half * (2.0 * (i + 1) / along - 1), middle = (from + to) / 2;
		const double area = tip * (to - from) - (area_to(s->radius, to) - area_to(s->radius, from)), high = area / (to - from);
		for (int j = 0; j < 2 * up; j++) {
			const int side = j % 2 == 0 ? -1 : 1;
			const double far = tip - high * (1 - (j / 2 + 0.5) / up);
			const double at[3] = {far * out[0] + middle * back[0], side * s->width / 2, far * out[2] + middle * back[2]}, vector[3] = {0, side * area / up, 0};
			soil_facets_put(m, at, vector, FACET_BAR);
		}
	}
}

static void put_bar(struct facets_making *m, double angle)
{
	const struct soil_shape *s = m->shape;
	const double half = s->grouser_thickness / 2, tip = s->radius + s->grouser_height;
	const double inner = sqrt(fmax(0, s->radius * s->radius - half * half)), middle = (tip + inner) / 2, high = (tip - inner) / 4;
	/* From the axle out along the bar; the way along the rim, backwards for the lowest bar. */
	const double out[3] = {-sin(angle), 0, -cos(angle)}, back[3] = {-cos(angle), 0, sin(angle)};
	for (int side = -1; side <= 1; side += 2) {
		/* A face is two rectangles, one over the other: soil may reach only part of it. */
		for (int upper = -1; upper <= 1; upper += 2) {
			const double far = middle + upper * high;
			const double at[3] = {far * out[0] + side * half * back[0], 0, far * out[2] + side * half * back[2]};
			const double sides[2][3] = {{high * out[0], 0, high * out[2]}, {0, -side * s->width / 2, 0}};
			soil_facets_put_rectangle(m, at, sides, FACET_BAR);
		}
	}
	const double at[3] = {tip * out[0], 0, tip * out[2]}, sides[2][3] = {{half * back[0], 0, half * back[2]}, {0, s->width / 2, 0}};
	soil_facets_put_rectangle(m, at, sides, FACET_BAR);
	put_ends(m, out, back);
}

void soil_facets_put_bars(struct facets_making *m)
{
	for (int i = 0; i < m->shape->grousers && !facets_full(m); i++)
		put_bar(m, i * 2 * M_PI / m->shape->grousers);
}
