/* A few threads that share the tasks of one call. */
#ifndef FURROW_BASE_CREW_H
#define FURROW_BASE_CREW_H

#include <stddef.h>

#include "base/base.h"

struct crew;

/* Does one task. Two tasks never run as the same member at once, so a member may own scratch memory. */
typedef enum status (*crew_task_fn)(void *user, size_t member, size_t task);

/* What a thread of a crew does when it begins and before it ends. */
typedef void (*crew_hook_fn)(void);

/* Makes a crew of at least 1 member. One of them is the thread that calls crew_run; for the others threads with this name are started, which call
 * `enter` first and `leave` last. Both may be NULL. */
enum status crew_create(size_t members, const char *name, crew_hook_fn enter, crew_hook_fn leave, struct crew **out) FURROW_CHECKED;
void crew_destroy(struct crew *crew); /* crew may be NULL; no call may be running */
/*
 * Does tasks 0 to count - 1, and waits for all. Each member begins with a run of neighbours, so that in a later call with as many
 * tasks it mostly gets the same ones. After a failure no other task begins; returns the failure. One thread at a time.
 */
enum status crew_run(struct crew *crew, size_t count, crew_task_fn task, void *user) FURROW_CHECKED;

#endif
