/* Messages by MPI. */
#include <limits.h>
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fleet/comm.h"
#include "fleet/watch.h"

#define INLINE_BYTES 504 /* bytes of an exchange that go with its first message. More need a second one */
#define TAG 7
/* s of waiting for the others until it is told */
#define STARTS 10.0
#define WAITS 30.0

struct first {
	uint64_t size;
	char bytes[INLINE_BYTES];
};

static struct {
	MPI_Comm comm;
	int rank, ranks;
	struct first *firsts;
	char *rest;
	size_t rest_room;
	const void **all;
	size_t *sizes;
	int *counts, *places;
} at;

bool fleet_comm_launched(void)
{
	/* Open MPI; MPICH, Intel MPI and srun; srun with PMIx */
	const char *const names[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", getenv("PMIX_RANK") != NULL ? "SLURM_STEP_NUM_TASKS" : "PMI_SIZE"};
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		const char *text = getenv(names[i]);
		if (text != NULL && atoi(text) > 1)
			return true;
	}
	return false;
}

/* Ends all ranks: the others wait for this one, and it cannot go on. What was committed remains. */
static _Noreturn void give_up(const char *what, const char *why)
{
	fprintf(stderr, "furrow: rank %d: %s: %s; drive on with --resume from the last commit\n", at.rank, what, why);
	MPI_Abort(at.comm, 1);
	abort();
}

void fleet_comm_give_up(const char *why)
{
	give_up("ranks", why);
}

static void check(const char *what, int error)
{
	char text[MPI_MAX_ERROR_STRING] = "";
	int length = 0;
	if (error == MPI_SUCCESS)
		return;
	MPI_Error_string(error, text, &length);
	give_up(what, text);
}

static void *need(void *memory, const char *what)
{
	if (memory == NULL)
		give_up(what, "out of memory");
	return memory;
}

/* A process that waits in a loop takes the processor from the one that it waits for, where there are more processes than processors. */
static void yield_when_idle(void)
{
	const char *local = getenv("OMPI_COMM_WORLD_LOCAL_SIZE");
	if (local != NULL && atoi(local) >= sysconf(_SC_NPROCESSORS_ONLN))
		setenv("OMPI_MCA_mpi_yield_when_idle", "1", 0);
}

/* The rank that the launcher gave to this process; 0: it does not say. */
static int rank_given(void)
{
	const char *const names[] = {"OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK"};
	for (size_t i = 0; i < sizeof names / sizeof *names; i++)
		if (getenv(names[i]) != NULL)
			return atoi(getenv(names[i]));
	return 0;
}

enum status fleet_comm_start(int *rank, int *ranks)
{
	int given;
	yield_when_idle();
	if (rank_given() <= 1)
		fleet_watch_start();
	if (rank_given() == 0)
		fleet_watch_begin(-1, STARTS);
	int error = MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &given);
	fleet_watch_end();
	if (error != MPI_SUCCESS || given < MPI_THREAD_FUNNELED)
		return fail_with(STATUS_FAILED, "MPI: it does not start, or not for a program with threads; try mpirun -n 2 hostname");
	error = MPI_Comm_dup(MPI_COMM_WORLD, &at.comm);
	if (error == MPI_SUCCESS)
		error = MPI_Comm_set_errhandler(at.comm, MPI_ERRORS_RETURN);
	if (error != MPI_SUCCESS)
		return fail_with(STATUS_FAILED, "MPI: the ranks do not find each other; try mpirun -n 2 hostname");
	MPI_Comm_rank(at.comm, &at.rank);
	MPI_Comm_size(at.comm, &at.ranks);
	const size_t count = (size_t)at.ranks;
	at.firsts = mem_calloc(count, sizeof *at.firsts);
	at.all = mem_calloc(count, sizeof *at.all);
	at.sizes = mem_calloc(count, sizeof *at.sizes);
	at.counts = mem_calloc(count, sizeof *at.counts);
	at.places = mem_calloc(count, sizeof *at.places);
	*rank = at.rank;
	*ranks = at.ranks;
	TRY_MEM(at.firsts != NULL && at.all != NULL && at.sizes != NULL && at.counts != NULL && at.places != NULL, "ranks");
	return STATUS_OK;
}

void fleet_comm_finish(void)
{
	int begun = 0;
	MPI_Initialized(&begun);
	fleet_watch_begin(at.rank, WAITS);
	if (begun && at.ranks > 0)
		MPI_Barrier(at.comm); /* MPI_Finalize need not wait for the others */
	if (begun)
		MPI_Finalize();
	fleet_watch_finish();
	mem_free_all(at.firsts, at.rest, at.all, at.sizes, at.counts, at.places);
	memset(&at, 0, sizeof at);
}

bool fleet_comm_first_here(void)
{
	MPI_Comm here;
	int number = 0;
	if (at.ranks == 0)
		return true;
	check("ranks of one machine", MPI_Comm_split_type(at.comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here));
	check("ranks of one machine", MPI_Comm_rank(here, &number));
	check("ranks of one machine", MPI_Comm_free(&here));
	return number == 0;
}

/* --- exchanges --- */

/* Gives what does not fit into the first messages. */
static void exchange_rest(const void *bytes, size_t size)
{
	size_t total = 0;
	for (int i = 0; i < at.ranks; i++) {
		const size_t more = at.sizes[i] > INLINE_BYTES ? at.sizes[i] : 0;
		if (more > INT_MAX - total)
			give_up("exchange", "ranks have more than 2 GB to tell each other in one step");
		at.counts[i] = (int)more;
		at.places[i] = (int)total;
		total += more;
	}
	if (total > at.rest_room) {
		at.rest = need(mem_realloc(at.rest, total, 1), "exchange");
		at.rest_room = total;
	}
	check("exchange", MPI_Allgatherv(bytes, size > INLINE_BYTES ? (int)size : 0, MPI_BYTE, at.rest, at.counts, at.places, MPI_BYTE, at.comm));
	for (int i = 0; i < at.ranks; i++)
		if (at.counts[i] > 0)
			at.all[i] = at.rest + at.places[i];
}

void fleet_comm_exchange(const void *bytes, size_t size, const void *const **all, const size_t **sizes)
{
	struct first first = {.size = size};
	bool rest = false;
	if (size > 0)
		memcpy(first.bytes, bytes, size < INLINE_BYTES ? size : INLINE_BYTES);
	fleet_watch_begin(at.rank, WAITS);
	check("exchange", MPI_Allgather(&first, sizeof first, MPI_BYTE, at.firsts, sizeof first, MPI_BYTE, at.comm));
	for (int i = 0; i < at.ranks; i++) {
		at.all[i] = at.firsts[i].bytes;
		at.sizes[i] = (size_t)at.firsts[i].size;
		rest = rest || at.sizes[i] > INLINE_BYTES;
	}
	if (rest)
		exchange_rest(bytes, size);
	fleet_watch_end();
	*all = at.all;
	*sizes = at.sizes;
}

/* --- messages --- */

static void take(struct fleet_message *in)
{
	MPI_Message message;
	MPI_Status came;
	int size = 0;
	check("message", MPI_Mprobe(in->rank, TAG, at.comm, &message, &came));
	check("message", MPI_Get_count(&came, MPI_BYTE, &size));
	in->size = (size_t)size;
	in->bytes = need(mem_alloc(in->size > 0 ? in->size : 1, 1), "message");
	check("message", MPI_Mrecv(in->bytes, size, MPI_BYTE, &message, MPI_STATUS_IGNORE));
}

void fleet_comm_move(const struct fleet_message *out, size_t out_count, struct fleet_message *in, size_t in_count)
{
	fleet_watch_begin(at.rank, WAITS);
	MPI_Request *requests = need(mem_alloc(out_count > 0 ? out_count : 1, sizeof *requests), "message");
	for (size_t i = 0; i < out_count; i++) {
		if (out[i].size > INT_MAX)
			give_up("message", "more than 2 GB of ground would move between two ranks in one step");
		check("message", MPI_Isend(out[i].bytes, (int)out[i].size, MPI_BYTE, out[i].rank, TAG, at.comm, &requests[i]));
	}
	for (size_t i = 0; i < in_count; i++)
		take(&in[i]);
	check("message", MPI_Waitall((int)out_count, requests, MPI_STATUSES_IGNORE));
	fleet_watch_end();
	mem_free(requests);
}
