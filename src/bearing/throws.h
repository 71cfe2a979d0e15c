/*
 * Thrown soil: what a surface that runs over the ground takes along of the soil that slip digs, how it leaves, and how it flies. Soil that falls off bodies flies alike.
 *
 * A grain is a packet of soil. Its volume is whole fixed-point units, 2^-20 m of height at one post. Its flight is a parabola in whole numbers, by the time
 * since it left, so no step size shows. All functions are pure. Any thread may call them.
 */
#ifndef FURROW_THROWN_H
#define FURROW_THROWN_H

#include "soil/soil.h"

/* Which share of the dug soil is thrown: F / (F + THROWN_HALF). F is the Froude number of the slip, u^2 / (g r): u the slip speed, g gravity, r the rim's radius.
 * At F = 1 the rim's slip would hold soil on it no longer than gravity does. This law and the constant are chosen, not measured. */
#define THROWN_HALF 1.0
#define THROWN_GRAINS 32    /* the most grains of a contact */
#define THROWN_SPREAD 5.0   /* degrees: how far a grain leaves beside the tangent at most, up or down and aside; chosen */
#define THROWN_LEAST 10.0   /* degrees: the least and the steepest angle at which it leaves, from the ground */
#define THROWN_MOST 80.0
#define THROWN_BITS 20      /* times are whole 2^-20 s, speeds whole 2^-20 m/s */

/* How a contact throws. Vectors are east, north, up. */
struct bearing_throw {
	double share;         /* of what slip digs, 0 .. 1; 0: it throws nothing, and the rest is not set */
	double seconds;       /* how long the motion took, above 0 */
	double speed[3];      /* m/s: of the body */
	double run;           /* m/s, above 0: of its surface along `back`, where that is lowest, beside the body */
	double back[3], up[3], along[3]; /* unit vectors: along the surface, away from the ground, and across both */
	double radius;        /* m: of the rim, or half the height of a body with a belt */
	double half_width;    /* m along `along` */
};
/* Tells how a body throws that moved so. seconds: how long that took; 0: not known. gravity: m/s2. One that was set down, that does not slip backwards below, or whose time is not known throws nothing. */
void bearing_throw_of(const struct soil_motion *motion, double seconds, double gravity, struct bearing_throw *out);

/* A grain in flight, from where it left. */
struct bearing_grain {
	int64_t from[3];      /* 2^-20 m from the south-west post; [2] absolute */
	int64_t since;        /* 2^-20 s of simulated time: when it left */
	int64_t volume;       /* fixed-point units */
	int32_t velocity[3];  /* 2^-20 m/s, where it left */
	int32_t flown;        /* 2^-20 s since then: until this time it is known to be in the air */
};
#define GRAIN_NUMBERS 9
/* Copies a grain to and from plain numbers, for a record. load returns false if the numbers are those of no grain. */
void bearing_grain_save(const struct bearing_grain *grain, int64_t numbers[GRAIN_NUMBERS]);
bool bearing_grain_load(const int64_t numbers[GRAIN_NUMBERS], struct bearing_grain *grain);

/*
 * Divides a volume into grains that leave during the motion, which ends at `since`, 2^-20 s. centre: of the body then, as in struct soil_pose. sinkage: m, how
 * deep the rim is in the ground. The cosine of the angle at which it comes out behind is 1 - sinkage / radius. There a grain leaves along the tangent, with the
 * rim's velocity over the ground. Place, time and number of a grain decide when it leaves, and by how much beside that. Returns how many grains there are,
 * 1 .. THROWN_GRAINS; 0: there is no volume.
 */
int bearing_throw_grains(const struct bearing_throw *how, const int64_t centre[3], double sinkage, int64_t since, int64_t volume, struct bearing_grain grains[THROWN_GRAINS]);

/* Soil that falls off a body. */
#define FALL_GRAINS 4       /* the most grains of a fall */
struct bearing_fall {
	int64_t from[3];    /* as in struct bearing_grain: where the last of it leaves */
	double speed[3];    /* m/s: of the body there */
	double spread;      /* m: it leaves so far beside that at most, east and north */
	double seconds;     /* s: how long it takes to leave */
	int64_t volume;     /* fixed-point units */
	int64_t most;       /* of a grain, above 0, unless there are FALL_GRAINS */
};
/* Divides it into grains that leave with the body's velocity until `since`, 2^-20 s, 0 or more. Place, time and number of a grain decide when and where beside that.
 * Returns how many there are, 1 .. FALL_GRAINS; 0: there is no volume. */
int bearing_fall_grains(const struct bearing_fall *fall, int64_t since, struct bearing_grain grains[FALL_GRAINS]);

#define GRAIN_LONGEST (1 << 26) /* 2^-20 s: the longest flight, 64 s */
/* Gives where a grain is after `flown`, 0 .. GRAIN_LONGEST. gravity: 2^-20 m/s2, up to 2^30. */
void bearing_grain_at(const struct bearing_grain *grain, int32_t gravity, int64_t flown, int64_t place[3]);

#endif
