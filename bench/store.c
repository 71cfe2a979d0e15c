/*
 * What a store costs on one thread: coding, decoding, reading and writing back tiles, beside GDAL
 * and LMDB on the same posts. JSON lines; store.py runs it over data and prints the table.
 *
 *   bench_store read STORE [COG...]   bench_store write [--figures FILE]   bench_store rollback   bench_store chain
 *   bench_store error EXACT OTHER     bench_store blocks RASTER
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bench.h"
#include "record.h"
#include "store_bench.h"

void bench_dunes(const char *path, uint32_t blocks)
{
	const struct dem_synth dunes = {
		.kind = DEM_SYNTH_DUNES, .width = blocks * BENCH_BLOCK + 1, .height = blocks * BENCH_BLOCK + 1, .spacing = 1, .relief = 20, .seed = 1,
	};
	bench_store(path, &dunes, BENCH_BLOCK);
}

/* This thread's own: nothing here waits, and another program's turn is not counted. */
static double thread_seconds(void)
{
	struct timespec now;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
	return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double pass(const struct bench_row *row, size_t count, size_t times)
{
	double began = thread_seconds();
	for (size_t time = 0; time < times; time++)
		for (size_t i = 0; i < count; i++)
			row->once(row->user, i);
	return thread_seconds() - began;
}

void bench_rows(struct bench_row *rows, size_t row_count, size_t count, int runs, double seconds)
{
	for (int run = 0; run < runs; run++)
		for (size_t i = 0; i < row_count; i++) {
			/* The first pass warms and says how many fill the time. */
			double once = pass(&rows[i], count, 1);
			size_t times = once > seconds ? 1 : (size_t)(seconds / (once + 1e-9)) + 1;
			rows[i].rates[run] = (double)(times * count) / pass(&rows[i], count, times);
		}
}

struct tile *bench_tiles(const struct extent *extent, size_t most, size_t *count)
{
	uint32_t wide = (uint32_t)(extent->width / BENCH_BLOCK), high = (uint32_t)(extent->height / BENCH_BLOCK);
	if (extent->cells != BENCH_BLOCK)
		bench_must(fail_with(STATUS_INPUT, "bench: tiles are not of %d cells; import with --tile %d",
				     BENCH_BLOCK, BENCH_BLOCK));
	if (wide == 0 || high == 0) {
		wide = extent_tiles_x(extent, 0);
		high = extent_tiles_y(extent, 0);
	}
	size_t all = (size_t)wide * high;
	struct tile *tiles = mem_alloc(all, sizeof *tiles);
	if (tiles == NULL)
		bench_must(fail_memory("tiles"));
	for (size_t i = 0; i < all; i++)
		tiles[i] = (struct tile){0, (uint32_t)(i % wide), (uint32_t)(i / wide)};
	uint64_t random = 0x9e3779b97f4a7c15u;
	for (size_t i = all - 1; i > 0; i--) {
		random = random * 6364136223846793005u + 1442695040888963407u;
		size_t other = (size_t)((random >> 33) % (i + 1));
		struct tile tile = tiles[i];
		tiles[i] = tiles[other];
		tiles[other] = tile;
	}
	*count = all < most ? all : most;
	return tiles;
}

static int usage(void)
{
	fputs("usage: bench_store [--runs N] read STORE [COG...] | write [--figures FILE] | rollback | chain | error EXACT OTHER | blocks RASTER\n", stderr);
	return 2;
}

int main(int argc, char **argv)
{
	int runs = 5;
	const int at = argc > 2 && strcmp(argv[1], "--runs") == 0 ? 3 : 1;
	if (at < argc && strcmp(argv[at], "write") == 0) /* the others leave no figures */
		bench_record_begin("store_write", &argc, argv);
	argv++;
	argc--;
	if (argc >= 2 && strcmp(argv[0], "--runs") == 0) {
		runs = atoi(argv[1]);
		argv += 2;
		argc -= 2;
	}
	if (runs < 1 || runs > BENCH_RUNS_MAX || argc < 1)
		return usage();
	if (strcmp(argv[0], "read") == 0 && argc >= 2)
		return bench_read(argv[1], argv + 2, argc - 2, runs);
	if (strcmp(argv[0], "write") == 0 && argc == 1) {
		bench_write(runs);
		bench_record_end(NULL);
		return 0;
	}
	if (strcmp(argv[0], "rollback") == 0 && argc == 1)
		return bench_rollback();
	if (strcmp(argv[0], "chain") == 0 && argc == 1)
		return bench_chain(runs);
	if (strcmp(argv[0], "error") == 0 && argc == 3)
		return bench_error(argv[1], argv[2]);
	if (strcmp(argv[0], "blocks") == 0 && argc == 2)
		return bench_blocks(argv[1]);
	return usage();
}
