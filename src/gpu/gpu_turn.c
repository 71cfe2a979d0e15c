/*
 * Turns. Mesa's llvmpipe (seen with 22.3.6) copies, clears and maps a texture or buffer only after a look into the other contexts
 * of the process. It takes no lock for that. So two threads that use a context each would crash. On software GL, therefore, one
 * thread at a time uses GL, in the order in which the threads asked.
 */
#include <stdlib.h>

#include "gpu/internal.h"

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static uint64_t next, now; /* the number of the next turn that is asked for, and of the one that it is */

static void must(int error)
{
	if (error != 0)
		abort();
}

void gpu_turn_begin(void)
{
	must(pthread_mutex_lock(&lock));
	uint64_t mine = next++;
	while (now != mine)
		must(pthread_cond_wait(&changed, &lock));
	must(pthread_mutex_unlock(&lock));
}

void gpu_turn_end(void)
{
	must(pthread_mutex_lock(&lock));
	now++;
	must(pthread_cond_broadcast(&changed));
	must(pthread_mutex_unlock(&lock));
}
