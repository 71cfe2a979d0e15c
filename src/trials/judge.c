/*
 * A vehicle on a slope: its wheels' loads, and the least slip at which they pull as much as gravity does.
 *
 * It goes on in a straight line at constant speed. Across a slope its nose points up by the angle at which the soil's side forces hold it. All
 * wheels stand at this angle to their way.
 */
#include <math.h>

#include "trials/trials.h"

#define RADIANS (3.14159265358979323846 / 180)

const char *const trials_reason_names[MOBILITY_REASONS] = {
	[MOBILITY_GO] = "go", [MOBILITY_NO_PULL] = "too little pull", [MOBILITY_SLIDES] = "slides down", [MOBILITY_NO_TORQUE] = "too little torque", [MOBILITY_TIPS] = "tips over",
	[MOBILITY_NO_CLEARANCE] = "sinks to its belly", [MOBILITY_DIGS] = "digs itself in", [MOBILITY_OFF_CURVES] = "load beyond the curves",
	[MOBILITY_TOO_STEEP] = "steeper than the friction angle", [MOBILITY_NO_GROUND] = "no ground",
};

bool trials_is_unknown(enum mobility_reason reason)
{
	return reason == MOBILITY_OFF_CURVES || reason == MOBILITY_TOO_STEEP || reason == MOBILITY_NO_GROUND;
}

/*
 * Finds the wheels' loads N of a rigid body on equal springs:
 *
 *     N_i = a + b x_i + c y_i,  sum N_i = W cos(slope),  sum N_i x_i = -h W_x,  sum N_i y_i = -h W_y
 *
 * W_x, W_y: the parts of the weight down the slope, against x and y. Returns false if the wheels lie in one line.
 */
static bool loads_of(const struct trials_vehicle *vehicle, double normal, const double along[2], double *loads)
{
	double s = (double)vehicle->wheel_count, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
	for (size_t i = 0; i < vehicle->wheel_count; i++) {
		const struct trials_wheel *w = &vehicle->wheels[i];
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

/* What all of a judgement's trials share. */
struct trial {
	const struct trials_vehicle *vehicle;
	double along, aside;                   /* N: the parts of the weight against its way, and down across it */
	double loads[TRIALS_WHEELS_MOST];     /* N */
	double free_slips[TRIALS_WHEELS_MOST];
	struct mobility_wheel wheels[TRIALS_WHEELS_MOST];
};

static struct mobility_pull wheel_at(const struct trial *trial, size_t wheel, double slip, double crab)
{
	return trials_wheel_at(&trial->wheels[wheel], trial->vehicle->wheels[wheel].driven ? slip : trial->free_slips[wheel], tan(crab));
}

/* The sums over the wheels, less what the weight asks for along the vehicle and across it. */
static void balance(const struct trial *trial, double slip, double crab, double *forward, double *aside)
{
	*forward = -trial->along * cos(crab) - trial->aside * sin(crab);
	*aside = -trial->aside * cos(crab) + trial->along * sin(crab);
	for (size_t i = 0; i < trial->vehicle->wheel_count; i++) {
		const struct mobility_pull pull = wheel_at(trial, i, slip, crab);
		*forward += pull.drawbar;
		*aside += pull.side;
	}
}

/* Finds the angle by which its nose points up the slope, so that it does not slide down. Returns false if there is none. */
static bool crab_for(const struct trial *trial, double slip, double *crab)
{
	double low = 0, high = MOBILITY_CRAB_MOST * RADIANS, forward, aside;
	*crab = 0;
	if (!(trial->aside > 0))
		return true;
	balance(trial, slip, high, &forward, &aside);
	if (aside < 0)
		return false;
	/* False position; an end that stays twice counts half (Illinois). At 0 the wheels give no side force. */
	double below = -trial->aside, above = aside;
	int stayed = 0;
	for (int i = 0; i < 30 && high - low > 1e-7; i++) {
		*crab = low + (high - low) * below / (below - above);
		balance(trial, slip, *crab, &forward, &aside);
		if (fabs(aside) < 1e-7 * trial->aside)
			return true;
		const bool less = aside < 0;
		*(less ? &low : &high) = *crab;
		*(less ? &below : &above) = aside;
		if (stayed == (less ? 1 : -1))
			*(less ? &above : &below) /= 2;
		stayed = less ? 1 : -1;
	}
	return true;
}

/* Returns MOBILITY_GO if it goes on at this slip, or slips less. */
static enum mobility_reason goes_at(const struct trial *trial, double slip, double *crab)
{
	double forward, aside;
	if (!crab_for(trial, slip, crab))
		return MOBILITY_SLIDES;
	balance(trial, slip, *crab, &forward, &aside);
	return forward < 0 ? MOBILITY_NO_PULL : MOBILITY_GO;
}

/* Finds the least slip that pulls enough: the first of the curves' slips that does, then between it and the one before. */
static enum mobility_reason slip_for(const struct trial *trial, double *slip, double *crab)
{
	enum mobility_reason reason = MOBILITY_SLIDES;
	size_t i = 0;
	for (; i < MOBILITY_SLIPS; i++) {
		const enum mobility_reason now = goes_at(trial, trials_slips[i], crab);
		if (now == MOBILITY_GO)
			break;
		reason = now == MOBILITY_NO_PULL ? now : reason;
	}
	if (i == MOBILITY_SLIPS)
		return reason;
	/* Its brakes do not hold it. */
	if (i == 0)
		return MOBILITY_SLIDES;
	double low = trials_slips[i - 1], high = trials_slips[i];
	for (int k = 0; k < 20; k++) {
		const double middle = (low + high) / 2;
		*(goes_at(trial, middle, crab) == MOBILITY_GO ? &high : &low) = middle;
	}
	*slip = high;
	return goes_at(trial, high, crab);
}

static struct mobility_verdict no(enum mobility_reason reason)
{
	return (struct mobility_verdict){reason, NAN, NAN, NAN, NAN};
}

struct mobility_verdict trials_judge(const struct trials_vehicle *vehicle, const struct mobility_curves *curves, double gravity, double slope,
				       double heading)
{
	const double weight = vehicle->mass * gravity, a = slope * RADIANS, h = heading * RADIANS;
	const double along[2] = {weight * sin(a) * cos(h), weight * sin(a) * sin(h)};
	struct trial trial = {.vehicle = vehicle, .along = along[0], .aside = fabs(along[1]) > 1e-12 * weight ? fabs(along[1]) : 0};
	double slip = NAN, crab = 0;
	if (slope >= curves->friction_angle)
		return no(MOBILITY_TOO_STEEP);
	if (!loads_of(vehicle, weight * cos(a), along, trial.loads))
		return no(MOBILITY_TIPS);
	for (size_t i = 0; i < vehicle->wheel_count; i++)
		if (trial.loads[i] <= 0)
			return no(MOBILITY_TIPS);
	for (size_t i = 0; i < vehicle->wheel_count; i++) {
		const struct mobility_wheel_curves *of = &curves->of[curves->kinds[i]];
		if (trial.loads[i] < of->loads[0] || trial.loads[i] > of->loads[MOBILITY_LOADS - 1])
			return no(MOBILITY_OFF_CURVES);
		trials_wheel_load(of, trial.loads[i], &trial.wheels[i]);
		trial.free_slips[i] = vehicle->wheels[i].driven ? 0 : trials_wheel_free_slip(&trial.wheels[i]);
	}
	const enum mobility_reason reason = slip_for(&trial, &slip, &crab);
	if (reason != MOBILITY_GO)
		return no(reason);
	struct mobility_verdict verdict = {MOBILITY_GO, slip, 0, 0, crab / RADIANS};
	for (size_t i = 0; i < vehicle->wheel_count; i++) {
		const struct trials_wheel *wheel = &vehicle->wheels[i];
		const struct mobility_pull pull = wheel_at(&trial, i, slip, crab);
		if (wheel->driven && pull.torque > wheel->torque_most)
			return no(MOBILITY_NO_TORQUE);
		if (pull.sinkage >= vehicle->clearance)
			return no(MOBILITY_NO_CLEARANCE);
		if (!pull.steady)
			return no(MOBILITY_DIGS);
		verdict.torque = wheel->driven ? fmax(verdict.torque, pull.torque) : verdict.torque;
		verdict.sinkage = fmax(verdict.sinkage, pull.sinkage);
	}
	return verdict;
}
