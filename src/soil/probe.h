/* Probing: how the soil bears a body in a pose, and how that changes with its pose and its velocity. src/soil/probe.c. */
#ifndef FURROW_SOIL_PROBE_H
#define FURROW_SOIL_PROBE_H

#include "soil/soil.h"

struct soil_probed {
	bool known;                   /* false: the planes have not all posts below the body with their neighbours. Then nothing else is set */
	double force[3], moment[3];   /* N, and N m about the body's centre; east, north, up */
	double stiffness[6][6];       /* d(force, moment) / d(translation, rotation about east, north, up): N/m, N, N, N m/rad */
	double damping[6][6];         /* the same of their rates */
	double normal[3];             /* mean normal of the base where the body bears; NAN without contact */
	double pull;                  /* N: as in struct soil_forces */
	double normal_force;          /* N: the normal stress times the body's surface, summed */
	double shear_limit;           /* N: the most that shear can hold, summed in the same way */
	double sinkage, area;         /* as in struct soil_forces */
	enum soil_state state;        /* SOIL_SLIDES: shear is at its limit. SOIL_SUNK: deeper than the body is high */
};

/* Computes the force of the soil on a body at motion->to, without its load: to the bit as soil_press_body would tell it. Changes nothing. Any
 * thread; `work` belongs to one. STATUS_MEMORY. */
enum status soil_probe(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, struct soil_work *work,
		       struct soil_probed *out) FURROW_CHECKED;

#endif
