/*
 * Simulation of a policy over a trace, at many sizes.
 *
 * The rules are those of libCacheSim (as of 2024 to 2026) where objects have size 1, so that its
 * counts and these may be compared: a miss first makes room, then inserts, and what is inserted is no
 * victim of its own insertion. CLOCK, ARC and S3-FIFO take a pass a size.
 */
#include "sim/internal.h"

#include <assert.h>

static enum status one_size(struct sim_run *run, sim_access_fn access, uint32_t slots, uint64_t *misses)
{
	const struct sim_accesses *accesses = run->accesses;
	struct sim_cache cache = {.slots = slots};
	for (int i = 0; i < SIM_QUEUES; i++)
		cache.queues[i] = (struct sim_queue){SIM_NONE, SIM_NONE, 0};
	TRY(mem_zeroed(&cache.pages, (size_t)accesses->tile_count + 1, sizeof *cache.pages, "the simulated cache"));
	enum status status = STATUS_OK;
	*misses = 0;
	for (size_t i = 0; i < accesses->count; i++) {
		TRY_OR(done, sim_tick(run, i));
		*misses += !access(&cache, accesses->tiles[i]);
	}
done:
	mem_free(cache.pages);
	return status;
}

enum status sim_misses(const struct sim_accesses *accesses, enum sim_policy policy, const uint32_t *slots,
		     size_t count, sim_progress_fn progress, void *user, uint64_t *misses)
{
	static const sim_access_fn access[SIM_POLICIES] = {
		[SIM_CLOCK] = sim_clock,
		[SIM_ARC] = sim_arc,
		[SIM_S3FIFO] = sim_s3fifo,
	};
	struct sim_run run = {accesses, progress, user, policy == SIM_LRU ? 1 : count, 0};
	for (size_t i = 0; i < count; i++)
		assert(slots[i] >= 1);
	if (policy == SIM_LRU)
		return sim_lru(&run, slots, count, misses);
	if (policy == SIM_OPT)
		return sim_opt(&run, slots, count, misses);
	for (; run.pass < count; run.pass++)
		TRY(one_size(&run, access[policy], slots[run.pass], &misses[run.pass]));
	return STATUS_OK;
}
