/* Facets of shapes that are round: drums (wheels and cylinders) and balls (spheres, capsules and ellipsoids). */
#include "soil/faces/facets_making.h"

/* One flat end of a drum: rings of sectors. A place is the middle of its sector's area. */
static void put_disc(struct facets_making *m, int axis, int side, double radius, double height)
{
	const int a = (axis + 1) % 3, b = (axis + 2) % 3, rings = facets_parts(radius, m->size);
	for (int i = 0; i < rings && !facets_full(m); i++) {
		const double r0 = radius * i / rings, r1 = radius * (i + 1) / rings;
		const int sectors = facets_sectors(r1, m->size, FACETS_CIRCLE * r1 / radius);
		const double step = 2 * M_PI / sectors, area = (r1 * r1 - r0 * r0) / 2 * step;
		const double out = 2.0 / 3 * (r1 * r1 + r1 * r0 + r0 * r0) / (r1 + r0) * sin(step / 2) / (step / 2);
		for (int k = 0; k < sectors; k++) {
			const double angle = (k + 0.5) * step;
			double at[3], vector[3] = {0};
			at[a] = out * cos(angle);
			at[b] = out * sin(angle);
			at[axis] = side * height;
			vector[axis] = side * area;
			soil_facets_put(m, at, vector, FACET_SIDE);
		}
	}
}

/* A drum about one of the body's own axes, with flat ends. m. */
void soil_facets_put_drum(struct facets_making *m, int axis, double radius, double length)
{
	const int a = (axis + 1) % 3, b = (axis + 2) % 3, sectors = facets_sectors(radius, m->size, FACETS_CIRCLE), across = facets_parts(length, m->size);
	const double step = 2 * M_PI / sectors, area = radius * step * length / across;
	for (int k = 0; k < sectors && !facets_full(m); k++) {
		const double c = cos((k + 0.5) * step), s = sin((k + 0.5) * step);
		for (int i = 0; i < across; i++) {
			double at[3], vector[3] = {0};
			at[a] = radius * c;
			at[b] = radius * s;
			at[axis] = length * ((i + 0.5) / across - 0.5);
			vector[a] = area * c;
			vector[b] = area * s;
			soil_facets_put(m, at, vector, FACET_UNDER);
		}
	}
	for (int side = -1; side <= 1; side += 2)
		put_disc(m, axis, side, radius, length / 2);
}

/* Returns the axis about which a ball is most nearly round. */
static int pole_of(const double half[3])
{
	int pole = 2;
	double least = INFINITY;
	for (int k = 2; k >= 0; k--) {
		const double apart = fabs(log(half[(k + 1) % 3] / half[(k + 2) % 3]));
		if (apart < least) {
			least = apart;
			pole = k;
		}
	}
	return pole;
}

/* A ring of the unit ball between two angles from its pole. It is drawn out to the half axes, and its halves move apart. */
static void put_ring(struct facets_making *m, const double half[3], int pole, double straight, const double from_pole[2], int sectors)
{
	const int a = (pole + 1) % 3, b = (pole + 2) % 3;
	const double t0 = from_pole[0], t1 = from_pole[1], step = 2 * M_PI / sectors, area = (cos(t0) - cos(t1)) * step;
	/* The mean of the sector's normals, across the pole and along it. */
	const double across = ((t1 - t0) / 2 - (sin(2 * t1) - sin(2 * t0)) / 4) * 2 * sin(step / 2), along = (sin(t1) * sin(t1) - sin(t0) * sin(t0)) / 2 * step;
	const double by = 1 / hypot(across, along);
	for (int k = 0; k < sectors; k++) {
		double unit[3], at[3], vector[3];
		unit[a] = across * by * cos((k + 0.5) * step);
		unit[b] = across * by * sin((k + 0.5) * step);
		unit[pole] = along * by;
		for (int i = 0; i < 3; i++) {
			at[i] = half[i] * unit[i];
			vector[i] = half[(i + 1) % 3] * half[(i + 2) % 3] * unit[i] * area;
		}
		at[pole] += along < 0 ? -straight / 2 : straight / 2;
		soil_facets_put(m, at, vector, FACET_UNDER);
	}
}

/* An ellipsoid of these half axes, m, whose halves are apart by `straight` along its z: there it is a cylinder. Only a sphere is drawn apart. */
void soil_facets_put_ball(struct facets_making *m, const double half[3], double straight)
{
	const int pole = straight > 0 ? 2 : pole_of(half), a = (pole + 1) % 3, b = (pole + 2) % 3;
	const double around = fmax(half[a], half[b]);
	const int rings = facets_sectors(fmax(around, half[pole]), m->size, FACETS_CIRCLE) / 2;
	for (int i = 0; i < rings && !facets_full(m); i++) {
		const double from_pole[2] = {M_PI * i / rings, M_PI * (i + 1) / rings};
		const double widest = (i + 1) * 2 <= rings ? sin(from_pole[1]) : sin(from_pole[0]);
		put_ring(m, half, pole, straight, from_pole, facets_sectors(around * widest, m->size, fmax(FACETS_CIRCLE * widest, FACETS_CIRCLE / 2.0)));
	}
	if (!(straight > 0))
		return;
	const int sectors = facets_sectors(around, m->size, FACETS_CIRCLE), up = facets_parts(straight, m->size);
	const double step = 2 * M_PI / sectors, area = around * step * straight / up;
	for (int k = 0; k < sectors && !facets_full(m); k++)
		for (int i = 0; i < up; i++) {
			const double c = cos((k + 0.5) * step), s = sin((k + 0.5) * step);
			const double at[3] = {around * c, around * s, straight * ((i + 0.5) / up - 0.5)}, vector[3] = {area * c, area * s, 0};
			soil_facets_put(m, at, vector, FACET_UNDER);
		}
}
