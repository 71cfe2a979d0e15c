/* How the soil's forces answer a change of the velocities, in MuJoCo's inertia: coupling.c. And the inertia that a contact feels. */
#include <math.h>

#include "vehicle/coupling.h"
#include "vehicle/linear.h"

#define BRAKE 1e12      /* kg m2: inertia of a wheel that does not turn, */

static void lone_gain(const struct contact *contact, double h, double *matrix)
{
	const int n = contact->geom->chain_count;
	for (int a = 0; a < n; a++)
		for (int b = 0; b < n; b++) {
			double sum = 0;
			for (int i = 0; i < 6; i++)
				for (int j = 0; j < 6; j++)
					sum -= h * contact->columns[a][i] * contact->gain[j][i] * contact->columns[b][j];
			matrix[a * n + b] = sum;
		}
}

/* Adds a diagonal that is at least as stiff. */
static void add_lone_gain(const struct contact *contact, double h, double *mass)
{
	const int n = contact->geom->chain_count;
	double matrix[LONE_MOST * LONE_MOST];
	lone_gain(contact, h, matrix);
	for (int a = 0; a < n; a++) {
		double sum = 0;
		for (int b = 0; b < n; b++) {
			const double product = matrix[a * n + a] * matrix[b * n + b];
			sum += product > 0 ? fabs(matrix[a * n + b]) * matrix[a * n + a] / sqrt(product) : 0;
		}
		mass[contact->geom->places[a * (a + 1) / 2 + a]] += sum;
	}
}

void vehicle_coupling_add_gain(const struct contact *contact, double h, double *mass)
{
	const struct soil_geom *geom = contact->geom;
	const int count = geom->chain_count;
	const double factor = geom->apart ? -2 * h : -h;
	const int *place = geom->places;
	if (geom->lone) {
		add_lone_gain(contact, h, mass);
		return;
	}
	for (int a = 0; a < count; a++) {
		double gained[6] = {0, 0, 0, 0, 0, 0};
		vehicle_coupling_answer(contact, contact->columns[a], gained);
		for (int b = 0; b <= a; b++, place++)
			if (*place >= 0)
				mass[*place] += factor * dot6(contact->columns[b], gained);
	}
}

/* The freedom that a motor damps, where the engine's steps take that at their end; -1: none. */
static int damped_by(const mjModel *model, int actuator)
{
	const bool motors = model->opt.integrator == mjINT_IMPLICIT || model->opt.integrator == mjINT_IMPLICITFAST;
	const bool damps = motors && model->actuator_trntype[actuator] == mjTRN_JOINT && model->actuator_biastype[actuator] == mjBIAS_AFFINE;
	return damps ? model->jnt_dofadr[model->actuator_trnid[2 * actuator]] : -1;
}

static double damping_by(const mjModel *model, int actuator)
{
	const double *gear = vehicle_gear(model, actuator);
	return -model->actuator_biasprm[actuator * mjNBIAS + 2] * gear[0] * gear[0];
}

void vehicle_coupling_dampings(const struct vehicle *vehicle, double *damping)
{
	const mjModel *model = vehicle->model;
	const struct range dofs = vehicle->own.dof;
	for (int i = dofs.first; i < dofs.end; i++)
		damping[i] = model->dof_damping[i];
	for (int i = vehicle->own.actuator.first; i < vehicle->own.actuator.end; i++) {
		const int dof = damped_by(model, i);
		if (dof >= dofs.first && dof < dofs.end)
			damping[dof] += damping_by(model, i);
	}
	for (int i = dofs.first; i < dofs.end; i++)
		damping[i] = damping[i] > 0 ? damping[i] : 0;
}

double vehicle_damping_of(const struct vehicle *vehicle, int dof)
{
	double damping = vehicle->model->dof_damping[dof];
	for (int i = vehicle->own.actuator.first; i < vehicle->own.actuator.end; i++)
		if (damped_by(vehicle->model, i) == dof)
			damping += damping_by(vehicle->model, i);
	return damping > 0 ? damping : 0;
}

double *vehicle_coupling_diagonal(const mjModel *model, double *mass, int dof)
{
	return mass + model->M_rowadr[dof] + model->M_rownnz[dof] - 1;
}

void vehicle_coupling_inverse_masses(const struct vehicle *vehicle, const struct contact *contact, double (*work)[2], double inverse[2])
{
	const mjData *data = vehicle->data;
	const struct soil_geom *geom = contact->geom;
	const int count = geom->chain_count;
	double sum[2] = {0, 0};
	for (int c = 0; c < count; c++)
		for (int d = 0; d < 2; d++)
			work[c][d] = dot6(contact->columns[c], contact->along[d]);
	for (int c = count - 1; c >= 0; c--) {
		const int *places = geom->places + c * (c + 1) / 2;
		for (int b = 0; b < c; b++)
			for (int d = 0; d < 2 && places[b] >= 0; d++)
				work[b][d] -= data->qLD[places[b]] * work[c][d];
		for (int d = 0; d < 2; d++)
			sum[d] += work[c][d] * work[c][d] * data->qLDiagInv[geom->chain[c]];
	}
	inverse[0] = sum[0];
	inverse[1] = sum[1];
}

/* Returns true if the vehicle has equalities, limits, friction of joints, or tendons, or touches another one. */
static bool is_constrained(const struct vehicle *vehicle)
{
	const mjModel *model = vehicle->model;
	const mjData *data = vehicle->data;
	bool any = range_count(vehicle->own.equality) > 0 || range_count(vehicle->own.tendon) > 0;
	for (int i = vehicle->own.joint.first; i < vehicle->own.joint.end && !any; i++)
		any = model->jnt_limited[i];
	for (int i = vehicle->own.dof.first; i < vehicle->own.dof.end && !any; i++)
		any = model->dof_frictionloss[i] > 0 || (data->nefc > 0 && (data->nisland == 0 || data->dof_island[i] >= 0));
	return any;
}

void vehicle_coupling_brake(const struct vehicle *vehicle, double *mass)
{
	const bool constrained = is_constrained(vehicle);
	for (size_t g = 0; g < vehicle->geom_count; g++) {
		const struct soil_geom *geom = &vehicle->geoms[g];
		const int dof = vehicle_turning_dof(geom);
		bool again = dof < 0; /* several geoms may share a hinge */
		for (size_t before = 0; before < g && !again; before++)
			again = vehicle_turning_dof(&vehicle->geoms[before]) == dof;
		if (!again)
			*vehicle_coupling_diagonal(vehicle->model, mass, dof) += constrained ? BRAKE_SOFT * vehicle->model->dof_M0[dof] : BRAKE;
	}
}

bool vehicle_coupling_solve_lone(const struct vehicles *vehicles, struct vehicle *vehicle, const struct soil_geom *geom, double h, const double *change)
{
	const mjModel *model = vehicles->model;
	const int n = geom->chain_count;
	double matrix[LONE_MOST * LONE_MOST] = {0}, rate[LONE_MOST], part[LONE_MOST * LONE_MOST];
	for (int a = 0; a < n; a++) {
		const int dof = geom->chain[a];
		const double damped = h * vehicle_damping_of(vehicle, dof);
		matrix[a * n + a] = *vehicle_coupling_diagonal(model, vehicles->mass, dof) + damped;
		rate[a] = (*vehicle_coupling_diagonal(model, vehicles->data->M, dof) + damped) * change[dof] / h; /* q, with the forces of the contacts */
	}
	for (size_t i = 0; i < vehicle->contact_count; i++) {
		const struct contact *contact = &vehicle->contacts[i];
		if (contact->geom->chain[0] != geom->chain[0] || contact->is_limited)
			continue;
		lone_gain(contact, h, part);
		mju_addTo(matrix, part, n * n);
	}
	if (!vehicle_solve(matrix, rate, (size_t)n))
		return false;
	for (size_t i = 0; i < vehicle->contact_count; i++) {
		struct contact *contact = &vehicle->contacts[i];
		double u[6];
		if (contact->geom->chain[0] != geom->chain[0] || contact->is_limited)
			continue;
		for (int k = 0; k < 6; k++) {
			u[k] = 0;
			for (int c = 0; c < n; c++)
				u[k] += contact->columns[c][k] * h * rate[c];
		}
		vehicle_coupling_answer(contact, u, contact->force);
		contact->is_limited = true;
		if (!contact->is_load)
			vehicle_coupling_limit(contact, contact->force);
	}
	return true;
}
