/*
 * S3-FIFO (Yang and others, 2023), as libCacheSim has it since October 2024: a tenth of the slots is a
 * small queue, what was used twice in it goes to the main one, what was not is remembered; and until
 * anything is evicted, what finds the small queue full goes to the main one at once. (From then on the
 * main queue never has less than its nine tenths, so that the small one has room after an eviction.)
 *
 * A page is taken into the small queue only if that has more than one slot: with fewer than
 * SIM_S3FIFO_SLOTS_MIN slots in all, nothing ever is.
 */
#include "sim/internal.h"

enum { SMALL, MAIN, GHOST };
#define USES_TO_MAIN 2
#define USES_MOST 3

static uint32_t share(const struct sim_cache *cache, double part)
{
	return (uint32_t)(cache->slots * part);
}

static void add_main(struct sim_cache *cache, uint32_t page, uint8_t uses)
{
	cache->pages[page].uses = uses;
	sim_add(cache, MAIN, page);
}

static void remember(struct sim_cache *cache, uint32_t page)
{
	uint32_t room = share(cache, 0.90);
	while (cache->queues[GHOST].count >= room)
		sim_take(cache, GHOST);
	sim_add(cache, GHOST, page);
}

static void evict_small(struct sim_cache *cache)
{
	while (cache->queues[SMALL].count > 0) {
		uint32_t oldest = sim_take(cache, SMALL);
		if (cache->pages[oldest].uses < USES_TO_MAIN) {
			remember(cache, oldest);
			return;
		}
		add_main(cache, oldest, 0);
	}
}

static void evict_main(struct sim_cache *cache)
{
	while (cache->queues[MAIN].count > 0) {
		uint32_t oldest = sim_take(cache, MAIN);
		uint8_t uses = cache->pages[oldest].uses;
		if (uses == 0)
			return;
		add_main(cache, oldest, uses - 1);
	}
}

bool sim_s3fifo(struct sim_cache *cache, uint32_t page)
{
	const struct sim_queue *queues = cache->queues;
	struct sim_page *at = &cache->pages[page];
	uint32_t small = share(cache, 0.10);
	if (sim_in(cache, SMALL, page) || sim_in(cache, MAIN, page)) {
		at->uses += at->uses < USES_MOST;
		return true;
	}
	bool remembered = sim_in(cache, GHOST, page);
	if (remembered)
		sim_remove(cache, page);
	if (cache->slots < SIM_S3FIFO_SLOTS_MIN)
		return false;
	while (queues[SMALL].count + queues[MAIN].count >= cache->slots) {
		if (queues[MAIN].count > cache->slots - small || queues[SMALL].count == 0)
			evict_main(cache);
		else
			evict_small(cache);
	}
	if (remembered || queues[SMALL].count >= small) {
		add_main(cache, page, 0);
	} else {
		at->uses = 0;
		sim_add(cache, SMALL, page);
	}
	return false;
}
