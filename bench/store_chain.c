/*
 * Reads of deformed tiles: from one store, from chains of 1, 2, 4, 8 and 16 overlays in which each file has its share of the same
 * tiles, and how long it takes to open each.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench.h"
#include "store/store.h"
#include "store_bench.h"

#define LEVEL (-3)
#define SIDE 16 /* tiles a side at LEVEL */
#define TILES (SIDE * SIDE)
#define POSTS ((BENCH_BLOCK + 1) * (BENCH_BLOCK + 1))
#define CHAINS 6 /* of 0 (the one store), 1, 2, 4, 8, 16 overlays */

struct reading {
	struct store *store;
	struct store_reader *reader;
	int32_t *posts;
	double opening; /* ms */
};

/* Two ruts across the tile. The ground between them is as it was. */
static void fill(int32_t *posts, int number)
{
	for (int i = 0; i < POSTS; i++) {
		int x = i % (BENCH_BLOCK + 1), y = i / (BENCH_BLOCK + 1);
		double across = fabs(fabs(y - 128 - 8 * sin(x / 40.0 + number)) - 12);
		double depth = across < 4 ? 0.08 + 0.02 * sin(x * 0.3 + number) + 0.01 * cos(y * 1.7) : 0;
		posts[i] = (int32_t)lround(ldexp(-depth, 20));
	}
}

/* Commits every `of`th tile, from `first`. */
static void drive(struct store *store, int first, int of, int32_t *posts)
{
	struct store_commit_result result;
	struct store_run run = {.scene_hash = "00", .state = "{}"};
	bench_must(store_set_working_level(store, LEVEL));
	for (int i = first; i < TILES; i += of) {
		struct store_page page = {.tile = {LEVEL, (uint32_t)i % SIDE, (uint32_t)i / SIDE}, .planes = {[PLANE_OFFSET] = posts}};
		fill(posts, i + of);
		bench_must(store_commit(store, &page, 1, &run, &result));
	}
}

static void make(struct reading *reading, const char *base, int depth)
{
	char path[512], under[512];
	snprintf(under, sizeof under, "%s", base);
	for (int i = 1; i <= depth; i++) {
		snprintf(path, sizeof path, "%s-%d-%d", base, depth, i);
		bench_must(store_create_overlay(path, under));
		struct store *store;
		bench_must(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store));
		drive(store, i - 1, depth, reading->posts);
		store_close(store);
		snprintf(under, sizeof under, "%s", path);
	}
	double began = clock_seconds();
	bench_must(store_open(under, &(struct store_options){.mode = STORE_READ}, &reading->store));
	bench_must(store_reader_create(reading->store, &reading->reader));
	reading->opening = (clock_seconds() - began) * 1e3;
}

static void once(void *user, size_t i)
{
	struct reading *reading = user;
	void *planes[PLANES] = {[PLANE_OFFSET] = reading->posts};
	unsigned present;
	bench_must(store_read_deformed(reading->reader, (struct tile){LEVEL, (uint32_t)i % SIDE, (uint32_t)i / SIDE},
				       PLANE_BIT(PLANE_OFFSET), planes, &present));
	if (present == 0)
		bench_must(fail_with(STATUS_FAILED, "bench: a tile of the chain is missing; this is a bug"));
}

int bench_chain(int runs)
{
	static const int depths[CHAINS] = {0, 1, 2, 4, 8, 16};
	static struct reading readings[CHAINS];
	static struct bench_row rows[CHAINS];
	const char *base = bench_path("chain.furrow");
	bench_dunes(base, SIDE / 8);
	for (int i = 0; i < CHAINS; i++) {
		readings[i].posts = mem_alloc(POSTS, sizeof *readings[i].posts);
		if (readings[i].posts == NULL)
			bench_must(fail_memory("a tile"));
	}
	/* The plain store is driven first, so that every overlay inherits all of its tiles. */
	struct store *store;
	bench_must(store_open(base, &(struct store_options){.mode = STORE_WRITE}, &store));
	drive(store, 0, 1, readings[0].posts);
	store_close(store);
	for (int i = 0; i < CHAINS; i++) {
		make(&readings[i], base, depths[i]);
		rows[i] = (struct bench_row){.name = "chain", .subject = "", .once = once, .user = &readings[i], .bytes = POSTS * 4.0};
	}
	bench_rows(rows, CHAINS, TILES, runs, 0.3);
	for (int i = 0; i < CHAINS; i++) {
		double ratios[BENCH_RUNS_MAX];
		for (int run = 0; run < runs; run++)
			ratios[run] = rows[0].rates[run] / rows[i].rates[run];
		printf("{\"bench\": \"store\", \"row\": \"chain\", \"overlays\": %d, \"tiles\": %d, \"open_ms\": %.2f, \"read_us\": %.1f, "
		       "\"times_one_store\": %.3f}\n", depths[i], TILES, readings[i].opening, 1e6 / bench_median(rows[i].rates, (size_t)runs),
		       bench_median(ratios, (size_t)runs));
		store_reader_destroy(readings[i].reader);
		store_close(readings[i].store);
		mem_free(readings[i].posts);
	}
	return 0;
}
