/*
 * The phases of a world: which there are, and which function leads from one to the next.
 *
 *     opened --world_start--> started --world_warm--> warm --world_begin--> ready --world_begin_run--> stepping
 *
 *     ready, stepping --world_tear--> torn --world_mend--> the one before
 *     ready, stepping, torn --world_rollback--> ready or stepping
 *     each --world_stop--> ended
 *
 * Invariants:
 * 1. Only `torn` has ground that is not that of a whole step. Only in it is a commit forbidden.
 * 2. Until `stepping`, no byte of a file has changed.
 * 3. A world that failed on its way to a phase stays in the phase before. world_finish frees it there, too.
 */
#include <assert.h>

#include "world/internal.h"

/* An arrow: the function `by` may lead from one phase to another. */
static const struct arrow {
	enum world_phase from, to;
	const char *by;
} arrows[] = {
	{WORLD_OPENED, WORLD_STARTED, "world_start"},
	{WORLD_STARTED, WORLD_WARM, "world_warm"},
	{WORLD_WARM, WORLD_READY, "world_begin"},
	{WORLD_READY, WORLD_STEPPING, "world_begin_run"},
	{WORLD_READY, WORLD_TORN, "world_tear"},
	{WORLD_STEPPING, WORLD_TORN, "world_tear"},
	{WORLD_TORN, WORLD_READY, "world_mend"},
	{WORLD_TORN, WORLD_STEPPING, "world_mend"},
	{WORLD_STEPPING, WORLD_READY, "world_rollback"}, /* to a checkpoint of before the run's first step */
	{WORLD_OPENED, WORLD_ENDED, "world_stop"},
	{WORLD_STARTED, WORLD_ENDED, "world_stop"},
	{WORLD_WARM, WORLD_ENDED, "world_stop"},
	{WORLD_READY, WORLD_ENDED, "world_stop"},
	{WORLD_STEPPING, WORLD_ENDED, "world_stop"},
	{WORLD_TORN, WORLD_ENDED, "world_stop"},
};

const char *world_phase_arrow(enum world_phase from, enum world_phase to)
{
	for (size_t i = 0; i < sizeof arrows / sizeof *arrows; i++)
		if (arrows[i].from == from && arrows[i].to == to)
			return arrows[i].by;
	return NULL;
}

const char *world_phase_name(enum world_phase phase)
{
	static const char *const names[WORLD_PHASES] = {"opened", "started", "warm", "ready", "stepping", "torn", "ended"};
	return names[phase];
}

enum world_phase world_phase(const struct world *world)
{
	return world->phase;
}

void world_enter(struct world *world, enum world_phase to)
{
	assert(world_phase_arrow(world->phase, to) != NULL);
	world->phase = to;
}

bool world_is_torn(const struct world *world)
{
	return world->phase == WORLD_TORN;
}

bool world_has_begun(const struct world *world)
{
	return (world->phase == WORLD_TORN ? world->torn_from : world->phase) == WORLD_STEPPING;
}

void world_tear(struct world *world)
{
	if (world->phase != WORLD_READY && world->phase != WORLD_STEPPING) /* nothing to tear, or torn already */
		return;
	world->torn_from = world->phase;
	world_enter(world, WORLD_TORN);
}

void world_mend(struct world *world)
{
	if (world->phase == WORLD_TORN)
		world_enter(world, world->torn_from);
}

void world_return_to(struct world *world, bool begun)
{
	const enum world_phase to = begun ? WORLD_STEPPING : WORLD_READY;
	if (world->phase != to)
		world_enter(world, to);
}
