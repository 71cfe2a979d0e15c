/*
 * Messages between the processes of one run: the only part of fleet that knows MPI. comm_none.c is used where MPI is not built in; there
 * is one process then.
 *
 * Call all functions from one thread, and functions that all ranks call together in the same order on every rank. After the start a failure
 * of MPI, or missing memory, ends all processes at once, since the others wait for this one. What was committed remains.
 */
#ifndef FURROW_FLEET_COMM_H
#define FURROW_FLEET_COMM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

/* Returns true if a launcher (mpirun, srun) has started this process as one of several. Reads only the environment. */
bool fleet_comm_launched(void);
/* Joins the other processes. STATUS_USAGE: MPI is not built in. */
enum status fleet_comm_start(int *rank, int *ranks) FURROW_CHECKED;
void fleet_comm_finish(void); /* all ranks together, also when the run failed */
/* Returns true on one rank of each machine. All ranks together. Also returns true if this process has not joined any. */
bool fleet_comm_first_here(void);
/* Ends all processes at once, and says why. */
_Noreturn void fleet_comm_give_up(const char *why);

/* Gives every rank's bytes to every rank. all[i]: those of rank i, sizes[i] bytes, valid until the next call. */
void fleet_comm_exchange(const void *bytes, size_t size, const void *const **all, const size_t **sizes);

/* A message from one rank to another. Of a pair of ranks at most one is under way. */
struct fleet_message {
	int rank;    /* the other one */
	void *bytes; /* of a message that comes: allocated by fleet_comm_move, to be freed with mem_free */
	size_t size;
};
/* Sends messages, and takes those that come, from the ranks that `in` names. */
void fleet_comm_move(const struct fleet_message *out, size_t out_count, struct fleet_message *in, size_t in_count);

#endif
