/*
 * Rollbacks: 50 pages of 256 x 256 posts with a rut across each (offset and the soil's state), committed in two epochs after
 * a mark, and rolled back; and what a mark adds to an epoch.
 */
#include <math.h>
#include <stdio.h>

#include "bench.h"
#include "store/store.h"
#include "store_bench.h"

#define LEVEL (-3)
#define SIDE 16
#define PAGES 50
#define POSTS ((BENCH_BLOCK + 1) * (BENCH_BLOCK + 1))
#define ROUNDS 100

struct soil {
	int32_t offset[POSTS], heaped[POSTS], pressed[POSTS], shear[POSTS], dug[POSTS];
};

static void fill(struct soil *soil, struct store_page *page, int number, int round)
{
	for (int i = 0; i < POSTS; i++) {
		int x = i % (BENCH_BLOCK + 1), y = i / (BENCH_BLOCK + 1);
		double across = fabs(y - 100 - 10 * sin(x / 30.0 + number));
		double depth = across < 12 ? 0.08 + 0.02 * sin(x * 0.3 + round) : 0;
		double heap = across >= 12 && across < 24 ? 0.03 * sin((across - 12) / 12 * M_PI) : 0;
		soil->offset[i] = (int32_t)lround(ldexp(heap - depth, 20));
		soil->heaped[i] = (int32_t)lround(ldexp(heap, 20));
		soil->pressed[i] = (int32_t)lround(ldexp(depth, 20));
		soil->dug[i] = soil->pressed[i] / 8;
		soil->shear[i] = (int32_t)lround(ldexp(depth * 4, 15)); /* as under a wheel that is 12 m long */
	}
	*page = (struct store_page){.tile = {LEVEL, (uint32_t)number % 10, (uint32_t)number / 10}};
	page->planes[PLANE_OFFSET] = soil->offset;
	page->planes[PLANE_DEPOSITED] = soil->heaped;
	page->planes[PLANE_PLASTIC_SINKAGE] = soil->pressed;
	page->planes[PLANE_SHEAR] = soil->shear;
	page->planes[PLANE_DUG] = soil->dug;
}

/* Milliseconds. */
static double commit(struct store *store, const struct store_page *pages, int round)
{
	struct store_run run = {.scene_hash = "00", .step = round + 1, .time = round, .state = "{}"};
	struct store_commit_result result;
	double began = clock_seconds();
	for (int half = 0; half < 2; half++) {
		bench_must(store_commit(store, pages + half * (PAGES / 2), PAGES / 2, &run, &result));
		bench_must(store_bound_wal(store));
	}
	return (clock_seconds() - began) * 1e3;
}

static double rollback(struct store *store)
{
	double began = clock_seconds();
	bench_must(store_rollback(store));
	bench_must(store_bound_wal(store));
	return (clock_seconds() - began) * 1e3;
}

int bench_rollback(void)
{
	struct store *store = NULL;
	static struct store_page pages[PAGES];
	static double plain[ROUNDS], marked[ROUNDS], back[ROUNDS];
	uint64_t before, after;
	struct soil *soils = mem_alloc(PAGES, sizeof *soils);
	if (soils == NULL)
		bench_must(fail_memory("pages"));
	const char *path = bench_path("rollback.furrow");
	bench_dunes(path, SIDE / 8);
	bench_must(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store));
	bench_must(store_set_working_level(store, LEVEL));
	for (int round = -1; round < ROUNDS; round++) {
		for (int i = 0; i < PAGES; i++)
			fill(&soils[i], &pages[i], i, round);
		double ms = commit(store, pages, round + 1);
		if (round >= 0)
			plain[round] = ms;
	}
	bench_must(store_mark(store));
	bench_must(store_content_hash(store, &before));
	for (int round = 0; round < ROUNDS; round++) {
		for (int i = 0; i < PAGES; i++)
			fill(&soils[i], &pages[i], i, ROUNDS + round);
		marked[round] = commit(store, pages, round);
		back[round] = rollback(store);
	}
	bench_must(store_content_hash(store, &after));
	if (before != after)
		bench_must(fail_with(STATUS_FAILED, "bench: a rollback left other rows; this is a bug"));
	printf("{\"bench\": \"store\", \"row\": \"rollback\", \"pages\": %d, \"epochs_ms\": %.2f, \"epochs_marked_ms\": %.2f, "
	       "\"rollback_ms\": %.2f}\n", PAGES, bench_median(plain, ROUNDS), bench_median(marked, ROUNDS),
	       bench_median(back, ROUNDS));
	store_close(store);
	mem_free(soils);
	return 0;
}
