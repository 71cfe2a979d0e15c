/* What the rig tells of a vehicle's wheels: drawbar, torque and sinkage over load and slip. */
#include <math.h>
#include <stdio.h>

#include "trials/trials.h"

#define POSTS 10 /* below a wheel's width or radius */

const double trials_slips[MOBILITY_SLIPS] = {-0.3, -0.1, 0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.45, 0.6, 0.75, 0.9};
/* Of the mean load. A slope takes from the wheels ahead what it gives to those behind, so that two of these are twice the mean together. */
static const double shares[MOBILITY_LOADS] = {0.2, 0.6, 1, 1.4, 1.8};

const char *trials_vehicle_problem(const struct trials_vehicle *vehicle)
{
	double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
	bool driven = false;
	if (vehicle->wheel_count < 3)
		return "has fewer than three wheels; only vehicles that stand on wheels can be judged";
	if (vehicle->wheel_count > TRIALS_WHEELS_MOST)
		return "has more than 32 wheels; give a model with fewer";
	for (size_t i = 0; i < vehicle->wheel_count; i++) {
		const struct trials_wheel *wheel = &vehicle->wheels[i];
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

double trials_vehicle_length(const struct trials_vehicle *vehicle)
{
	double low = INFINITY, high = -INFINITY, diameter = 0;
	for (size_t i = 0; i < vehicle->wheel_count; i++) {
		low = fmin(low, vehicle->wheels[i].x);
		high = fmax(high, vehicle->wheels[i].x);
		diameter = fmax(diameter, 2 * vehicle->wheels[i].radius);
	}
	return fmax(high - low, diameter);
}

size_t trials_wheel_pass(const struct trials_vehicle *vehicle, size_t wheel)
{
	const struct trials_wheel *own = &vehicle->wheels[wheel];
	size_t ahead = 0;
	for (size_t i = 0; i < vehicle->wheel_count; i++) {
		const struct trials_wheel *other = &vehicle->wheels[i];
		const double apart = fabs(other->y - own->y), both = (other->width + own->width) / 2;
		/* Wheels side by side are not ahead. */
		if (other->x > own->x + own->radius && both - apart > fmin(other->width, own->width) / 2)
			ahead++;
	}
	return ahead < RIG_PASSES_MOST ? ahead : RIG_PASSES_MOST - 1;
}

/* Finds the curves of a kind of wheel, or makes an empty one. */
static size_t kind_of(struct mobility_curves *curves, const struct trials_wheel *wheel, size_t pass)
{
	size_t kind = 0;
	while (kind < curves->kind_count && (curves->of[kind].radius != wheel->radius || curves->of[kind].width != wheel->width || curves->of[kind].pass != pass))
		kind++;
	if (kind == curves->kind_count)
		curves->of[curves->kind_count++] = (struct mobility_wheel_curves){.radius = wheel->radius, .width = wheel->width, .pass = pass};
	return kind;
}

/* Where the rows of one size of wheel go: by pass; NULL: that is not asked for. */
struct filling {
	struct mobility_wheel_curves *of[RIG_PASSES_MOST];
	size_t passes, next;
	double rut;             /* m: sinkage of the wheel before */
};

/* Rows come in the order of loads, slips, passes; passes fastest. Those ahead of the last have the load opposite. */
static enum status keep(void *user, const struct rig_row *row)
{
	struct filling *filling = user;
	const size_t slip = filling->next++ / filling->passes % MOBILITY_SLIPS;
	const size_t load = row->pass + 1 < filling->passes ? MOBILITY_LOADS - 1 - row->load : row->load;
	const double depth = row->sinkage - (row->pass > 0 ? filling->rut : 0);
	filling->rut = row->sinkage;
	if (filling->of[row->pass] != NULL)
		filling->of[row->pass]->points[load][slip] =
			(struct mobility_point){row->drawbar, row->torque, row->sinkage, depth, row->state == RIG_STEADY};
	return STATUS_OK;
}

/* Measures all kinds of one size: those whose radius and width are those of `first`. */
static enum status measure_size(const struct mobility_rig *rig, double mean, struct mobility_curves *curves, size_t first)
{
	char shape[128];
	double loads[MOBILITY_LOADS], leads[MOBILITY_LOADS];
	struct rig_found found;
	struct filling filling = {.passes = 1};
	const double radius = curves->of[first].radius, width = curves->of[first].width;
	for (size_t k = 0; k < MOBILITY_LOADS; k++) {
		loads[k] = shares[k] * mean;
		leads[k] = shares[MOBILITY_LOADS - 1 - k] * mean;
	}
	for (size_t i = first; i < curves->kind_count; i++) {
		struct mobility_wheel_curves *of = &curves->of[i];
		if (of->radius != radius || of->width != width)
			continue;
		filling.of[of->pass] = of;
		filling.passes = of->pass + 1 > filling.passes ? of->pass + 1 : filling.passes;
		for (size_t k = 0; k < MOBILITY_LOADS; k++)
			of->loads[k] = loads[k];
	}
	snprintf(shape, sizeof shape, "{wheel: {radius: %.17g, width: %.17g}}", radius, width);
	const struct rig_params params = {
		.shape = shape,
		.soils = &rig->soil,
		.soil_count = 1,
		.loads = loads,
		.load_count = MOBILITY_LOADS,
		.leads = leads,
		.slips = trials_slips,
		.slip_count = MOBILITY_SLIPS,
		.passes = filling.passes,
		.spacing = rig->spacing > 0 ? rig->spacing : fmin(radius, width) / POSTS,
		.folder = rig->folder,
		.stop = rig->stop,
		.progress = rig->progress,
		.user = rig->user,
	};
	return trials_rig_run(&params, &found, keep, &filling);
}

enum status trials_measure_wheels(const struct trials_vehicle *vehicle, const struct mobility_rig *rig, struct mobility_curves *curves)
{
	const char *problem = trials_vehicle_problem(vehicle);
	if (problem != NULL)
		return fail_with(STATUS_INPUT, "mobility: the vehicle %s", problem);
	*curves = (struct mobility_curves){.friction_angle = rig->friction_angle};
	const double mean = vehicle->mass * rig->gravity / (double)vehicle->wheel_count;
	for (size_t i = 0; i < vehicle->wheel_count; i++)
		curves->kinds[i] = kind_of(curves, &vehicle->wheels[i], trials_wheel_pass(vehicle, i));
	for (size_t i = 0; i < curves->kind_count; i++)
		if (curves->of[i].loads[0] == 0) /* not with one before */
			TRY(measure_size(rig, mean, curves, i));
	return STATUS_OK;
}
