#define _GNU_SOURCE
#include "base/thread.h"

#include <sched.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

static void must(int error)
{
	if (error != 0)
		abort();
}

void mutex_init(struct mutex *mutex)
{
	must(pthread_mutex_init(&mutex->handle, NULL));
}

void mutex_finish(struct mutex *mutex)
{
	must(pthread_mutex_destroy(&mutex->handle));
}

void mutex_lock(struct mutex *mutex)
{
	must(pthread_mutex_lock(&mutex->handle));
}

void mutex_unlock(struct mutex *mutex)
{
	must(pthread_mutex_unlock(&mutex->handle));
}

void condition_init(struct condition *condition)
{
	must(pthread_cond_init(&condition->handle, NULL));
}

void condition_finish(struct condition *condition)
{
	must(pthread_cond_destroy(&condition->handle));
}

void condition_wait(struct condition *condition, struct mutex *mutex)
{
	must(pthread_cond_wait(&condition->handle, &mutex->handle));
}

void condition_wake_all(struct condition *condition)
{
	must(pthread_cond_broadcast(&condition->handle));
}

enum status thread_start(struct thread *thread, void *(*body)(void *), void *argument,
			 const char *name)
{
	sigset_t all, before;
	sigfillset(&all);
	must(pthread_sigmask(SIG_SETMASK, &all, &before));
	int error = pthread_create(&thread->handle, NULL, body, argument);
	must(pthread_sigmask(SIG_SETMASK, &before, NULL));
	thread->started = error == 0;
	if (error != 0)
		return fail_with(STATUS_FAILED, "thread %s: %s; raise the limit on threads (ulimit -u)", name,
			    strerror(error));
	pthread_setname_np(thread->handle, name);
	return STATUS_OK;
}

void thread_join(struct thread *thread)
{
	if (!thread->started)
		return;
	must(pthread_join(thread->handle, NULL));
	thread->started = false;
}

int thread_cores(void)
{
	cpu_set_t cores;
	if (sched_getaffinity(0, sizeof cores, &cores) != 0)
		return 1;
	int count = CPU_COUNT(&cores);
	return count > 0 ? count : 1;
}
