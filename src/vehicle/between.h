/*
 * Vehicles of one scene that touch each other.
 *
 * Each vehicle is a MuJoCo world of its own. So one more model has the colliding geoms of all of them, side by side and without
 * joints. MuJoCo finds there which geoms of two vehicles touch (meet.c). Forces of these contacts go to both vehicles (push.c).
 * Nothing of it has a memory: all follows from the vehicles' states.
 */
#ifndef FURROW_VEHICLE_BETWEEN_H
#define FURROW_VEHICLE_BETWEEN_H

#include "vehicle/internal.h"

/* A geom of a vehicle that can touch another vehicle. */
struct part {
	size_t vehicle;
	int geom;                   /* of the vehicle's model */
	int here;                   /* of the common model */
};

/* Two geoms that touch, at one place. */
struct meeting {
	size_t vehicle[2];
	int geom[2];
	double point[2][3];         /* m: the place, in each vehicle's MuJoCo axes */
	double axes[3][3];          /* unit vectors: the normal from the first vehicle to the second, and two along the surface */
	double gap;                 /* m: below 0 they push */
	double depth;               /* m: how deep one is in the other */
	double friction, reference[2], impedance[5]; /* MuJoCo's, mixed from both geoms */
	/* push.c: */
	double *rows[2], *solved[2]; /* 3 x nv: what gives velocities along the axes, and these through the inverse of the inertia */
	double target, soft;        /* m/s, 1/kg */
	double inverse, along;      /* 1/kg: of the normal, and the greatest of directions along the surface */
	double force[3];            /* N, on the second vehicle */
};

/* What a vehicle does until the end of the time step. */
struct mover {
	double *inertia;            /* nv x nv, factored */
	double *velocity;           /* nv: at the end */
	bool meets, whole;          /* touches another one; its inertia could be factored */
	double middle[3], radius;   /* m: of a ball around its parts */
};

struct between {
	mjModel *model;
	mjData *data;
	size_t *order;              /* the vehicles by name, so that their order in the scene changes no bit */
	struct part *parts;         /* those of a vehicle are neighbours */
	size_t *first;              /* of vehicle v: parts first[v] .. first[v + 1] - 1 */
	struct mover *movers;
	struct meeting *meetings;
	size_t count, room;
	double *rows;               /* room for the rows of all meetings */
	size_t row_room;
};

/* Makes the common model. NULL in vehicles->between if there is one vehicle only. */
enum status vehicle_between_create(struct vehicles *vehicles) FURROW_CHECKED;
void vehicle_between_destroy(struct vehicles *vehicles);

/* --- meet.c --- */

/* Finds where vehicles touch each other now, and notes it in vehicles->between. Places of all bodies are known. */
enum status vehicle_between_find(struct vehicles *vehicles) FURROW_CHECKED;
/* STATUS_INPUT: a vehicle is inside another one. */
enum status vehicle_between_check_start(struct vehicles *vehicles) FURROW_CHECKED;

/* --- boxes.c --- */

/* One place where two geoms touch. */
struct touch {
	double gap, place[3], normal[3]; /* normal: from the first to the second */
};
#define TOUCHES_MOST 16
/* Finds where two boxes are nearer than `margin`. `mat`: their axes as columns; `size`: half their edges. Returns the number of places,
 * at most TOUCHES_MOST. */
int vehicle_boxes_touch(const double *const middle[2], const double *const mat[2], const double *const size[2], double margin, struct touch *out);

/* --- push.c --- */

/* Finds the forces that vehicles have on each other in this time step, and notes them in vehicle->pushed. All vehicles have begun
 * their step (vehicle_prepare). */
enum status vehicle_between_push(struct vehicles *vehicles) FURROW_CHECKED;

#endif
