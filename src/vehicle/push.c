/*
 * Forces between vehicles that touch each other.
 *
 * The law of one contact is MuJoCo's ("Computation", soft constraints). r is the gap, and v the rate at which it changes. solref and solimp
 * give the stiffness k, the damping b and the impedance d. The contact wants the acceleration -b v - k r, and is as soft as d says. It
 * never pulls. The shortest time constant is two time steps. Friction is stricter than MuJoCo's: it holds without creep as long as the
 * cone of friction lets it, and opposes the slip beyond.
 *
 * All contacts are solved together for the velocities at the end of the time step H, as an implicit step does:
 *
 *     u = u' + H A f,    u: velocities at the contacts,    u': without forces between vehicles,    A = J I^-1 J^T of both vehicles
 *
 * The inertia I has what joints and soil resist within the step (coupling.c). So a vehicle at rest is as hard to push as
 * the soil holds it. Gauss and Seidel's way: each contact in turn takes what it lacks, until nothing changes. The force on one vehicle
 * is that on the other, with the other sign, at one place. So no momentum comes or goes.
 */
#include <math.h>

#include "vehicle/between.h"
#include "vehicle/linear.h"

#define ROUNDS_MOST 1000
#define SETTLED 1e-8   /* of the greatest change of velocity: less than this is no change */
#define STEPS_LEAST 2.0 /* time steps: the shortest time constant of a contact */

/* --- the law --- */

/* Impedance at a depth, from solimp: MuJoCo's curve. */
static double impedance_at(const double impedance[5], double gap)
{
	const double from = fmin(fmax(impedance[0], mjMINIMP), mjMAXIMP), to = fmin(fmax(impedance[1], mjMINIMP), mjMAXIMP);
	const double middle = fmin(fmax(impedance[3], mjMINIMP), mjMAXIMP), power = fmax(impedance[4], 1);
	if (impedance[2] <= mjMINVAL)
		return (from + to) / 2;
	const double x = fmin(fabs(gap) / impedance[2], 1);
	const double y = x <= middle ? pow(x, power) / pow(middle, power - 1) : 1 - pow(1 - x, power) / pow(1 - middle, power - 1);
	return from + fmin(fmax(y, 0), 1) * (to - from);
}

/* Finds the velocity that a contact wants along its normal, and how soft it is. */
static void set_law(struct meeting *meeting, double rate, double seconds)
{
	const double *reference = meeting->reference, least = STEPS_LEAST * seconds;
	const double full = fmin(fmax(meeting->impedance[1], mjMINIMP), mjMAXIMP), d = impedance_at(meeting->impedance, meeting->gap);
	double stiffness, damping;
	if (reference[0] > 0) {
		const double constant = fmax(reference[0], least), ratio = fmax(reference[1], mjMINVAL);
		stiffness = 1 / (full * full * constant * constant * ratio * ratio);
		damping = 2 / (full * constant);
	} else {
		stiffness = -reference[0] / (full * full);
		damping = -reference[1] / full;
	}
	stiffness = fmin(fmax(stiffness, 0), 1 / (full * full * least * least));
	damping = fmin(fmax(damping, 0), 2 / (full * least));
	meeting->target = rate - seconds * (damping * rate + stiffness * d * meeting->gap);
	meeting->soft = (1 - d) / d * meeting->inverse;
}

/* --- what a meeting needs of both vehicles --- */

/* Velocity along an axis, of the second vehicle against the first. */
static double rate_of(const struct meeting *meeting, const double *const velocity[2], const int nv[2], int axis)
{
	return mju_dot(meeting->rows[1] + axis * nv[1], velocity[1], nv[1]) - mju_dot(meeting->rows[0] + axis * nv[0], velocity[0], nv[0]);
}

/* Entry of A for two axes of one meeting. */
static double entry(const struct meeting *meeting, const int nv[2], int i, int j)
{
	double sum = 0;
	for (int k = 0; k < 2; k++)
		sum += mju_dot(meeting->rows[k] + i * nv[k], meeting->solved[k] + j * nv[k], nv[k]);
	return sum;
}

static void fill_meeting(const struct vehicles *vehicles, struct meeting *meeting, double seconds)
{
	const double *velocity[2];
	double *jacobian = vehicles->between->rows; /* room for 3 x nv in front of the meetings' rows */
	int nv[2];
	for (int k = 0; k < 2; k++) {
		const struct vehicle *vehicle = &vehicles->list[meeting->vehicle[k]];
		nv[k] = vehicle->model->nv;
		velocity[k] = vehicle->data->qvel;
		mj_jac(vehicle->model, vehicle->data, jacobian, NULL, meeting->point[k], vehicle->model->geom_bodyid[meeting->geom[k]]);
		mju_mulMatMat(meeting->rows[k], &meeting->axes[0][0], jacobian, 3, 3, nv[k]);
		mju_copy(meeting->solved[k], meeting->rows[k], 3 * nv[k]);
		for (int axis = 0; axis < 3; axis++)
			vehicle_solve_factored(vehicles->between->movers[meeting->vehicle[k]].inertia, meeting->solved[k] + axis * nv[k], (size_t)nv[k]);
	}
	meeting->inverse = entry(meeting, nv, 0, 0);
	const double one = entry(meeting, nv, 1, 1), two = entry(meeting, nv, 2, 2), both = entry(meeting, nv, 1, 2);
	meeting->along = (one + two) / 2 + hypot((one - two) / 2, both);
	set_law(meeting, rate_of(meeting, velocity, nv, 0), seconds);
}

/* Hands out room for the rows of all meetings. */
static enum status lay_out(const struct vehicles *vehicles)
{
	struct between *between = vehicles->between;
	size_t widest = 0, need = 0;
	for (size_t v = 0; v < vehicles->count; v++)
		widest = widest > (size_t)vehicles->list[v].model->nv ? widest : (size_t)vehicles->list[v].model->nv;
	for (size_t i = 0; i < between->count; i++)
		for (int k = 0; k < 2; k++)
			need += 6 * (size_t)vehicles->list[between->meetings[i].vehicle[k]].model->nv;
	need += 3 * widest;
	TRY(mem_grow(&between->rows, &between->row_room, need, sizeof *between->rows, "contacts of vehicles"));
	double *next = between->rows + 3 * widest;
	for (size_t i = 0; i < between->count; i++)
		for (int k = 0; k < 2; k++) {
			const size_t rows = 3 * (size_t)vehicles->list[between->meetings[i].vehicle[k]].model->nv;
			between->meetings[i].rows[k] = next;
			between->meetings[i].solved[k] = next + rows;
			next += 2 * rows;
		}
	return STATUS_OK;
}

/* --- all meetings together --- */

/* Adds a change of a force along an axis to the velocities at the step's end. */
static void change(const struct meeting *meeting, double *const velocity[2], const int nv[2], int axis, double impulse)
{
	mju_addToScl(velocity[1], meeting->solved[1] + axis * nv[1], impulse, nv[1]);
	mju_addToScl(velocity[0], meeting->solved[0] + axis * nv[0], -impulse, nv[0]);
}

/* Gives one meeting the force that it lacks. Returns the change of velocity at it, m/s. */
static double correct(const struct vehicles *vehicles, struct meeting *meeting, double seconds)
{
	double *velocity[2], moved = 0;
	int nv[2];
	for (int k = 0; k < 2; k++) {
		nv[k] = vehicles->list[meeting->vehicle[k]].model->nv;
		velocity[k] = vehicles->between->movers[meeting->vehicle[k]].velocity;
	}
	const double *const now[2] = {velocity[0], velocity[1]};
	if (!(meeting->inverse > 0)) /* neither vehicle can move along the normal */
		return 0;
	const double *force = meeting->force;
	const double lacks = meeting->target - rate_of(meeting, now, nv, 0) - seconds * meeting->soft * force[0];
	const double normal = fmax(force[0] + lacks / (seconds * (meeting->inverse + meeting->soft)), 0);
	change(meeting, velocity, nv, 0, seconds * (normal - force[0]));
	moved = fabs(normal - force[0]) * seconds * meeting->inverse;
	meeting->force[0] = normal;
	if (!(meeting->friction > 0 && meeting->along > 0))
		return moved;
	double shear[2];
	for (int k = 0; k < 2; k++)
		shear[k] = force[1 + k] - rate_of(meeting, now, nv, 1 + k) / (seconds * meeting->along);
	const double is = hypot(shear[0], shear[1]), most = meeting->friction * normal;
	for (int k = 0; k < 2; k++) {
		const double to = is > most ? shear[k] * most / is : shear[k];
		change(meeting, velocity, nv, 1 + k, seconds * (to - force[1 + k]));
		moved = fmax(moved, fabs(to - force[1 + k]) * seconds * meeting->along);
		meeting->force[1 + k] = to;
	}
	return moved;
}

static void solve(const struct vehicles *vehicles, double seconds)
{
	struct between *between = vehicles->between;
	double greatest = 0;
	for (int round = 0; round < ROUNDS_MOST; round++) {
		double moved = 0;
		for (size_t i = 0; i < between->count; i++)
			moved = fmax(moved, correct(vehicles, &between->meetings[i], seconds));
		greatest = fmax(greatest, moved);
		if (moved <= SETTLED * greatest)
			return;
	}
}

static void apply(const struct vehicles *vehicles, const struct meeting *meeting)
{
	for (int k = 0; k < 2; k++) {
		const struct vehicle *vehicle = &vehicles->list[meeting->vehicle[k]];
		const int nv = vehicle->model->nv;
		for (int axis = 0; axis < 3; axis++)
			mju_addToScl(vehicle->pushed, meeting->rows[k] + axis * nv, (k == 0 ? -1 : 1) * meeting->force[axis], nv);
	}
}

struct pushing {
	struct vehicles *vehicles;
	double seconds;
};

static void push(void *argument)
{
	const struct pushing *pushing = argument;
	struct vehicles *vehicles = pushing->vehicles;
	struct between *between = vehicles->between;
	for (size_t v = 0; v < vehicles->count; v++) {
		struct mover *mover = &between->movers[v];
		if (mover->meets)
			mover->whole = vehicle_find_response(&vehicles->list[v], pushing->seconds, 0, mover->inertia, mover->velocity);
	}
	for (size_t i = 0; i < between->count; i++)
		fill_meeting(vehicles, &between->meetings[i], pushing->seconds);
	solve(vehicles, pushing->seconds);
	for (size_t i = 0; i < between->count; i++)
		apply(vehicles, &between->meetings[i]);
}

/* A vehicle whose inertia has no inverse is told as a motion that diverges. */
static void spoil(const struct vehicles *vehicles)
{
	for (size_t v = 0; v < vehicles->count; v++)
		for (int i = 0; i < vehicles->list[v].model->nv && vehicles->between->movers[v].meets && !vehicles->between->movers[v].whole; i++)
			vehicles->list[v].pushed[i] = NAN;
}

enum status vehicle_between_push(struct vehicles *vehicles)
{
	struct between *between = vehicles->between;
	struct pushing pushing = {vehicles, vehicles->scene->time_step};
	if (between == NULL)
		return STATUS_OK;
	TRY(vehicle_between_find(vehicles));
	for (size_t v = 0; v < vehicles->count; v++)
		between->movers[v].meets = false;
	for (size_t i = 0; i < between->count; i++)
		for (int k = 0; k < 2; k++)
			between->movers[between->meetings[i].vehicle[k]].meets = true;
	if (between->count > 0) {
		TRY(lay_out(vehicles));
		TRY(vehicle_guard("vehicles", push, &pushing));
	}
	spoil(vehicles);
	return STATUS_OK;
}
