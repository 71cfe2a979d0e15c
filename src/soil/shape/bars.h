/* A wheel's grousers as moving faces: shape/bars.c. The GPU's lower envelope and that of a probe draw the same faces. Pure. */
#ifndef FURROW_SOIL_BARS_H
#define FURROW_SOIL_BARS_H

#include "soil/soil.h"

/* The wheel's motion during the contact. The start, and the motion from there, m; from any place and any height. */
struct bars_motion {
	long double x, y, dx, dy;
	double z, dz;
	double turned; /* rad forwards */
};

/* A face of a bar, and its straight motion: m, from the same place as the wheel's. */
struct bar_face {
	double at[4][3];         /* its corners at the end of its own motion */
	double from[3], to[3];   /* a place of the bar at the start and at the end of that */
	bool resting;            /* it remains there after the contact */
};
typedef void (*bars_fn)(void *user, const struct bar_face *face);

/* Returns the share of a wheel's circumference along which its bars carry the soil between them: 0 without bars, 1 where they stand close together. */
double soil_bars_carry(const struct soil_shape *shape);

/* Calls `face` for each face that may lower the envelope. pose: at the contact's end. */
void soil_bars(const struct soil_shape *shape, const struct soil_pose *pose, const struct bars_motion *motion, bars_fn face, void *user);

#endif
