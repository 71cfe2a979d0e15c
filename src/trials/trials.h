/*
 * trials: what is measured by drives that are made for it, by a host that uses furrow.h alone. The rig drives one object over a level bed. Mobility
 * judges a vehicle on slopes by what the rig measured of its wheels.
 */
#ifndef FURROW_TRIALS_H
#define FURROW_TRIALS_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/base.h"

/*
 * rig: the single-wheel test of terramechanics. An object is carried over level soil in a straight line, under a load or at a depth. It may be turned against
 * its way: a wheel at a slip angle, a blade at a rake. A wheel has a slip or a torque besides. A body with a belt is as a wheel: what pulls its belt is in the
 * place of a torque. What the soil does to it when that is steady becomes a row.
 *
 * The bodies are those of a scene, and furrow_step moves them, so a row is what a drive would tell. Several runs share one bed. Each
 * has a lane of its own, and no soil goes from one lane to the next.
 *
 * All functions belong to one thread.
 */
#define RIG_VALUES_MOST 256 /* loads, slips or torques of one call */
#define RIG_PASSES_MOST 4

enum rig_state {
	RIG_STEADY, /* it goes on as it is */
	RIG_DIGS,   /* it still sinks: over the last quarter of its way by more than RIG_DIGS_ABOVE of its sinkage */
	RIG_SUNK,   /* the soil does not carry the load, in more than RIG_SUNK_ABOVE of the last quarter */
	RIG_SPINS,  /* no slip up to RIG_SLIP_MOST gives so large a torque, or none down to RIG_SLIP_LEAST one so small */
	RIG_GROWS   /* at a depth: the force against its way differs between the halves of the last quarter by more than RIG_DIGS_ABOVE */
};
#define RIG_DIGS_ABOVE 0.05
#define RIG_SUNK_ABOVE 0.1
#define RIG_SLIP_LOCKED (-1000.0) /* of a wheel that as good as does not turn */
#define RIG_SLIP_MOST 0.95
#define RIG_SLIP_LEAST (-0.9)
extern const char *const trials_rig_states[];

struct rig_params {
	const char *shape;              /* YAML: what a scene's object has as its `shape`, with or without its braces */
	const char *const *soils;       /* name of a soil, or YAML of a scene's `soil` in braces */
	size_t soil_count;
	const double *loads;            /* N, above 0 */
	size_t load_count;
	const double *depths;           /* m: of its lowest point below the untouched ground, instead of loads; 0 or more */
	size_t depth_count;
	const double *angles;           /* degrees that it is turned to the left of its way, of a wheel its slip angle; -180 to 180 */
	size_t angle_count;             /* 0: one angle of 0 */
	double rake;                    /* degrees between its front and the level: 90 is upright, less leans back; 0: 90. Of a wheel 0 or 90 */
	double speed;                   /* m/s; 0: RIG_SPEED */
	double way;                     /* m; 0: eight radii, or half lengths */
	const double *slips;            /* 1 - way / (turn x radius), below 1; used for wheels and belts. The way is the whole one, at whatever angle */
	size_t slip_count;
	const double *torques;          /* N m, of the drive; of a belt its pull, N. With torques there are no slips */
	size_t torque_count;
	size_t passes;                  /* objects that follow each other in a lane, up to RIG_PASSES_MOST; 0: one */
	const double *leads;            /* N: loads of those ahead of the last, one for each of loads; NULL: as loads */
	double spacing;                 /* m between posts; 0: a twentieth of the object's width or height, whichever is less */
	const char *settings;           /* of the scene, each KEY=VALUE on a line, as in redistribute.slip_sinkage=0.3; NULL: none */
	const char *folder;             /* an existing folder, in which the bed has a folder while it is used */
	const volatile sig_atomic_t *stop;
	/* Called from time to time. If it does not return STATUS_OK, the rig stops with that. NULL: no calls */
	enum status (*progress)(void *user, int64_t done, int64_t total);
	bool advise;                    /* notes tell what looks wrong with the scene of each soil */
	void *user;
};

#define RIG_SPEED 0.1 /* m/s */

/* Means over the last quarter of the way. NaN: there is no such figure. The object's own axes: forward and left are level, turned by its angle from the way. */
struct rig_row {
	size_t soil;          /* index */
	size_t load, angle;   /* indices of its load, or its depth, and of its angle; 0 where there are none */
	size_t pass;          /* how many went before it in its lane */
	double slip;
	double torque;        /* N m: the drive's; positive: it drives the wheel forward. Of a belt: its pull, N */
	double sinkage;       /* m below the undisturbed surface */
	double drawbar, side; /* N: along its own forward axis, positive pulls; to its own left */
	double fz;            /* N: the soil's vertical force */
	double efficiency;    /* force along the way x way / (torque x turn); of a wheel or a belt that is driven and pulls along its way */
	double overturning, aligning; /* N m, about the object's origin: about its forward axis, and about the vertical */
	double against, against_least, against_most; /* N: force against the way: its mean, and its range */
	double heap;          /* m: of the highest soil ahead of the object's origin, above the untouched ground, at the end; 0: none is higher */
	double heap_volume;   /* m3: of all soil there that lies above the untouched ground */
	double deeper;        /* m: by how much the second half of that quarter is deeper than the first */
	enum rig_state state;
};

/* What the rig found out before it began. */
struct rig_found {
	bool wheel, belt;
	double radius, width; /* m, of a wheel */
	double arm;           /* m: torque / force along the rim: a wheel's radius; of a belt 1, since its pull is such a force */
	double spacing, way;  /* m */
};

typedef enum status (*rig_row_fn)(void *user, const struct rig_row *row);

/*
 * Runs all soils, loads (or depths), angles and slips (or torques), and gives a row for each, in that order, slips fastest. With several passes each of them has
 * a row, the first pass first; with torques the last alone, and those ahead slip as it does. An object that is no wheel and has no belt has one row a load. Objects that follow each other have the same slip. STATUS_INPUT: shape, soil or a setting is wrong. STATUS_INTERRUPTED: `stop` was set; rows of soils that were done
 * have been given.
 */
enum status trials_rig_run(const struct rig_params *params, struct rig_found *found, rig_row_fn give, void *user) FURROW_CHECKED;

/*
 * mobility: whether a vehicle can drive over a slope, and how much it slips there, from what the rig measured of its wheels.
 *
 *     trials_measure_wheels -> trials_judge: one slope and heading
 *                      -> trials_table_make -> trials_table_at: all slopes and headings, for a map
 *
 * It is a quasi-static model: constant speed, all driven wheels with one slip, free wheels without torque. The wheels' loads are those
 * of a rigid body on equal springs. The same curves tell drives and maps, so that they agree says that both are consistent, not that
 * they are true.
 *
 * trials_measure_wheels belongs to one thread. All others are pure. Any thread.
 */
/* A wheel of a vehicle. x and y: m from the centre of gravity, forward and to the left. */
struct trials_wheel {
	double x, y, radius, width;
	bool driven;
	double torque_most;    /* N m that its motor gives; INFINITY: not limited */
};
#define TRIALS_WHEELS_MOST 32
/* What of a vehicle decides where it can drive. */
struct trials_vehicle {
	double mass;           /* kg */
	double height;         /* m: of the centre of gravity above the lowest part that touches the ground */
	double clearance;      /* m: of the lowest part that does not touch the ground; INFINITY: there is none */
	struct trials_wheel wheels[TRIALS_WHEELS_MOST];
	size_t wheel_count;
};

#define MOBILITY_LOADS 5
#define MOBILITY_SLIPS 12

/* Returns NULL if this vehicle can be judged. Otherwise the reason, a static text: "WHY; WHAT TO DO". */
const char *trials_vehicle_problem(const struct trials_vehicle *vehicle);
/* Returns the distance between its first and last axle, or its longest wheel's diameter if that is more, m. */
double trials_vehicle_length(const struct trials_vehicle *vehicle);

/* Returns how many wheels run ahead of one in its track: those that it overlaps by more than half of the narrower one's width. At most
 * RIG_PASSES_MOST - 1. */
size_t trials_wheel_pass(const struct trials_vehicle *vehicle, size_t wheel);

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
	size_t kinds[TRIALS_WHEELS_MOST]; /* of each wheel */
	struct mobility_wheel_curves of[TRIALS_WHEELS_MOST];
};
extern const double trials_slips[MOBILITY_SLIPS];

/* One wheel under one load: its curves over slip, read straight between those of two loads. */
struct mobility_wheel {
	double radius;         /* m */
	struct mobility_point points[MOBILITY_SLIPS];
};
void trials_wheel_load(const struct mobility_wheel_curves *curves, double load, struct mobility_wheel *out);
/* Returns what the curves tell at a slip (as in struct rig_params), read straight between their points. */
struct mobility_point trials_wheel_straight(const struct mobility_wheel *wheel, double slip);
/* Returns the slip of a wheel that turns freely: its torque is 0. */
double trials_wheel_free_slip(const struct mobility_wheel *wheel);

/* What a wheel's soil gives it: along its plane, N, and across, against the way that it slides aside, N; N m, m. */
struct mobility_pull {
	double drawbar, side, torque, sinkage;
	bool steady;
};
/* Returns the forces on a wheel whose way makes an angle with its plane. tangent: of that slip angle, at least 0. */
struct mobility_pull trials_wheel_at(const struct mobility_wheel *wheel, double slip, double tangent);

struct mobility_rig {
	const char *soil;      /* as in struct rig_params */
	double friction_angle; /* degrees, of that soil; NaN: it has none */
	double gravity;        /* m/s2 */
	double spacing;        /* m between posts; 0: a tenth of a wheel's width or radius, whichever is less */
	const char *folder;    /* an existing folder for the bed */
	const volatile sig_atomic_t *stop;
	enum status (*progress)(void *user, int64_t done, int64_t total);
	void *user;
};

/* Runs the rig for each size of wheel, under loads from 0.2 of their mean to 1.8. A wheel runs behind those that are ahead of it in its track.
 * STATUS_INPUT: the vehicle cannot be judged, or the soil is wrong. */
enum status trials_measure_wheels(const struct trials_vehicle *vehicle, const struct mobility_rig *rig, struct mobility_curves *curves) FURROW_CHECKED;

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
extern const char *const trials_reason_names[MOBILITY_REASONS];
bool trials_is_unknown(enum mobility_reason reason);

struct mobility_verdict {
	enum mobility_reason reason;
	double slip, torque, sinkage; /* of the wheel that has most; NaN unless it goes */
	double crab;                  /* degrees that its nose is turned up the slope from its way */
};
#define MOBILITY_CRAB_MOST 45.0 /* degrees */

/* Judges a vehicle on a slope, degrees from level. heading: degrees between its way and the way straight up, 0 to 180. */
struct mobility_verdict trials_judge(const struct trials_vehicle *vehicle, const struct mobility_curves *curves, double gravity, double slope,
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
void trials_table_make(const struct trials_vehicle *vehicle, const struct mobility_curves *curves, double gravity, struct mobility_table *table);

/* Of a slope: the verdict straight up. And the steepest heading at which it goes, degrees from along the slope (0) to straight up (90);
 * NaN: it goes at none. every: it goes at every heading between. */
struct mobility_slope {
	struct mobility_verdict up;
	double steepest;
	bool every;
};
struct mobility_slope trials_table_at(const struct mobility_table *table, double slope);

/* Fills factors for scene_soil_varied: a Latin hypercube of `count` soils. Each factor is lognormal with median 1; spread: standard deviations of
 * their logarithms. The same seed gives the same factors. */
void trials_spread_factors(const double spread[3], int64_t seed, size_t count, double (*factors)[3]);
/* Verdicts straight up, for slopes as in a table: what P(GO) needs of a soil. */
struct mobility_column {
	struct mobility_verdict verdicts[MOBILITY_SLOPES];
};
void trials_column_make(const struct trials_vehicle *vehicle, const struct mobility_curves *curves, double gravity, struct mobility_column *column);
/* Returns the share of the soils whose verdict straight up this slope, degrees, is go. NaN: no ground, or no soil. */
double trials_probability(const struct mobility_column *columns, size_t count, double slope);

#endif
