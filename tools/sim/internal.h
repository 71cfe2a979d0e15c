/*
 * What the simulated policies share: pages in linked queues, and the run over a trace.
 *
 * A page is its tile's number; it is in at most one queue, resident in it or remembered (a ghost).
 */
#ifndef FURROW_TOOLS_SIM_INTERNAL_H
#define FURROW_TOOLS_SIM_INTERNAL_H

#include "sim/sim.h"

#define SIM_NONE UINT32_MAX
#define SIM_QUEUES 4

struct sim_page {
	uint32_t newer, older;
	uint8_t queue; /* its index + 1; 0: in none */
	uint8_t uses;  /* CLOCK, S3-FIFO */
};

struct sim_queue {
	uint32_t newest, oldest, count;
};

struct sim_cache {
	uint32_t slots;
	struct sim_page *pages;
	struct sim_queue queues[SIM_QUEUES];
	double target; /* ARC: how many of the slots are T1's */
};

/* One access: true for a hit. */
typedef bool (*sim_access_fn)(struct sim_cache *cache, uint32_t page);
bool sim_clock(struct sim_cache *cache, uint32_t page);
bool sim_arc(struct sim_cache *cache, uint32_t page);
bool sim_s3fifo(struct sim_cache *cache, uint32_t page);

struct sim_run {
	const struct sim_accesses *accesses;
	sim_progress_fn progress;
	void *user;
	size_t passes, pass; /* over the trace: how many in all, how many are done */
};
/* All sizes in one pass; and a pass a size. */
enum status sim_lru(struct sim_run *run, const uint32_t *slots, size_t count, uint64_t *misses) FURROW_CHECKED;
enum status sim_opt(struct sim_run *run, const uint32_t *slots, size_t count, uint64_t *misses) FURROW_CHECKED;

/* Before access i of a pass. */
static inline enum status sim_tick(const struct sim_run *run, size_t i)
{
	int64_t total = (int64_t)run->accesses->count;
	return (i & 0xffff) != 0 ? STATUS_OK
				 : run->progress(run->user, (int64_t)run->pass * total + (int64_t)i,
						 (int64_t)run->passes * total);
}

static inline bool sim_in(const struct sim_cache *cache, int queue, uint32_t page)
{
	return cache->pages[page].queue == queue + 1;
}

static inline void sim_add(struct sim_cache *cache, int queue, uint32_t page)
{
	struct sim_queue *to = &cache->queues[queue];
	struct sim_page *at = &cache->pages[page];
	at->queue = (uint8_t)(queue + 1);
	at->newer = SIM_NONE;
	at->older = to->newest;
	*(to->count > 0 ? &cache->pages[to->newest].newer : &to->oldest) = page;
	to->newest = page;
	to->count++;
}

static inline void sim_remove(struct sim_cache *cache, uint32_t page)
{
	struct sim_page *at = &cache->pages[page];
	struct sim_queue *from = &cache->queues[at->queue - 1];
	*(at->newer != SIM_NONE ? &cache->pages[at->newer].older : &from->newest) = at->older;
	*(at->older != SIM_NONE ? &cache->pages[at->older].newer : &from->oldest) = at->newer;
	at->queue = 0;
	from->count--;
}

/* The oldest of a queue that is not empty. */
static inline uint32_t sim_take(struct sim_cache *cache, int queue)
{
	uint32_t page = cache->queues[queue].oldest;
	sim_remove(cache, page);
	return page;
}

#endif
