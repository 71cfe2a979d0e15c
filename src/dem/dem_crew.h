/* Used inside dem only. A few threads that share the tasks of one call. */
#ifndef FURROW_DEM_CREW_H
#define FURROW_DEM_CREW_H

#include <stddef.h>

#include "base/base.h"

struct dem_crew;

/* Does one task. Two tasks never run as the same member at once, so a member may own scratch memory. */
typedef enum status (*dem_task_fn)(void *user, size_t member, size_t task);

/* Makes a crew of at least 1 member. One of them is the thread that calls dem_crew_run; for the others threads are started. */
enum status dem_crew_create(size_t members, struct dem_crew **out) FURROW_CHECKED;
void dem_crew_destroy(struct dem_crew *crew); /* crew may be NULL; no call may be running */
/*
 * Does tasks 0 to count - 1, and waits for all. Each member begins with a run of neighbours, so that in a later call with as many
 * tasks it mostly gets the same ones. After a failure no other task begins; returns the failure. One thread at a time.
 */
enum status dem_crew_run(struct dem_crew *crew, size_t count, dem_task_fn task, void *user) FURROW_CHECKED;

#endif
