/*
 * ARC (Megiddo and Modha, 2003), its target a real number.
 *
 * T1: seen once lately, T2: more often; B1 and B2 remember what left them. A page that comes back
 * from B1 says that T1 should be larger, one from B2 that it should be smaller. Resident are T1 and
 * T2, at most `slots` together; with what is remembered they are at most twice that.
 */
#include "sim/internal.h"

#include <assert.h>
#include <math.h>

enum { T1, T2, B1, B2 };

/* All slots are taken. If T1 has them all, the target is less: B1 is empty then, so that it was not raised
 * just now, and a page from B2 lowered it. */
static void replace(struct sim_cache *cache, bool from_b2)
{
	double t1 = cache->queues[T1].count;
	bool first = t1 > 0 && (t1 > cache->target || (t1 == cache->target && from_b2));
	assert(cache->queues[first ? T1 : T2].count > 0);
	sim_add(cache, first ? B1 : B2, sim_take(cache, first ? T1 : T2));
}

/* Room for a page that is known nowhere. */
static void make_room(struct sim_cache *cache)
{
	const struct sim_queue *queues = cache->queues;
	uint64_t first = (uint64_t)queues[T1].count + queues[B1].count;
	uint64_t all = first + queues[T2].count + queues[B2].count;
	if (first + 1 > cache->slots && queues[B1].count == 0) {
		sim_take(cache, T1);
		return;
	}
	if (first + 1 > cache->slots)
		sim_take(cache, B1);
	else if (all >= 2 * (uint64_t)cache->slots && queues[B2].count > 0)
		sim_take(cache, B2);
	replace(cache, false);
}

bool sim_arc(struct sim_cache *cache, uint32_t page)
{
	double b1 = cache->queues[B1].count, b2 = cache->queues[B2].count;
	bool hit = sim_in(cache, T1, page) || sim_in(cache, T2, page);
	bool from_b1 = sim_in(cache, B1, page), from_b2 = sim_in(cache, B2, page);
	if (from_b1)
		cache->target = fmin(cache->target + fmax(b2 / b1, 1), cache->slots);
	if (from_b2)
		cache->target = fmax(cache->target - fmax(b1 / b2, 1), 0);
	if (hit || from_b1 || from_b2)
		sim_remove(cache, page);
	while (!hit && cache->queues[T1].count + cache->queues[T2].count >= cache->slots) {
		if (from_b1 || from_b2)
			replace(cache, from_b2);
		else
			make_room(cache);
	}
	sim_add(cache, hit || from_b1 || from_b2 ? T2 : T1, page);
	return hit;
}
