/* What the files of the coupling share: coupling.c tells what it does. */
#ifndef FURROW_VEHICLE_COUPLING_H
#define FURROW_VEHICLE_COUPLING_H

#include "vehicle/internal.h"

#define LONE_MOST 6     /* freedoms of a lone body */
#define BRAKE_SOFT 1e6  /* a wheel that does not turn has so many times its own inertia where constraints act: with more, MuJoCo's solver of them does not converge */

/* One contact in an engine step. */
struct contact {
	struct soil_geom *geom;
	double stiffness[6][6], damping[6][6]; /* the parts that resist */
	double gain[6][6];      /* dF / du, with the damping of shear: of u[j] and F[i] at [j][i] */
	double force[6];        /* N, N m: F(v); once it is at its limit, that */
	double along[2][6];     /* two directions along the ground at the contact, as what gives the velocity there of u */
	double direction[2][3]; /* the same two, in local axes */
	double critical[2], pace[2]; /* N s/m: c; 1/s: how fast w follows */
	double arm[3];          /* m: from the origin to the contact */
	double forward[3];      /* the body's own x axis */
	double (*columns)[6];   /* chain_count: those of J; owned by the vehicle */
	bool is_load;           /* not a contact, but the soil aboard the geom */
	bool is_limited;        /* at its limit: `force` is all of it */
};

/* A step of the engine, for one vehicle. */
struct step {
	struct vehicle *vehicle;
	double h;               /* s */
	double later;           /* s: of the coupling step after this step of the engine */
	double cut;             /* N: no smaller force was cut */
	bool as_asked;          /* all geoms are where they were asked for */
};

static inline double dot6(const double a[6], const double b[6])
{
	double sum = 0;
	for (int i = 0; i < 6; i++)
		sum += a[i] * b[i];
	return sum;
}

/* u = J v */
static inline void vehicle_coupling_velocity(const struct contact *contact, const double *v, double u[6])
{
	const int count = contact->geom->chain_count, *chain = contact->geom->chain;
	double sum[6] = {0, 0, 0, 0, 0, 0};
	for (int c = 0; c < count; c++)
		for (int k = 0; k < 6; k++)
			sum[k] += contact->columns[c][k] * v[chain[c]];
	for (int k = 0; k < 6; k++)
		u[k] = sum[k];
}

/* Adds G u to a force. */
static inline void vehicle_coupling_answer(const struct contact *contact, const double u[6], double force[6])
{
	double sum[6] = {0, 0, 0, 0, 0, 0};
	for (int j = 0; j < 6; j++)
		for (int i = 0; i < 6; i++)
			sum[i] += contact->gain[j][i] * u[j];
	for (int i = 0; i < 6; i++)
		force[i] += sum[i];
}

/* --- coupling_chain.c --- */
/* Fills J of each contact. `wide`: room for 6 nv numbers. */
void vehicle_coupling_fill_jacobians(struct vehicle *vehicle, double *wide);
/* Adds J^T F to forces of the joints. */
void vehicle_coupling_add_force(const struct contact *contact, const double force[6], double *forces);

/* --- coupling_gain.c --- */
/* Adds -h J^T G J to an inertia as MuJoCo has it. Of a lone geom: a diagonal that is at least as stiff. */
void vehicle_coupling_add_gain(const struct contact *contact, double h, double *mass);
/* Holds braked wheels still: adds an inertia to their hinges that no torque of a vehicle can turn. */
void vehicle_coupling_brake(const struct vehicle *vehicle, double *mass);
/* vehicle_damping_of of each freedom of a vehicle. damping: nv. */
void vehicle_coupling_dampings(const struct vehicle *vehicle, double *damping);
double *vehicle_coupling_diagonal(const mjModel *model, double *mass, int dof); /* where M has a freedom's own number */
/* Finds the inverse masses along both directions at a contact: y^T M^-1 y with y = J^T along. M is factored, L^T D L. `work`: room for chain_count pairs. */
void vehicle_coupling_inverse_masses(const struct vehicle *vehicle, const struct contact *contact, double (*work)[2], double inverse[2]);
/*
 * Solves the equations of the lone body of a contact, from the change of the velocities that the stiffer diagonal has let. All its contacts get the
 * forces of that solution, at their limits. Returns false if there is no solution.
 */
bool vehicle_coupling_solve_lone(const struct vehicles *vehicles, struct vehicle *vehicle, const struct soil_geom *geom, double h, const double *change);

/* --- coupling_contact.c --- */
/* The body's own x axis, along which a belt runs. */
void vehicle_coupling_set_forward(struct contact *contact);
/* Finds forces and gains of all contacts of a vehicle. M + h D is factored. */
void vehicle_coupling_fill(const struct step *step);
/* The soil does not pull, and its shear has a limit. Returns true if the force is another one by that. */
bool vehicle_coupling_limit(const struct contact *contact, double force[6]);
/* w goes on: it follows the velocity at the contact at the step's end, `end`. */
void vehicle_coupling_follow(const struct contact *contact, double h, const double end[6]);
/* What of a belt's pull is not in the force along its body's x axis, as a torque on its hinge. */
double vehicle_coupling_turn_back(const struct contact *contact);

#endif
