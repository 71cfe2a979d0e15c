/*
 * rig: the single-wheel test of terramechanics. An object is carried over level soil in a straight line, under a load, and a
 * wheel with a slip or a torque besides. A body with a belt is as a wheel: what pulls its belt is in the place of a torque. What the soil does to it when that is steady becomes a row.
 *
 * The bodies are those of a scene, and world steps them, so a row is what a drive would tell. Several runs share one bed. Each
 * has a lane of its own, and no soil goes from one lane to the next.
 *
 * All functions belong to one thread. They make a GL context of their own.
 */
#ifndef FURROW_RIG_H
#define FURROW_RIG_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/base.h"
#include "scene/scene.h"

#define RIG_VALUES_MOST 256 /* loads, slips or torques of one call */
#define RIG_PASSES_MOST 4

enum rig_state {
	RIG_STEADY, /* it goes on as it is */
	RIG_DIGS,   /* it still sinks: over the last quarter of its way by more than RIG_DIGS_ABOVE of its sinkage */
	RIG_SUNK,   /* the soil does not carry the load */
	RIG_SPINS   /* no slip up to RIG_SLIP_MOST gives so large a torque, or none down to RIG_SLIP_LEAST one so small */
};
#define RIG_DIGS_ABOVE 0.05
#define RIG_SLIP_MOST 0.95
#define RIG_SLIP_LEAST (-0.9)
extern const char *const rig_state_names[];

struct rig_params {
	const char *shape;              /* YAML: what a scene's object has as its `shape`, with or without its braces */
	const char *const *soils;       /* name of a soil, or YAML of a scene's `soil` in braces */
	size_t soil_count;
	const double *loads;            /* N, above 0 */
	size_t load_count;
	const double *slips;            /* 1 - way / (turn x radius), below 1; used for wheels and belts */
	size_t slip_count;
	const double *torques;          /* N m, of the drive; of a belt its pull, N. With torques there are no slips */
	size_t torque_count;
	size_t passes;                  /* objects that follow each other in a lane, up to RIG_PASSES_MOST; 0: one */
	const double *leads;            /* N: loads of those ahead of the last, one for each of loads; NULL: as loads */
	double spacing;                 /* m between posts; 0: a twentieth of the object's width or height, whichever is less */
	const struct scene_setting *settings; /* of the scene, as in redistribute.slip_sinkage */
	size_t setting_count;
	const char *folder;             /* an existing folder, in which the bed has a folder while it is used */
	const volatile sig_atomic_t *stop;
	/* Called from time to time. If it does not return STATUS_OK, the rig stops with that. NULL: no calls */
	enum status (*progress)(void *user, int64_t done, int64_t total);
	void (*tell)(void *user, const char *text); /* gets advice on the scene; NULL: nobody does */
	void *user;
};

/* Means over the last quarter of the way. The way leads along +x. NaN: there is no such figure. */
struct rig_row {
	size_t soil, load;    /* indices */
	size_t pass;          /* how many went before it in its lane */
	double slip;
	double torque;        /* N m: the drive's; positive: it drives the wheel forward. Of a belt: its pull, N */
	double sinkage;       /* m below the undisturbed surface */
	double drawbar, side; /* N: along the way, positive pulls; to the left */
	double fz;            /* N: the soil's vertical force */
	double efficiency;    /* drawbar x way / (torque x turn); of a wheel or a belt that is driven and pulls */
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
 * Runs all soils, loads and slips (or torques), and gives a row for each, in that order, slips fastest. With several passes each of them has
 * a row, the first pass first; with torques the last alone, and those ahead slip as it does. An object that is no wheel and has no belt has one row a load. Objects that follow each other have the same slip. STATUS_INPUT: shape, soil or a setting is wrong. STATUS_INTERRUPTED: `stop` was set; rows of soils that were done
 * have been given.
 */
enum status rig_run(const struct rig_params *params, struct rig_found *found, rig_row_fn give, void *user) FURROW_CHECKED;

/* Makes a scene that has this soil and nothing else: its soils[0] has the numbers. `soil`: as in struct rig_params. */
enum status rig_soil_scene(const char *soil, struct scene **out) FURROW_CHECKED;
/* Writes a soil as YAML in braces, with those of its numbers that the model reads. NULL: out of memory. Free it with mem_free. */
char *rig_soil_text(const struct soil_numbers *soil, enum deform_model model) FURROW_CHECKED;

#endif
