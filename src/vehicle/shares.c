/*
 * What share of the weight each soil geom bears on level ground.
 *
 * It is linear statics about the model's first pose. Joint springs and position actuators at control 0 are springs. So is the soil below four
 * places of each geom: together the geom's load over its estimated sinkage. Equality constraints are stiff springs. Wheels roll freely, so
 * the ground pushes upward only. dq is the small motion of the joints, f gravity and what springs and actuators do in the first pose. With J, k and gap of each
 * place that touches:
 *
 *     (K + sum k J J^T) dq = f - sum k gap J,    load = -k (gap + J dq)
 *
 * A place whose load would be below 0 does not touch. Limits of joints do not count.
 */
#include <math.h>

#include "vehicle/internal.h"
#include "vehicle/linear.h"

#define PLACES 4           /* of each geom: its lowest places in four directions that lean a little from straight down, so the corners of a flat lower side */
#define ASIDE 1e-3         /* how far these directions lean: their slope against straight down */
#define RIGID 1e4          /* stiffness of an equality constraint over that of the soil below all geoms */
#define SINKAGE_LEAST 1e-4 /* m. Hard ground has less; the springs would be too stiff for the solution */
#define FREE 1e-3          /* 1/s2, times the inertia: holds what nothing else does, such as a wheel that rolls */
#define MOVES_MOST 0.5     /* m, rad: beyond this the pose is another one */
#define MISSED_MOST 0.01   /* of the weight */

/* The soil below a place of a geom. */
struct spring {
	const double *up; /* nv: how fast it rises, for each joint's velocity */
	double stiffness, gap, load;
	bool touches;
};

struct statics {
	const struct vehicle *vehicle;
	mjData *data;           /* of its own, at rest in the first pose */
	struct spring *springs; /* PLACES for each soil geom */
	size_t count;
	double *jacobians;      /* count x 3 x nv */
	double *matrix, *fixed; /* nv x nv: of one solution; K and what holds the rest */
	double *motion;         /* nv: dq */
};

/* Returns false if there is no memory for it. */
static bool begin(struct statics *statics, const struct vehicle *vehicle)
{
	const mjModel *model = vehicle->model;
	const size_t nv = (size_t)model->nv, count = PLACES * vehicle->geom_count;
	*statics = (struct statics){.vehicle = vehicle, .data = mj_makeData(model), .count = count};
	statics->springs = mem_calloc(count, sizeof *statics->springs);
	statics->jacobians = mem_calloc(3 * count * nv, sizeof *statics->jacobians);
	statics->matrix = mem_calloc(nv * nv, sizeof *statics->matrix);
	statics->fixed = mem_calloc(nv * nv, sizeof *statics->fixed);
	statics->motion = mem_calloc(nv, sizeof *statics->motion);
	return statics->data != NULL && statics->springs != NULL && statics->jacobians != NULL && statics->matrix != NULL && statics->fixed != NULL &&
	       statics->motion != NULL;
}

static void finish(struct statics *statics)
{
	if (statics->data != NULL)
		mj_deleteData(statics->data);
	mem_free_all(statics->springs, statics->jacobians, statics->matrix, statics->fixed, statics->motion);
}

static void add_outer(double *matrix, const double *row, double factor, int nv)
{
	for (int i = 0; i < nv; i++)
		mju_addToScl(matrix + i * nv, row, factor * row[i], nv);
}

/* `soil`: stiffness of the soil below all geoms. */
static void find_fixed(struct statics *statics, double soil)
{
	const mjModel *model = statics->vehicle->model;
	const mjData *data = statics->data;
	const int nv = model->nv;
	mj_fullM(model, data, statics->fixed);
	mju_scl(statics->fixed, statics->fixed, FREE, nv * nv);
	for (int j = 0; j < model->njnt; j++)
		if (model->jnt_type[j] == mjJNT_HINGE || model->jnt_type[j] == mjJNT_SLIDE)
			statics->fixed[model->jnt_dofadr[j] * (nv + 1)] += model->jnt_stiffness[j];
	for (int a = 0; a < model->nactuator; a++)
		if (model->actuator_biastype[a] == mjBIAS_AFFINE) {
			mju_zero(statics->motion, nv);
			const int output = model->actuator_outadr[a], from = data->moment_rowadr[output];
			for (int i = from; i < from + data->moment_rownnz[output]; i++)
				statics->motion[data->moment_colind[i]] = data->actuator_moment[i];
			add_outer(statics->fixed, statics->motion, fmax(-model->actuator_biasprm[mjNBIAS * a + 1], 0), nv);
		}
	for (int i = 0; i < data->ne; i++)
		add_outer(statics->fixed, data->efc_J + i * nv, RIGID * soil, nv);
}

/* Returns the stiffness of all springs together. `load`: N, of each geom. */
static double find_springs(struct statics *statics, const struct soil_numbers *soil, double load)
{
	const mjModel *model = statics->vehicle->model;
	double lowest = INFINITY, stiffness = 0;
	for (size_t i = 0; i < statics->count; i++) {
		const struct soil_geom *geom = &statics->vehicle->geoms[i / PLACES];
		const double direction[3] = {i & 1 ? ASIDE : -ASIDE, i & 2 ? ASIDE : -ASIDE, -1};
		double *rows = statics->jacobians + 3 * i * (size_t)model->nv, place[3];
		vehicle_geom_support(model, statics->data, geom->geom, direction, place);
		mj_jac(model, statics->data, rows, NULL, place, model->geom_bodyid[geom->geom]);
		statics->springs[i] = (struct spring){.up = rows + 2 * model->nv, .gap = place[2], .touches = true};
		statics->springs[i].stiffness = load / PLACES / fmax(soil_sinkage_guess(&geom->shape, soil, load), SINKAGE_LEAST);
		stiffness += statics->springs[i].stiffness;
		lowest = fmin(lowest, place[2]);
	}
	for (size_t i = 0; i < statics->count; i++)
		statics->springs[i].gap -= lowest;
	return stiffness;
}

/* Solves for the places that touch, and finds anew which do. *same: they are those of before. Returns false if there is no solution. */
static bool solve(struct statics *statics, bool *same)
{
	const mjData *data = statics->data;
	const int nv = statics->vehicle->model->nv;
	mju_copy(statics->matrix, statics->fixed, nv * nv);
	for (int i = 0; i < nv; i++)
		statics->motion[i] = data->qfrc_passive[i] + data->qfrc_actuator[i] - data->qfrc_bias[i];
	for (size_t i = 0; i < statics->count; i++) {
		const struct spring *spring = &statics->springs[i];
		if (!spring->touches)
			continue;
		add_outer(statics->matrix, spring->up, spring->stiffness, nv);
		mju_addToScl(statics->motion, spring->up, -spring->stiffness * spring->gap, nv);
	}
	*same = true;
	if (!vehicle_solve(statics->matrix, statics->motion, (size_t)nv))
		return false;
	for (size_t i = 0; i < statics->count; i++) {
		struct spring *spring = &statics->springs[i];
		const double load = -spring->stiffness * (spring->gap + mju_dot(spring->up, statics->motion, nv));
		*same = *same && (load > 0) == spring->touches;
		spring->touches = load > 0;
		spring->load = fmax(load, 0);
	}
	return true;
}

/* Returns true if the loads are those of this pose, and bear the weight. */
static bool bears(const struct statics *statics, double weight)
{
	double sum = 0;
	for (size_t i = 0; i < statics->count; i++)
		sum += statics->springs[i].load;
	for (int i = 0; i < statics->vehicle->model->nv; i++)
		if (!(fabs(statics->motion[i]) < MOVES_MOST))
			return false;
	return fabs(sum - weight) < MISSED_MOST * weight;
}

static enum status find(struct vehicle *vehicle, const struct scene *scene)
{
	const double weight = mj_getTotalmass(vehicle->model) * scene->gravity;
	struct statics statics;
	if (!begin(&statics, vehicle)) {
		finish(&statics);
		return fail_memory("a vehicle");
	}
	bool found = !(vehicle->model->neq > 0 && mj_isSparse(vehicle->model)) && weight > 0, same = false;
	if (found) {
		mj_forward(vehicle->model, statics.data);
		find_fixed(&statics, find_springs(&statics, &scene->soils[0], weight / (double)vehicle->standing_count));
	}
	for (size_t turn = 0; found && !same && turn <= 2 * statics.count; turn++)
		found = solve(&statics, &same);
	found = found && same && bears(&statics, weight);
	for (size_t g = 0; g < vehicle->geom_count; g++)
		vehicle->geoms[g].share = found ? 0 : NAN;
	for (size_t i = 0; i < statics.count && found; i++)
		vehicle->geoms[i / PLACES].share += statics.springs[i].load / weight;
	finish(&statics);
	return STATUS_OK;
}

enum status vehicle_find_shares(struct vehicles *vehicles)
{
	for (size_t i = 0; vehicles != NULL && i < vehicles->count; i++)
		TRY(find(&vehicles->list[i], vehicles->scene));
	return STATUS_OK;
}
