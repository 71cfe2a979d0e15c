/* One process: MPI is not built in. */
#include <stdio.h>
#include <stdlib.h>

#include "fleet/comm.h"

bool fleet_comm_launched(void)
{
	const char *ranks = getenv("OMPI_COMM_WORLD_SIZE"), *other = getenv("PMI_SIZE");
	return (ranks != NULL && atoi(ranks) > 1) || (other != NULL && atoi(other) > 1);
}

enum status fleet_comm_start(int *rank, int *ranks)
{
	*rank = 0;
	*ranks = 1;
	return fail_with(STATUS_USAGE, "drive: it was started as one of several processes, and this furrow has no MPI; build it with -Dmpi=enabled");
}

void fleet_comm_finish(void)
{
}

bool fleet_comm_first_here(void)
{
	return true;
}

void fleet_comm_give_up(const char *why)
{
	fprintf(stderr, "furrow: %s\n", why);
	abort();
}

void fleet_comm_exchange(const void *bytes, size_t size, const void *const **all, const size_t **sizes)
{
	static const void *one[1];
	static size_t one_size[1];
	one[0] = bytes;
	one_size[0] = size;
	*all = one;
	*sizes = one_size;
}

void fleet_comm_move(const struct fleet_message *out, size_t out_count, struct fleet_message *in, size_t in_count)
{
	(void)out, (void)out_count, (void)in, (void)in_count; /* there is no other rank */
}
