/*
 * Threads, a mutex and a condition, over pthreads. Locking and waking cannot fail on a valid
 * object and abort if they do; starting can fail and returns a status.
 */
#ifndef FURROW_BASE_THREAD_H
#define FURROW_BASE_THREAD_H

#include <pthread.h>
#include <stdbool.h>

#include "base/status.h"

struct mutex {
	pthread_mutex_t handle;
};

struct condition {
	pthread_cond_t handle;
};

struct thread {
	pthread_t handle;
	bool started;
};

void mutex_init(struct mutex *mutex);
void mutex_finish(struct mutex *mutex);
void mutex_lock(struct mutex *mutex);
void mutex_unlock(struct mutex *mutex);

void condition_init(struct condition *condition);
void condition_finish(struct condition *condition);
void condition_wait(struct condition *condition, struct mutex *mutex);
/* As condition_wait, but waits at most `seconds`. */
void condition_wait_for(struct condition *condition, struct mutex *mutex, double seconds);
void condition_wake_all(struct condition *condition);

/* Signals are blocked in the new thread, so that Ctrl-C always reaches the main one. */
enum status thread_start(struct thread *thread, void *(*body)(void *), void *argument,
			 const char *name) FURROW_CHECKED;
void thread_join(struct thread *thread); /* nothing if it was never started */
unsigned thread_running(void); /* in this process: started and not joined */

/* Lowers the priority of the calling thread, so that other threads run first when cores are few. Does nothing where this is not
 * possible. */
void thread_background(void);

int thread_cores(void); /* cores this process may run on, at least 1 */

#endif
