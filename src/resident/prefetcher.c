/*
 * The threads of a prefetcher. Each has its part of the bodies, neighbours in the scene's order, and of the tiles. The first also has
 * the camera and the ranges. They share the ground, which lets any number of threads load, and see each other's last lists.
 */
#include "resident/prefetcher.h"

#include <assert.h>

#include "resident/prefetch_thread.h"

enum { BODIES_A_THREAD = 128, THREADS_MOST = 8 };

struct prefetcher {
	struct inset_areas insets;
	struct prefetch_thread *threads[THREADS_MOST];
	size_t count;
};

unsigned resident_look_ahead_threads(double prefetch, size_t count)
{
	if (prefetch <= 0 || count == 0)
		return 0;
	const size_t wanted = (count + BODIES_A_THREAD - 1) / BODIES_A_THREAD, cores = (size_t)thread_cores();
	const size_t threads = wanted < cores ? wanted : cores;
	return threads < THREADS_MOST ? (unsigned)threads : THREADS_MOST;
}

void resident_look_ahead_plan(double prefetch, size_t count, const char *effect, struct plan *plan)
{
	const unsigned threads = resident_look_ahead_threads(prefetch, count);
	if (threads > 0)
		plan_add(plan, &(struct plan_line){.kind = PLAN_THREAD, .effect = effect, .object = -1, .amount = threads}, PREFETCH_THREAD);
}

/* Returns where the part of thread `i` of `all` begins, of `count`. */
static size_t part(size_t count, size_t i, size_t all)
{
	return count * i / all;
}

enum status resident_prefetcher_create(const struct look_ahead_params *params, struct prefetcher **out)
{
	assert(params->count >= 1 && params->prefetch > 0);
	size_t threads = params->threads > 0 ? params->threads : resident_look_ahead_threads(params->prefetch, params->count);
	threads = threads < params->count ? threads : params->count;
	threads = threads < params->tiles ? threads : params->tiles;
	assert(threads >= 1 && threads <= THREADS_MOST);
	struct prefetcher *prefetcher = mem_calloc(1, sizeof *prefetcher);
	TRY_MEM(prefetcher, "the prefetcher");
	enum status status;
	TRY_OR(failed, resident_inset_areas_init(params->store, &prefetcher->insets));
	for (size_t i = 0; i < threads; i++) {
		struct look_ahead_params own = *params;
		const size_t first = part(params->count, i, threads);
		own.bodies = params->bodies + first;
		own.count = part(params->count, i + 1, threads) - first;
		own.tiles = (uint32_t)(part(params->tiles, i + 1, threads) - part(params->tiles, i, threads));
		if (i > 0)
			own.camera = NULL;
		TRY_OR(failed, resident_prefetch_thread_create(&own, &prefetcher->insets, &prefetcher->threads[i]));
		prefetcher->count++;
	}
	for (size_t i = 0; i < threads; i++)
		TRY_OR(failed, resident_prefetch_thread_start(prefetcher->threads[i], prefetcher->threads, threads));
	*out = prefetcher;
	return STATUS_OK;
failed:
	resident_prefetcher_destroy(prefetcher);
	return status;
}

void resident_prefetcher_destroy(struct prefetcher *prefetcher)
{
	if (prefetcher == NULL)
		return;
	for (size_t i = 0; i < prefetcher->count; i++)
		resident_prefetch_thread_stop(prefetcher->threads[i]);
	for (size_t i = 0; i < prefetcher->count; i++)
		resident_prefetch_thread_destroy(prefetcher->threads[i]);
	resident_inset_areas_finish(&prefetcher->insets);
	mem_free(prefetcher);
}

void resident_prefetcher_reach(struct prefetcher *prefetcher, double seconds)
{
	for (size_t i = 0; i < prefetcher->count; i++)
		resident_prefetch_thread_reach(prefetcher->threads[i], seconds);
}

void resident_prefetcher_tell(struct prefetcher *prefetcher, double time)
{
	for (size_t i = 0; i < prefetcher->count; i++)
		resident_prefetch_thread_tell(prefetcher->threads[i], time);
}

void resident_prefetcher_ranges(struct prefetcher *prefetcher, const struct ground_range_key *keys, size_t count)
{
	resident_prefetch_thread_ranges(prefetcher->threads[0], keys, count);
}

uint64_t resident_prefetcher_ranges_done(struct prefetcher *prefetcher)
{
	return resident_prefetch_thread_ranges_done(prefetcher->threads[0]);
}

void resident_prefetcher_wait(struct prefetcher *prefetcher)
{
	for (size_t i = 0; i < prefetcher->count; i++)
		resident_prefetch_thread_wait(prefetcher->threads[i]);
}
