/* Shared by steering.c, steering_poses.c and steering_table.c: the trial of what actuators do to the wheels. */
#ifndef FURROW_VEHICLE_STEERING_H
#define FURROW_VEHICLE_STEERING_H

#include "vehicle/internal.h"

#define EACH_WAY 16     /* curvatures of the table to each side */
#define ROWS_MOST 400   /* equalities and actuators: with more, the model is taken for plain */
#define TRIAL 1e-3      /* rad or m: of a trial movement */

/* A wheel or a belt, in the axes of the root body. */
struct rolling {
	int dof;
	bool belt;
	bool trails;          /* a castor's, or a trailer's: it heads where it is pulled */
	double radius;        /* m; signed for a belt */
	const struct soil_geom *geom;
};

struct trial {
	const struct vehicle *vehicle;
	mjModel *model;
	mjData *data;
	const int *steer, *drive;
	int steer_count, drive_count;
	double *length0;          /* of steering actuators in the first pose */
	struct rolling *wheels;
	size_t wheel_count;
	double *rows, *matrix, *right; /* room: ROWS_MOST x dofs, ROWS_MOST squared, ROWS_MOST */
	double *share;            /* drive_count x wheel_count: rate of a wheel for a rate of the actuator */
	double *fitting;          /* room for fit */
};

static inline int vehicle_trial_dofs(const struct trial *trial)
{
	return (int)range_count(trial->vehicle->own.dof);
}

/* --- steering_poses.c --- */

/* Brings the trial's pose to that in which steering actuators are longer by `lengths`, from the first pose on. Returns false if none is found. */
bool vehicle_trial_pose(struct trial *trial, const double *lengths);
/* Finds how joints move if one actuator alone becomes longer by 1, for each of them. `motions`: count rows, with a number for each freedom of the vehicle.
 * Returns false if a motion is not found. */
bool vehicle_trial_motions(struct trial *trial, const int *actuators, int count, double *motions);

/* --- steering_table.c --- */

/* Fills the table of the steering. Returns false if no curvature to one of the sides is found. */
bool vehicle_trial_table(struct trial *trial, struct steering *steering);

#endif
