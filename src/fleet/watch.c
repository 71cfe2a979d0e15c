/*
 * A thread that looks each second whether the rank still waits.
 *
 * Invariant: `since` is 0 unless the rank waits. All of it is guarded by the mutex.
 */
#include "fleet/watch.h"

#include <stdio.h>

#include "base/base.h"

#define LOOKS 1.0 /* s */

static struct {
	struct thread thread;
	struct mutex mutex;
	struct condition ends;
	bool started, ending;
	int rank;
	double since, tell; /* s: when it began to wait, and after how long the next line comes */
} watch;

static void tell_locked(double waited)
{
	if (watch.rank < 0)
		fprintf(stderr, "furrow: note: has waited %.0f s for the other ranks to start; each must be furrow drive, and Ctrl-C ends all\n", waited);
	else
		fprintf(stderr, "furrow: note: rank %d: has waited %.0f s for the others; one may be slow, stopped or gone: Ctrl-C ends all, and "
				"--resume goes on from the last commit\n", watch.rank, waited);
}

static void *look(void *argument)
{
	mutex_lock(&watch.mutex);
	while (!watch.ending) {
		const double waited = clock_seconds() - watch.since;
		if (watch.since > 0 && waited >= watch.tell) {
			tell_locked(waited);
			watch.tell *= 2;
		}
		condition_wait_for(&watch.ends, &watch.mutex, LOOKS);
	}
	mutex_unlock(&watch.mutex);
	return NULL;
}

void fleet_watch_start(void)
{
	mutex_init(&watch.mutex);
	condition_init(&watch.ends);
	watch.ending = false;
	watch.since = 0;
	watch.started = thread_start(&watch.thread, look, NULL, "furrow-ranks") == STATUS_OK;
}

void fleet_watch_finish(void)
{
	if (!watch.started)
		return;
	mutex_lock(&watch.mutex);
	watch.ending = true;
	condition_wake_all(&watch.ends);
	mutex_unlock(&watch.mutex);
	thread_join(&watch.thread);
	condition_finish(&watch.ends);
	mutex_finish(&watch.mutex);
	watch.started = false;
}

void fleet_watch_begin(int rank, double seconds)
{
	if (!watch.started || rank > 1)
		return;
	mutex_lock(&watch.mutex);
	watch.rank = rank;
	watch.since = clock_seconds();
	watch.tell = seconds;
	mutex_unlock(&watch.mutex);
}

void fleet_watch_end(void)
{
	if (!watch.started)
		return;
	mutex_lock(&watch.mutex);
	watch.since = 0;
	mutex_unlock(&watch.mutex);
}
