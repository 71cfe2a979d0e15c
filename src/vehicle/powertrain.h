/*
 * The powertrain and the brakes of a vehicle.
 *
 *     throttle -> engine -> clutch or converter -> gearbox -> centre differential -> axles' differentials -> wheels <- brakes
 *
 * The engine's speed is a state of its own. Every other part is without mass. In each step of MuJoCo all parts are solved together, for the velocities at its end. The
 * inertia of the wheels and of the vehicle counts, and what the soil resists. So no ratio, no lock and no brake makes a step unstable. A part is a row: a difference of
 * speeds that it takes away, by a torque up to a limit.
 *
 * 1. Torques of open differentials are shared alike. A locked one has no limit, a limited one that of its bias and lock.
 * 2. A brake whose limit is not reached holds its wheel at an angle: what it turned by rounding or by other forces is taken back. It does not creep.
 * 3. engine_work = change of the engine's kinetic energy + work at the wheels + `loss`, in every step.
 */
#ifndef FURROW_VEHICLE_POWERTRAIN_H
#define FURROW_VEHICLE_POWERTRAIN_H

#include "vehicle/internal.h"

enum { POWERTRAIN_BRAKE, POWERTRAIN_THROTTLE, POWERTRAIN_GEAR, POWERTRAIN_CONTROLS };

/* What a row takes away: slip of the clutch or the converter; differences between wheels, and between axles; the turn of a braked wheel. */
enum powertrain_kind { POWERTRAIN_INPUT, POWERTRAIN_AXLE, POWERTRAIN_CENTRE, POWERTRAIN_HOLDS };

struct powertrain_row {
	enum powertrain_kind kind;
	enum scene_differential differential; /* AXLE, CENTRE */
	double share;               /* AXLE, CENTRE: of the gearbox's torque, that each of its two sides has while both have the same torque */
	size_t wheel;               /* HOLDS */
};

struct powertrain_wheel {
	int dof;
	int motor;                  /* actuator by which it gets its torque; -1: it is not driven */
	double side;                /* 1: it rolls forward as its angle grows; -1: backward */
	double x;                   /* m ahead of the root, in the first pose */
	double share;               /* of the gearbox's torque, where all differentials are open; 0: it is not driven */
	bool rear;
	double drive, brake;        /* N m about the joint's axis, in the last step */
	bool holds;                 /* its brake did not reach its limit in the last step */
	double held;                /* rad: state; the angle at which its brake holds it; NaN: it does not */
};

struct powertrain {
	const struct scene_powertrain *scene; /* NULL: brakes alone */
	double brakes;              /* N m; 0: none */
	struct powertrain_wheel *wheels;
	size_t wheel_count;
	struct powertrain_row *rows;
	double *ways;               /* row_count x wheel_count: change of the row's speed by that of each dof; of the input without the gear's ratio */
	size_t row_count;
	double *room;               /* numbers for a step */
	size_t *listed;             /* row_count: for a step */
	signed char *bound;         /* row_count: for a step */
	double controls[POWERTRAIN_CONTROLS];
	/* State: */
	double speed;               /* rad/s of the engine */
	double gear;                /* -1: reverse; 0: none; 1 ...; that is in, or comes in when it has shifted */
	double shifting;            /* s until it is in */
	double input, boost;        /* N m: torque that the gearbox got last, and the converter's part of it that the engine does not give */
	double engine_work, loss, brake_work; /* J */
	/* Of the last step: */
	double torque;              /* N m of the engine */
	double now;                 /* N m: `input` of it */
	double before, slipping;    /* rad/s: of the engine at the step's start; N m: torque that the engine gave away */
};

/* Makes the powertrain or the brakes that the scene asks for; none: vehicle->train stays NULL. STATUS_INPUT: no wheel turns, or a pattern names none. */
enum status vehicle_make_powertrain(struct vehicle *vehicle, const char *where) FURROW_CHECKED;
void vehicle_free_powertrain(struct powertrain *train); /* takes NULL */

/* Controls of the powertrain follow those of the actuators, from the model's number of actuators on. */
static inline size_t vehicle_train_controls(const struct vehicle *vehicle)
{
	return vehicle->train == NULL ? 0 : vehicle->train->scene != NULL ? POWERTRAIN_CONTROLS : 1;
}
/* Returns how many controls the vehicle has: of its actuators, and then of its powertrain. */
static inline size_t vehicle_control_count(const struct vehicle *vehicle)
{
	return range_count(vehicle->own.actuator) + vehicle_train_controls(vehicle);
}
/* Returns the number of a control by its name, "throttle", "brake" or "gear"; -1: the vehicle has none of that name. */
int vehicle_train_find(const struct vehicle *vehicle, const char *name);
const char *vehicle_train_name(size_t control);
/* Returns the actuator of a name, or the control of the powertrain; -1: there is neither. */
int vehicle_control_find(const struct vehicle *vehicle, const char *name);
/* Sets the controls to what nobody asked for: no throttle, no brake, the highest gear. */
void vehicle_train_rest(struct vehicle *vehicle);

static inline bool vehicle_has_engine(const struct vehicle *vehicle)
{
	return vehicle->train != NULL && vehicle->train->scene != NULL;
}
/* Sets throttle and brake. effort: 1 full throttle ... 0 ... -1 full brakes. Does nothing without a powertrain; with brakes alone, below 0 only. */
void vehicle_train_effort(struct vehicle *vehicle, double effort);
/* Returns the effort that gives a vehicle this acceleration, m/s2 along the way, in its present gear and at its present speed, -1 .. 1. */
double vehicle_train_effort_for(const struct vehicle *vehicle, double acceleration);
/* Brakes fully, without throttle, so that a vehicle at rest holds. Does nothing without brakes. */
void vehicle_train_hold(struct vehicle *vehicle);

/* Returns true if a brake held the wheel of this freedom in the last step. Its contact carries the vehicle then, and not the wheel alone. */
bool vehicle_train_holds(const struct vehicle *vehicle, int dof);
/* Finds the torques of a step of h seconds, and gives them to MuJoCo, for all vehicles. After vehicle_couple, which has put the soil's forces and how they answer into qfrc_applied and
 * data->M, and before mj_step2. begins: false if the step is made once more, with other forces of the soil. Runs within a guard. */
void vehicle_trains_solve(struct vehicles *vehicles, double h, bool begins);
/* Takes the torques as they are: sums their works in the step that has just ended. before: nv, velocities at its start. Does nothing without a powertrain and brakes. */
void vehicle_train_sum(struct vehicle *vehicle, double h, const double *before);

/* Tells of the powertrain and the brakes. All is 0 without. */
void vehicle_train_tell(const struct vehicle *vehicle, struct vehicle_train *out);
/* Puts its controls behind those of the actuators, and their torques, N m. The throttle has that of the engine in the last step, the brake the sum over all
 * brakes, the gear 0. Either array may be NULL. */
void vehicle_train_tell_controls(const struct vehicle *vehicle, double *controls, double *forces);
/* Returns which key of `driver` sets a control; NULL: none. */
const char *vehicle_train_key(const struct vehicle *vehicle, size_t control);

/* Returns the engine's torque, N m, at a speed in rad/s and a throttle 0 .. 1, with its governor and its limit. */
double vehicle_engine_torque(const struct scene_powertrain *scene, double speed, double throttle);

/* The state as numbers of the record. */
size_t vehicle_train_numbers(const struct vehicle *vehicle);
double *vehicle_train_save(const struct vehicle *vehicle, double *to);
const double *vehicle_train_restore(struct vehicle *vehicle, const double *from);

/* powertrain_solve.c: finds torques x within limits. Each row's speed q x + c is 0 then, or its torque is at a limit and does not suffice. q: count x count,
 * symmetric positive. limits: above 0, or INFINITY. room: count (count + 3) numbers; bound: count. */
void vehicle_solve_bounded(const double *q, const double *c, const double *limits, size_t count, double *x, double *room, signed char *bound);

#endif
