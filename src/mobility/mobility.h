/*
 * mobility: whether a vehicle can drive over a slope, and how much it slips there, from what the rig measured of its wheels.
 *
 *     mobility_measure -> mobility_judge: one slope and heading
 *                      -> mobility_table_make -> mobility_table_at: all slopes and headings, for a map
 *
 * It is a quasi-static model: constant speed, all driven wheels with one slip, free wheels without torque. The wheels' loads are those
 * of a rigid body on equal springs. The same curves tell drives and maps, so that they agree says that both are consistent, not that
 * they are true.
 *
 * mobility_measure belongs to one thread, and makes a GL context. All others are pure. Any thread.
 */
#ifndef FURROW_MOBILITY_H
#define FURROW_MOBILITY_H

#include <stdbool.h>
#include <stddef.h>

#include "base/base.h"
#include "rig/rig.h"
#include "vehicle/vehicle.h"

#define MOBILITY_LOADS 5
#define MOBILITY_SLIPS 12

/* Returns NULL if this vehicle can be judged. Otherwise the reason, a static text: "WHY; WHAT TO DO". */
const char *mobility_vehicle_problem(const struct vehicle_outline *vehicle);
/* Returns the distance between its first and last axle, or its longest wheel's diameter if that is more, m. */
double mobility_length(const struct vehicle_outline *vehicle);

/* Returns how many wheels run ahead of one in its track: those that it overlaps by more than half of the narrower one's width. At most
 * RIG_PASSES_MOST - 1. */
size_t mobility_pass(const struct vehicle_outline *vehicle, size_t wheel);

/* What the rig told of one wheel over loads and slips. */
struct mobility_point {
	double drawbar, torque, sinkage; /* N, N m, m below the undisturbed ground */
	double depth;                    /* m below the rut of the wheel ahead; of a first wheel the sinkage */
	bool steady;
};
struct mobility_wheel_curves {
	double radius, width, loads[MOBILITY_LOADS]; /* m, m, N */
	size_t pass;           /* how many wheels ran ahead of it in its track */
	struct mobility_point points[MOBILITY_LOADS][MOBILITY_SLIPS];
};
struct mobility_curves {
	double friction_angle; /* degrees, the soil's */
	size_t kind_count;     /* of wheels that differ */
	size_t kinds[VEHICLE_WHEELS_MOST]; /* of each wheel */
	struct mobility_wheel_curves of[VEHICLE_WHEELS_MOST];
};
extern const double mobility_slips[MOBILITY_SLIPS];

/* One wheel under one load: its curves over slip, read straight between those of two loads. */
struct mobility_wheel {
	double radius;         /* m */
	struct mobility_point points[MOBILITY_SLIPS];
};
void mobility_wheel_load(const struct mobility_wheel_curves *curves, double load, struct mobility_wheel *out);
/* Returns what the curves tell at a slip (as in struct rig_params), read straight between their points. */
struct mobility_point mobility_wheel_straight(const struct mobility_wheel *wheel, double slip);
/* Returns the slip of a wheel that turns freely: its torque is 0. */
double mobility_wheel_free_slip(const struct mobility_wheel *wheel);

/* What a wheel's soil gives it: along its plane, N, and across, against the way that it slides aside, N; N m, m. */
struct mobility_pull {
	double drawbar, side, torque, sinkage;
	bool steady;
};
/* Returns the forces on a wheel whose way makes an angle with its plane. tangent: of that slip angle, at least 0. */
struct mobility_pull mobility_wheel_at(const struct mobility_wheel *wheel, double slip, double tangent);

struct mobility_rig {
	const char *soil;      /* as in struct rig_params */
	double gravity;        /* m/s2 */
	double spacing;        /* m between posts; 0: a tenth of a wheel's width or radius, whichever is less */
	const char *folder;    /* an existing folder for the bed */
	const volatile sig_atomic_t *stop;
	enum status (*progress)(void *user, int64_t done, int64_t total);
	void *user;
};

/* Runs the rig for each size of wheel, under loads from 0.2 of their mean to 1.8. A wheel runs behind those that are ahead of it in its track.
 * STATUS_INPUT: the vehicle cannot be judged, or the soil is wrong. */
enum status mobility_measure(const struct vehicle_outline *vehicle, const struct mobility_rig *rig, struct mobility_curves *curves) FURROW_CHECKED;

/* Gives YAML of a soil whose strength and stiffness are multiplied: `factor` of cohesion, friction (its tangent), k_c and k_phi. Free it with
 * mem_free. NULL: out of memory, or there is no such soil; the message tells. */
char *mobility_soil_varied(const char *soil, const double factor[3]);

enum mobility_reason {
	MOBILITY_GO,
	MOBILITY_NO_PULL,    /* no slip gives the pull */
	MOBILITY_SLIDES,     /* no slip angle up to MOBILITY_CRAB_MOST gives the side force */
	MOBILITY_NO_TORQUE,  /* a motor is too weak */
	MOBILITY_TIPS,       /* a wheel has no load left */
	MOBILITY_NO_CLEARANCE, /* it sinks to its belly */
	MOBILITY_DIGS,       /* a wheel sinks on and on */
	MOBILITY_OFF_CURVES, /* unknown: a wheel's load is beyond the curves */
	MOBILITY_TOO_STEEP,  /* unknown: the ground is steeper than the soil's friction angle */
	MOBILITY_NO_GROUND,  /* there is no height */
	MOBILITY_REASONS
};
extern const char *const mobility_reason_names[MOBILITY_REASONS];
bool mobility_is_unknown(enum mobility_reason reason);

struct mobility_verdict {
	enum mobility_reason reason;
	double slip, torque, sinkage; /* of the wheel that has most; NaN unless it goes */
	double crab;                  /* degrees that its nose is turned up the slope from its way */
};
#define MOBILITY_CRAB_MOST 45.0 /* degrees */

/* Judges a vehicle on a slope, degrees from level. heading: degrees between its way and the way straight up, 0 to 180. */
struct mobility_verdict mobility_judge(const struct vehicle_outline *vehicle, const struct mobility_curves *curves, double gravity, double slope,
				       double heading);

/* Verdicts for slopes 0 to MOBILITY_SLOPE_MOST, and headings 0 to 90 degrees. */
#define MOBILITY_SLOPE_STEP 0.5
#define MOBILITY_SLOPE_MOST 60.0
#define MOBILITY_HEADING_STEP 5.0
#define MOBILITY_SLOPES 121
#define MOBILITY_HEADINGS 19
struct mobility_table {
	struct mobility_verdict verdicts[MOBILITY_SLOPES][MOBILITY_HEADINGS];
};
void mobility_table_make(const struct vehicle_outline *vehicle, const struct mobility_curves *curves, double gravity, struct mobility_table *table);

/* Of a slope: the verdict straight up. And the steepest heading at which it goes, degrees from along the slope (0) to straight up (90);
 * NaN: it goes at none. every: it goes at every heading between. */
struct mobility_slope {
	struct mobility_verdict up;
	double steepest;
	bool every;
};
struct mobility_slope mobility_table_at(const struct mobility_table *table, double slope);

/* Fills factors for mobility_soil_varied: a Latin hypercube of `count` soils. Each factor is lognormal with median 1; spread: standard deviations of
 * their logarithms. The same seed gives the same factors. */
void mobility_spread_factors(const double spread[3], int64_t seed, size_t count, double (*factors)[3]);
/* Verdicts straight up, for slopes as in a table: what P(GO) needs of a soil. */
struct mobility_column {
	struct mobility_verdict verdicts[MOBILITY_SLOPES];
};
void mobility_column_make(const struct vehicle_outline *vehicle, const struct mobility_curves *curves, double gravity, struct mobility_column *column);
/* Returns the share of the soils whose verdict straight up this slope, degrees, is go. NaN: no ground, or no soil. */
double mobility_probability(const struct mobility_column *columns, size_t count, double slope);

#endif
