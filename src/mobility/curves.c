/* What the rig tells of a vehicle's wheels: drawbar, torque and sinkage over load and slip. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "mobility/mobility.h"

const double mobility_slips[MOBILITY_SLIPS] = {-0.3, -0.15, -0.05, 0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};
static const double shares[MOBILITY_LOADS] = {0.25, 0.5, 0.75, 1, 1.4, 2}; /* of the mean load */

const char *mobility_vehicle_problem(const struct vehicle_outline *vehicle)
{
	double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
	bool driven = false;
	if (vehicle->wheel_count < 3)
		return "has fewer than three wheels; only vehicles that stand on wheels can be judged";
	if (vehicle->wheel_count > VEHICLE_WHEELS_MOST)
		return "has more than 32 wheels; give a model with fewer";
	for (size_t i = 0; i < vehicle->wheel_count; i++) {
		const struct vehicle_wheel *wheel = &vehicle->wheels[i];
		low[0] = fmin(low[0], wheel->x);
		high[0] = fmax(high[0], wheel->x);
		low[1] = fmin(low[1], wheel->y);
		high[1] = fmax(high[1], wheel->y);
		driven |= wheel->driven;
	}
	if (!driven)
		return "has no driven wheel; name its motors' joints as drive";
	if (!(low[0] < 0 && high[0] > 0 && low[1] < 0 && high[1] > 0))
		return "has its centre of gravity outside its wheels; check the model's masses";
	return vehicle->mass > 0 && vehicle->height > 0 ? NULL : "has no mass, or its centre of gravity is below the ground; check the model's masses";
}

double mobility_length(const struct vehicle_outline *vehicle)
{
	double low = INFINITY, high = -INFINITY, diameter = 0;
	for (size_t i = 0; i < vehicle->wheel_count; i++) {
		low = fmin(low, vehicle->wheels[i].x);
		high = fmax(high, vehicle->wheels[i].x);
		diameter = fmax(diameter, 2 * vehicle->wheels[i].radius);
	}
	return fmax(high - low, diameter);
}

struct filling {
	struct mobility_wheel_curves *curves;
	size_t next;
};

/* Rows come in the order of loads, slips fastest. */
static enum status keep(void *user, const struct rig_row *row)
{
	struct filling *filling = user;
	const size_t slip = filling->next++ % MOBILITY_SLIPS;
	filling->curves->points[row->load][slip] = (struct mobility_point){row->drawbar, row->torque, row->sinkage, row->state == RIG_STEADY};
	return STATUS_OK;
}

static enum status measure_kind(const struct mobility_rig *rig, struct mobility_wheel_curves *curves)
{
	char shape[128];
	struct rig_found found;
	struct filling filling = {curves, 0};
	snprintf(shape, sizeof shape, "{wheel: {radius: %.17g, width: %.17g}}", curves->radius, curves->width);
	const struct rig_params params = {
		.shape = shape,
		.soils = &rig->soil,
		.soil_count = 1,
		.loads = curves->loads,
		.load_count = MOBILITY_LOADS,
		.slips = mobility_slips,
		.slip_count = MOBILITY_SLIPS,
		.spacing = rig->spacing,
		.folder = rig->folder,
		.stop = rig->stop,
		.progress = rig->progress,
		.user = rig->user,
	};
	return rig_run(&params, &found, keep, &filling);
}

static enum status friction_of(const char *soil, double *degrees)
{
	const char *key;
	double value;
	struct scene *scene;
	enum status status = rig_soil_scene(soil, &scene);
	if (status != STATUS_OK)
		return status;
	*degrees = NAN;
	for (size_t i = 0; scene_soil_number(&scene->soils[0], i, &key, &value); i++)
		if (strcmp(key, "friction_angle") == 0)
			*degrees = value;
	scene_destroy(scene);
	return STATUS_OK;
}

enum status mobility_measure(const struct vehicle_outline *vehicle, const struct mobility_rig *rig, struct mobility_curves *curves)
{
	const char *problem = mobility_vehicle_problem(vehicle);
	if (problem != NULL)
		return fail_with(STATUS_INPUT, "mobility: the vehicle %s", problem);
	*curves = (struct mobility_curves){.kind_count = 0};
	const double mean = vehicle->mass * rig->gravity / (double)vehicle->wheel_count;
	enum status status = friction_of(rig->soil, &curves->friction_angle);
	for (size_t i = 0; i < vehicle->wheel_count && status == STATUS_OK; i++) {
		const struct vehicle_wheel *wheel = &vehicle->wheels[i];
		size_t kind = 0;
		while (kind < curves->kind_count && (curves->of[kind].radius != wheel->radius || curves->of[kind].width != wheel->width))
			kind++;
		curves->kinds[i] = kind;
		if (kind < curves->kind_count)
			continue;
		struct mobility_wheel_curves *made = &curves->of[curves->kind_count++];
		made->radius = wheel->radius;
		made->width = wheel->width;
		for (size_t k = 0; k < MOBILITY_LOADS; k++)
			made->loads[k] = shares[k] * mean;
		status = measure_kind(rig, made);
	}
	return status;
}
