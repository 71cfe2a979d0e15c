#include "base/clock.h"

#include <time.h>

double clock_seconds(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

static double processor_seconds(clockid_t clock)
{
	struct timespec now;
	clock_gettime(clock, &now);
	return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double clock_thread_seconds(void)
{
	return processor_seconds(CLOCK_THREAD_CPUTIME_ID);
}

double clock_process_seconds(void)
{
	return processor_seconds(CLOCK_PROCESS_CPUTIME_ID);
}
