/* What the files of the reference of scm share. */
#ifndef FURROW_DEFORM_REFERENCE_SCM_H
#define FURROW_DEFORM_REFERENCE_SCM_H

#include <math.h>

#include "deform/reference/reference.h"

struct vector {
	double x, y, z;
};

static inline double dot(struct vector a, struct vector b)
{
	return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct vector cross(struct vector a, struct vector b)
{
	return (struct vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline struct vector plus(struct vector a, double times, struct vector b)
{
	return (struct vector){a.x + times * b.x, a.y + times * b.y, a.z + times * b.z};
}

/* How far a body went along the ground whose way in plan is `length` long, `ahead` of it forward, and rises by `rise`. Motions between 45 and 63
 * degrees steep fade out: those are not along the ground. */
static inline double reference_along(double length, double ahead, double rise)
{
	double counts = ahead != 0 ? fmin(fmax(2 - fabs(rise / ahead), 0), 1) : 0;
	return hypot(length, counts * rise);
}

/* scm.c. The normal of the ground without what is heaped on it. */
struct vector reference_normal_at(const struct reference_ground *ground, int at);
/* Along a surface with this unit normal, towards the body: the direction in which a belt runs over it. Across the body's left axis its length
 * is that of the normal's part across that axis. */
struct vector reference_belt_along(const struct soil_pose *pose, struct vector normal);
/* How the object's surface at a place from its centre moved over the contact. */
struct vector reference_way_at(const struct deform_contact *sweep, double turned, struct vector from_centre);
/* What remains of a sinkage when the load is gone. */
double reference_stays(const struct soil_numbers *soil, double stiffness, double largest);

/* Shear at a surface, as shares of the soil's strength to the east and to the north when it is turned level, after the object's
 * surface moved along it. Returns it as a vector along the surface. */
struct vector reference_shear(const double before[2], struct vector normal, struct vector along, double modulus, double after[2]);

/* cell.c. What the soil of one post's cell does to the object. `since`: what a call before slip dug told; NAN: of the ground as it is. */
struct cell_force {
	struct vector force, moment; /* N, N m about the object's centre at the contact's end */
	double normal;               /* N, the vertical part of the normal stress */
	double area;                 /* m2 that bear */
	double since;                /* contacts since the post was first in contact, if the object always moved as now */
	double rim;                  /* the time of a wheel's rim, as a share of the soil's time; of others 1 */
	struct vector slid, normal_then; /* m: how the underside slid along itself over the post, in contact; its normal half way */
};
struct cell_force reference_cell(const struct reference_ground *ground, const struct soil_numbers *soil, double stiffness,
				 const struct deform_contact *sweep, int at, const double *under, const double *rests,
				 double lower, double since);

#endif
