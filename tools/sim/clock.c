/*
 * CLOCK, as first in, first out with reinsertion: a page that was used since it came, or since the
 * hand last passed it, gets another round.
 */
#include "sim/internal.h"

bool sim_clock(struct sim_cache *cache, uint32_t page)
{
	if (sim_in(cache, 0, page)) {
		cache->pages[page].uses = 1;
		return true;
	}
	while (cache->queues[0].count >= cache->slots) {
		uint32_t oldest = sim_take(cache, 0);
		if (cache->pages[oldest].uses == 0)
			continue;
		cache->pages[oldest].uses = 0;
		sim_add(cache, 0, oldest);
	}
	sim_add(cache, 0, page); /* unused: it is new, or left unused */
	return false;
}
