/*
 * fleet: one world, stepped by many processes (ranks) that MPI started, as `mpirun -n 4 furrow drive ...`.
 *
 * Every rank reads the scene and the base, and steps the vehicles. The ground is shared out: a tile that changes has one owner at a time.
 * Before each step all ranks learn which tiles each body may touch, and where soil may still slide. Bodies that share tiles are one group,
 * and a group is computed by one rank, in the scene's order. Tiles, bodies with the soil aboard, active blocks and soil in flight that
 * belong to another rank from then on are sent to it. So the ground, objects.csv and vehicles.csv are those of one process, bit by bit (law 12).
 *
 * Each rank writes an overlay of its own, its part, over the run's overlay. All ranks commit the same steps, one commit after the other.
 * At the end the parts are gathered into the run's overlay in one transaction. After a kill the parts remain; the next drive with --resume
 * gathers what all of them have.
 *
 * One process alone uses none of this.
 */
#ifndef FURROW_FLEET_H
#define FURROW_FLEET_H

#include <signal.h>
#include <stdbool.h>

#include "base/base.h"
#include "report/report.h"
#include "scene/scene.h"
#include "world/world.h"

struct fleet;

struct fleet_params {
	const struct scene *scene;
	const char *store;   /* path of the base; NULL: the scene's */
	const char *overlay; /* path of the run's overlay */
	const char *stage;   /* folder on each machine to which the base is copied, to be read from there; NULL: it is read from where it is */
	store_progress_fn progress; /* of the copying, called on rank 0 with rows; NULL: none */
	void *progress_user;
	bool resume, durable_full;
	const volatile sig_atomic_t *stop; /* becomes non-zero to end the run cleanly */
};

/* Returns true if a launcher has started this process as one of several. */
bool fleet_is_launched(void);
/* Joins the other ranks. STATUS_USAGE: MPI is not built in. */
enum status fleet_join(void) FURROW_CHECKED;
/* Leaves them, all ranks together. Does nothing if they were not joined. */
void fleet_leave(void);
/* Returns false on a rank that prints nothing, since rank 0 prints it. */
bool fleet_speaks(void);
/* Returns the failure of any rank on all ranks, that of the lowest one. */
enum status fleet_agree(enum status status) FURROW_CHECKED;

/* Makes the run's overlay, and this rank's part. Gathers what an earlier run left, if params->resume. STATUS_INPUT: it left something, and
 * the run is not to resume it. */
enum status fleet_open(const struct fleet_params *params, struct fleet **out) FURROW_CHECKED;
/* Returns the base's copy on this machine; NULL: there is none. Valid until the fleet is closed. */
const struct store_staged *fleet_staged(const struct fleet *fleet);
/* What the world calls. Valid until the fleet is closed. */
const struct world_ranks *fleet_ranks(struct fleet *fleet);
/* Becomes non-zero on all ranks after the same step, if any rank is to stop. */
const volatile sig_atomic_t *fleet_stop(const struct fleet *fleet);
/* Rows of objects.csv of all ranks go to `rows` of rank 0, in the order of one process. NULL: there are none. */
void fleet_rows(struct fleet *fleet, const struct report_rows *rows);
/* Closes it, after the world is closed. Removes the parts if they are gathered, and an overlay that the run made and left empty. */
void fleet_close(struct fleet *fleet); /* takes NULL */

/*
 * For a run by one process. Gathers into the overlay what an earlier run by many left beside it, if `resume`. STATUS_INPUT: it left something,
 * and the run is not to resume it. `overlay` NULL: does nothing.
 */
enum status fleet_gather_left(const char *overlay, bool resume) FURROW_CHECKED;

/*
 * Copies the base to params->stage, one rank on each machine, or checks the copy that is there. For a run by one process; fleet_open() does it
 * for many. *staged is all zero if params->stage is NULL. Free it with store_staged_finish(). The overlay is made later, or is there already.
 * A failure of any rank is returned on all.
 */
enum status fleet_stage(const struct fleet_params *params, struct store_staged *staged) FURROW_CHECKED;

#endif
