/* A vehicle on a slope: its wheels' loads, and the least slip at which they pull as much as gravity does. */
#include <math.h>

#include "mobility/mobility.h"

#define RADIANS (3.14159265358979323846 / 180)

const char *const mobility_reason_names[MOBILITY_REASONS] = {
	[MOBILITY_GO] = "go", [MOBILITY_NO_PULL] = "too little pull", [MOBILITY_NO_TORQUE] = "too little torque", [MOBILITY_TIPS] = "tips over",
	[MOBILITY_NO_CLEARANCE] = "sinks to its belly", [MOBILITY_DIGS] = "digs itself in", [MOBILITY_OFF_CURVES] = "load beyond the curves",
	[MOBILITY_TOO_STEEP] = "steeper than the friction angle", [MOBILITY_TOO_COARSE] = "terrain too coarse", [MOBILITY_NO_GROUND] = "no ground",
};

bool mobility_is_unknown(enum mobility_reason reason)
{
	return reason == MOBILITY_OFF_CURVES || reason == MOBILITY_TOO_STEEP || reason == MOBILITY_TOO_COARSE || reason == MOBILITY_NO_GROUND;
}

/*
 * Finds the wheels' loads N of a rigid body on equal springs:
 *
 *     N_i = a + b x_i + c y_i,  sum N_i = W cos(slope),  sum N_i x_i = -h W_x,  sum N_i y_i = -h W_y
 *
 * W_x, W_y: the parts of the weight down the slope, against x and y. Returns false if the wheels lie in one line.
 */
static bool loads_of(const struct vehicle_outline *vehicle, double normal, const double along[2], double *loads)
{
	double s = (double)vehicle->wheel_count, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
	for (size_t i = 0; i < vehicle->wheel_count; i++) {
		const struct vehicle_wheel *w = &vehicle->wheels[i];
		x += w->x;
		y += w->y;
		xx += w->x * w->x;
		xy += w->x * w->y;
		yy += w->y * w->y;
	}
	/* Cramer's rule */
	const double right[3] = {normal, -vehicle->height * along[0], -vehicle->height * along[1]};
	const double m[3][3] = {{s, x, y}, {x, xx, xy}, {y, xy, yy}};
	const double d = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
			 m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
	if (!(fabs(d) > 1e-12 * s * (xx + yy) * (xx + yy)))
		return false;
	double solved[3];
	for (int k = 0; k < 3; k++) {
		double n[3][3];
		for (int i = 0; i < 3; i++)
			for (int j = 0; j < 3; j++)
				n[i][j] = j == k ? right[i] : m[i][j];
		solved[k] = (n[0][0] * (n[1][1] * n[2][2] - n[1][2] * n[2][1]) - n[0][1] * (n[1][0] * n[2][2] - n[1][2] * n[2][0]) +
			     n[0][2] * (n[1][0] * n[2][1] - n[1][1] * n[2][0])) / d;
	}
	for (size_t i = 0; i < vehicle->wheel_count; i++)
		loads[i] = solved[0] + solved[1] * vehicle->wheels[i].x + solved[2] * vehicle->wheels[i].y;
	return true;
}

static struct mobility_point between(struct mobility_point a, struct mobility_point b, double share)
{
	return (struct mobility_point){a.drawbar + (b.drawbar - a.drawbar) * share, a.torque + (b.torque - a.torque) * share,
				       a.sinkage + (b.sinkage - a.sinkage) * share, (share >= 1 || a.steady) && (share <= 0 || b.steady)};
}

/* Reads a wheel's curves at a load and a slip, straight between their points. */
static struct mobility_point point_at(const struct mobility_wheel_curves *curves, double load, double slip)
{
	size_t l = 0, s = 0;
	while (l + 2 < MOBILITY_LOADS && load > curves->loads[l + 1])
		l++;
	while (s + 2 < MOBILITY_SLIPS && slip > mobility_slips[s + 1])
		s++;
	const double by_load = (load - curves->loads[l]) / (curves->loads[l + 1] - curves->loads[l]);
	const double by_slip = (slip - mobility_slips[s]) / (mobility_slips[s + 1] - mobility_slips[s]);
	return between(between(curves->points[l][s], curves->points[l][s + 1], by_slip),
		       between(curves->points[l + 1][s], curves->points[l + 1][s + 1], by_slip), by_load);
}

/* The slip of a wheel that turns freely: its torque is 0. */
static double free_slip(const struct mobility_wheel_curves *curves, double load)
{
	double low = mobility_slips[0], high = mobility_slips[MOBILITY_SLIPS - 1];
	for (int i = 0; i < 40; i++) {
		const double middle = (low + high) / 2;
		*(point_at(curves, load, middle).torque > 0 ? &high : &low) = middle;
	}
	return (low + high) / 2;
}

static double pull_at(const struct vehicle_outline *vehicle, const struct mobility_curves *curves, const double *loads, double slip)
{
	double pull = 0;
	for (size_t i = 0; i < vehicle->wheel_count; i++) {
		const struct mobility_wheel_curves *of = &curves->of[curves->kinds[i]];
		pull += point_at(of, loads[i], vehicle->wheels[i].driven ? slip : free_slip(of, loads[i])).drawbar;
	}
	return pull;
}

/* Finds the least slip that pulls enough: the first of the curves' slips that does, then between it and the one before. */
static bool slip_for(const struct vehicle_outline *vehicle, const struct mobility_curves *curves, const double *loads, double wanted, double *slip)
{
	size_t i = 0;
	while (i < MOBILITY_SLIPS && pull_at(vehicle, curves, loads, mobility_slips[i]) < wanted)
		i++;
	if (i == MOBILITY_SLIPS)
		return false;
	double low = i > 0 ? mobility_slips[i - 1] : mobility_slips[0], high = mobility_slips[i];
	for (int k = 0; k < 30; k++) {
		const double middle = (low + high) / 2;
		*(pull_at(vehicle, curves, loads, middle) < wanted ? &low : &high) = middle;
	}
	*slip = high;
	return true;
}

static struct mobility_verdict no(enum mobility_reason reason)
{
	return (struct mobility_verdict){reason, NAN, NAN, NAN};
}

struct mobility_verdict mobility_judge(const struct vehicle_outline *vehicle, const struct mobility_curves *curves, double gravity, double slope,
				       double heading)
{
	const double weight = vehicle->mass * gravity, a = slope * RADIANS, h = heading * RADIANS;
	const double along[2] = {weight * sin(a) * cos(h), weight * sin(a) * sin(h)};
	double loads[VEHICLE_WHEELS_MOST], slip;
	if (slope >= curves->friction_angle)
		return no(MOBILITY_TOO_STEEP);
	if (!loads_of(vehicle, weight * cos(a), along, loads))
		return no(MOBILITY_TIPS);
	for (size_t i = 0; i < vehicle->wheel_count; i++)
		if (loads[i] <= 0)
			return no(MOBILITY_TIPS);
	for (size_t i = 0; i < vehicle->wheel_count; i++) {
		const struct mobility_wheel_curves *of = &curves->of[curves->kinds[i]];
		if (loads[i] < of->loads[0] || loads[i] > of->loads[MOBILITY_LOADS - 1])
			return no(MOBILITY_OFF_CURVES);
	}
	/* Shear that holds the vehicle against sliding to the side does not pull. Going down, the wheels hold it back. */
	const double wanted = along[0] < 0 ? along[0] : hypot(along[0], along[1]);
	if (!slip_for(vehicle, curves, loads, wanted, &slip))
		return no(MOBILITY_NO_PULL);
	struct mobility_verdict verdict = {MOBILITY_GO, slip, 0, 0};
	for (size_t i = 0; i < vehicle->wheel_count; i++) {
		const struct vehicle_wheel *wheel = &vehicle->wheels[i];
		const struct mobility_wheel_curves *of = &curves->of[curves->kinds[i]];
		const struct mobility_point point = point_at(of, loads[i], wheel->driven ? slip : free_slip(of, loads[i]));
		if (wheel->driven && point.torque > wheel->torque_most)
			return no(MOBILITY_NO_TORQUE);
		if (point.sinkage >= vehicle->clearance)
			return no(MOBILITY_NO_CLEARANCE);
		if (!point.steady)
			return no(MOBILITY_DIGS);
		verdict.torque = wheel->driven ? fmax(verdict.torque, point.torque) : verdict.torque;
		verdict.sinkage = fmax(verdict.sinkage, point.sinkage);
	}
	return verdict;
}
