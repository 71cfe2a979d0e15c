/*
 * sim: how often page caches of other policies and sizes would have missed in a drive that was traced. An instrument: no part
 * of the library. Any thread.
 */
#ifndef FURROW_TOOLS_SIM_H
#define FURROW_TOOLS_SIM_H

#include "page/page.h"

/* A trace in memory: tiles by number, in the order in which they were first asked for. */
struct sim_accesses {
	size_t count;
	uint32_t *tiles; /* of each access: the tile's number */
	uint64_t *steps; /* of each access */
	uint32_t tile_count;
	uint64_t *keys;  /* of each tile */
	uint64_t hits[PAGE_ACCESS_KINDS], misses[PAGE_ACCESS_KINDS]; /* of the cache that was traced */
};

/* STATUS_INPUT if the file is missing, no trace, cut or damaged. */
enum status sim_accesses_read(const char *path, struct sim_accesses *out) FURROW_CHECKED;
/* The same of a file's bytes; `path` is for messages. */
enum status sim_accesses_parse(const char *path, const uint8_t *bytes, size_t size, struct sim_accesses *out) FURROW_CHECKED;
void sim_accesses_finish(struct sim_accesses *accesses);

/* --- simulation: how often other policies would have missed --- */

enum sim_policy { SIM_LRU, SIM_CLOCK, SIM_ARC, SIM_S3FIFO, SIM_OPT, SIM_POLICIES };
/* Below this many slots S3-FIFO keeps nothing: its small queue would hold one page or none. */
#define SIM_S3FIFO_SLOTS_MIN 20

/* Called now and then; another status than STATUS_OK ends the simulation with it. */
typedef enum status (*sim_progress_fn)(void *user, int64_t done, int64_t total);

/* The misses of `policy` with slots[i] slots (at least 1 each) into misses[i]: a cache that starts
 * empty, pins nothing, prefetches nothing, by libCacheSim's rules for objects of size 1.
 * `done` and `total` are accesses. Any thread. */
enum status sim_misses(const struct sim_accesses *accesses, enum sim_policy policy, const uint32_t *slots,
		     size_t count, sim_progress_fn progress, void *user,
		     uint64_t *misses) FURROW_CHECKED;

#endif
