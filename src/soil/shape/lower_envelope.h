/*
 * The lower envelope of a shape in one attitude, in doubles, for the CPU: how low the shape is above a place. The GPU computes the same in whole
 * numbers (src/deform/shape/envelope.c). Pure.
 */
#ifndef FURROW_SOIL_LOWER_ENVELOPE_H
#define FURROW_SOIL_LOWER_ENVELOPE_H

#include "soil/soil.h"

/* A shape in one attitude. Prepared once, then read at many places. Points to the shape, which must live as long. */
struct lower_envelope {
	const struct soil_shape *shape;
	double axes[3][3];  /* the shape's own axes: forward, left, up; a wheel's are not turned about its axle */
	double axis[3];     /* wheel, cylinder, capsule: the axis that the shape is round about; its z is 0 or more */
	double along[2];    /* direction of that axis in plan, a unit vector */
	double level;       /* length of that axis in plan: 1: the axis is level; 0: it is upright */
	double radius, half; /* wheel, cylinder, capsule: half the length of the straight part of the axis, m */
	double turn;        /* wheel: where the grousers are, rad */
	double beside;      /* m: a place that lies beside the shape by less is taken as below its edge; soil_lower_of sets 0 */
	double rise[2], lift, inside[3]; /* ellipsoid: z = rise.p - lift sqrt(1 - q(p)), q(p) = inside[0] x2 + 2 inside[1] x y + inside[2] y2 */
};

/* A place of the lower envelope. Height from the shape's centre, m; unit normal into the shape, its z is 0 or more. */
struct lower_place {
	double z, normal[3];
};

/* Prepares the lower envelope in the attitude of `pose`; its place does not count. */
void soil_lower_of(const struct soil_shape *shape, const struct soil_pose *pose, struct lower_envelope *lower);
/* Finds the lower envelope above a place, x and y from the centre, m. Returns false if the shape is not above it. */
bool soil_lower_at(const struct lower_envelope *lower, double x, double y, struct lower_place *place);
/* Computes the axis that a wheel, cylinder or capsule is round about: a unit vector whose z is 0 or more. */
void soil_shape_axis(const struct soil_shape *shape, const struct soil_pose *pose, double axis[3]);
/* Computes `rise`, `lift` and `inside` (struct lower_envelope) of an ellipsoid with these half axes along `axes`. */
void soil_ellipsoid_of(const double radii[3], double axes[3][3], double rise[2], double *lift, double inside[3]);

#endif
