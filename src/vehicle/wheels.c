/* Which geoms are wheels: cylinders, and meshes, that turn about a hinge near their axis. */
#include <math.h>

#include "vehicle/internal.h"

#define PARALLEL 1.4e-3 /* 1 - cosine of the greatest angle between a wheel's axis and its joint: 3 degrees */
#define MIDDLE 0.05   /* of the radius: how far the joint's axis may be from the wheel's middle */
#define BINS 72       /* directions around, in which a mesh must be equally wide to be a wheel, */
#define ROUND 0.97    /* of its radius at least */
#define TREAD 0.9     /* of its radius: what of a mesh reaches so far is the wheel's width */
#define VALLEY 0.8    /* of its radius: corners between this and ROUND in the middle of the tread lie between bars */
#define UPRIGHT 0.5   /* how much of a wheel's axle may look up: a mesh that turns about an upright axis is no wheel */

void vehicle_set_axes(struct soil_geom *out, const double forward[3], const double left[3], const double up[3])
{
	for (int i = 0; i < 3; i++) {
		out->axes[3 * i] = forward[i];
		out->axes[3 * i + 1] = left[i];
		out->axes[3 * i + 2] = up[i];
	}
}

/* Finds the freedom of a hinge that turns the geom's body about an axis near the geom's middle; -1: there is none. It may be a hinge of a body to
 * which that body is fixed.
 * `axis`: how it must look, in MuJoCo's axes; NULL: in any way. `far`: m, how far the hinge may be from the middle. */
static int turns(const struct vehicle *vehicle, int geom, const double *axis, double far)
{
	const mjModel *model = vehicle->model;
	const mjData *data = vehicle->data;
	int body = model->geom_bodyid[geom];
	while (body > 0 && model->body_jntnum[body] == 0)
		body = model->body_parentid[body];
	for (int j = model->body_jntadr[body]; j >= 0 && j < model->body_jntadr[body] + model->body_jntnum[body]; j++) {
		const double *along = &data->xaxis[3 * j];
		double from[3], beside[3];
		if (model->jnt_type[j] != mjJNT_HINGE || (axis != NULL && fabs(mju_dot3(along, axis)) < 1 - PARALLEL))
			continue;
		mju_sub3(from, &data->geom_xpos[3 * geom], &data->xanchor[3 * j]);
		mju_addScl3(beside, from, along, -mju_dot3(from, along));
		if (mju_norm3(beside) <= far)
			return model->jnt_dofadr[j];
	}
	return -1;
}

int vehicle_cylinder_turns(const struct vehicle *vehicle, int geom)
{
	const double *mat = &vehicle->data->geom_xmat[9 * geom];
	return turns(vehicle, geom, (const double[]){mat[2], mat[5], mat[8]}, MIDDLE * vehicle->model->geom_size[3 * geom]);
}

/* A mesh seen along an axle: `left` along it, `forward` and `up` across, in the geom's axes. */
struct turned {
	double forward[3], left[3], up[3];
	double radius, low, high; /* m: high - low is the width of its tread */
};

static void set_across(struct turned *turned)
{
	const double any[3] = {fabs(turned->left[0]) < 0.5, fabs(turned->left[0]) >= 0.5, 0};
	mju_cross(turned->up, turned->left, any);
	mju_normalize3(turned->up);
	mju_cross(turned->forward, turned->left, turned->up);
}

/* Finds radius and width. Returns false if it is not round, or has bars: those are kept as the mesh. */
static bool measure_round(const float *corners, int count, struct turned *turned)
{
	double reach[BINS] = {0};
	turned->radius = 0;
	turned->low = INFINITY;
	turned->high = -INFINITY;
	for (int turn = 0; turn < 3; turn++) /* the radius, the width, valleys between bars */
		for (int i = 0; i < count; i++) {
			const double at[3] = {(double)corners[3 * i], (double)corners[3 * i + 1], (double)corners[3 * i + 2]};
			const double x = mju_dot3(at, turned->forward), y = mju_dot3(at, turned->left), z = mju_dot3(at, turned->up), from = hypot(x, z);
			if (turn == 0) {
				for (int bin = 0; bin < BINS; bin++)
					reach[bin] = fmax(reach[bin], x * cos(2 * M_PI * bin / BINS) + z * sin(2 * M_PI * bin / BINS));
				turned->radius = fmax(turned->radius, from);
			} else if (turn == 1 && from >= TREAD * turned->radius) {
				turned->low = fmin(turned->low, y);
				turned->high = fmax(turned->high, y);
			} else if (turn == 2 && from >= VALLEY * turned->radius && from < ROUND * turned->radius &&
				   fabs(y - (turned->low + turned->high) / 2) < (turned->high - turned->low) / 4) {
				return false;
			}
		}
	for (int bin = 0; bin < BINS; bin++)
		if (reach[bin] < ROUND * turned->radius)
			return false;
	return turned->high > turned->low && fabs(turned->high + turned->low) / 2 <= MIDDLE * turned->radius;
}

bool vehicle_make_mesh_wheel(const struct vehicle *vehicle, struct soil_geom *out)
{
	const mjModel *model = vehicle->model;
	const double *mat = &vehicle->data->geom_xmat[9 * out->geom];
	const int mesh = model->geom_dataid[out->geom], dof = turns(vehicle, out->geom, NULL, INFINITY);
	struct turned turned;
	if (dof < 0 || fabs(vehicle->data->xaxis[3 * model->dof_jntid[dof] + 2]) > UPRIGHT)
		return false;
	mju_mulMatTVec3(turned.left, mat, &vehicle->data->xaxis[3 * model->dof_jntid[dof]]);
	if (mju_dot3(turned.left, mat + 3) < 0) /* to the vehicle's left */
		mju_scl3(turned.left, turned.left, -1);
	set_across(&turned);
	if (!measure_round(&model->mesh_vert[3 * model->mesh_vertadr[mesh]], model->mesh_vertnum[mesh], &turned) ||
	    turns(vehicle, out->geom, NULL, MIDDLE * turned.radius) != dof)
		return false;
	out->dof = dof;
	out->shape = (struct soil_shape){.kind = SOIL_WHEEL, .radius = turned.radius, .width = turned.high - turned.low};
	vehicle_set_axes(out, turned.forward, turned.left, turned.up);
	return true;
}
