/*
 * Threads, a mutex and a condition, on top of pthreads. Locking and waking abort the program on failure, which cannot occur
 * with valid objects. Starting a thread may fail and returns a status.
 */
#ifndef FURROW_BASE_THREAD_H
#define FURROW_BASE_THREAD_H

#include <locale.h>
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
	void *(*body)(void *); /* what it runs, with its argument, in this locale */
	void *argument;
	locale_t locale;
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

/* Starts a thread. `thread` stays where it is until thread_join. The thread has the locale "C", whatever the locale of the process. Signals
 * are blocked in it, so that Ctrl-C always reaches the main thread. */
enum status thread_start(struct thread *thread, void *(*body)(void *), void *argument,
			 const char *name) FURROW_CHECKED;
void thread_join(struct thread *thread); /* does nothing if the thread was never started */
unsigned thread_running(void); /* returns the number of threads in this process that were started and not joined */

/* Lowers the priority of the calling thread, so that other threads run first when cores are few. Does nothing where this is not
 * possible. */
void thread_background(void);

int thread_cores(void); /* returns the number of cores that this process may use, at least 1 */

#endif
