#define _GNU_SOURCE
#include "base/thread.h"

#include <errno.h>
#include <math.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "base/c_locale.h"

static atomic_uint running;

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
	pthread_condattr_t attributes;
	must(pthread_condattr_init(&attributes));
	must(pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC));
	must(pthread_cond_init(&condition->handle, &attributes));
	must(pthread_condattr_destroy(&attributes));
}

void condition_finish(struct condition *condition)
{
	must(pthread_cond_destroy(&condition->handle));
}

void condition_wait(struct condition *condition, struct mutex *mutex)
{
	must(pthread_cond_wait(&condition->handle, &mutex->handle));
}

void condition_wait_for(struct condition *condition, struct mutex *mutex, double seconds)
{
	struct timespec until;
	must(clock_gettime(CLOCK_MONOTONIC, &until));
	double whole = floor(seconds);
	until.tv_sec += (time_t)whole;
	until.tv_nsec += (long)((seconds - whole) * 1e9);
	if (until.tv_nsec >= 1000000000) {
		until.tv_sec++;
		until.tv_nsec -= 1000000000;
	}
	int error = pthread_cond_timedwait(&condition->handle, &mutex->handle, &until);
	must(error == ETIMEDOUT ? 0 : error);
}

void condition_wake_all(struct condition *condition)
{
	must(pthread_cond_broadcast(&condition->handle));
}

static void *begin(void *user)
{
	struct thread *thread = user;
	uselocale(thread->locale);
	return thread->body(thread->argument);
}

enum status thread_start(struct thread *thread, void *(*body)(void *), void *argument,
			 const char *name)
{
	sigset_t all, before;
	thread->started = false;
	TRY(c_locale(&thread->locale));
	thread->body = body;
	thread->argument = argument;
	sigfillset(&all);
	must(pthread_sigmask(SIG_SETMASK, &all, &before));
	int error = pthread_create(&thread->handle, NULL, begin, thread);
	must(pthread_sigmask(SIG_SETMASK, &before, NULL));
	thread->started = error == 0;
	if (error != 0)
		return fail_with(STATUS_FAILED, "thread %s: %s; raise the limit on threads or on memory (ulimit -u, -v)", name,
			    strerror(error));
	atomic_fetch_add(&running, 1);
	pthread_setname_np(thread->handle, name);
	return STATUS_OK;
}

void thread_join(struct thread *thread)
{
	if (!thread->started)
		return;
	must(pthread_join(thread->handle, NULL));
	thread->started = false;
	atomic_fetch_sub(&running, 1);
}

unsigned thread_running(void)
{
	return atomic_load(&running);
}

void thread_background(void)
{
	/* On Linux each thread has a priority of its own. The step is relative, since the process may already run at a low priority. */
	id_t self = (id_t)gettid();
	setpriority(PRIO_PROCESS, self, getpriority(PRIO_PROCESS, self) + 10);
}

int thread_cores(void)
{
	cpu_set_t cores;
	if (sched_getaffinity(0, sizeof cores, &cores) != 0)
		return 1;
	int count = CPU_COUNT(&cores);
	return count > 0 ? count : 1;
}
