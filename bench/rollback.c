/*
 * Measures rollbacks by furrow.h, as reinforcement learning makes them. Under scm, balls change 50 tiles of 256 cells, with forced
 * commits in between. Then the world goes back to its checkpoint. Prints the median and the worst time of ROLLBACKS rollbacks; the
 * default is 1000.
 *
 *     LP_NUM_THREADS=0 bench_rollback [ROLLBACKS]
 *
 * After the last rollback the ground is compared with that of the checkpoint.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/library.h"
#include "bench.h"
#include "world/made.h"

enum { CELLS = 256, COLUMNS = 10, ROWS = 5, TILES = COLUMNS * ROWS, FORCED = 2 };
#define SPACING 0.125 /* m, of the working level, which is that of the store */
#define RADIUS 0.5    /* m */

static const char scene[] =
	"{\"scene\": 1, \"time_step\": 0.01, \"soil\": {\"name\": \"dry_sand\"}, \"redistribute\": {\"model\": \"scm\"}, \"cache\": {\"slots\": 128}}";

static void must(furrow_status status)
{
	if (status == FURROW_OK)
		return;
	fprintf(stderr, "bench_rollback: %s\n", furrow_last_error());
	exit(1);
}

static struct furrow_world *open_world(const char *store)
{
	struct furrow_world *world;
	const struct furrow_open open = {.size = sizeof open, .scene = scene, .store = store};
	must(furrow_world_open(&open, &world));
	return world;
}

/* A ball in the middle of each tile, pressed in by a tenth of a metre. */
static void press(struct furrow_world *world, const furrow_body balls[TILES])
{
	const double side = CELLS * SPACING;
	for (int i = 0; i < TILES; i++) {
		const double xy[2] = {(i % COLUMNS + 0.5) * side, (i / COLUMNS + 0.5) * side};
		struct furrow_point ground;
		must(furrow_points(world, 1, xy, &ground));
		const struct furrow_pose pose = {{xy[0], xy[1], ground.height + RADIUS - 0.1}, {1, 0, 0, 0}};
		must(furrow_place(world, balls[i], &pose));
	}
	must(furrow_step(world, 0));
}

/* Commits all changed pages now. In a drive the cache does this when pages are old or its queue is full. */
static void force_commit(struct furrow_world *world)
{
	bench_must(page_cache_flush(world_resident(world->world)->cache, world_made_record(world->world)));
}

static double *read_all(struct furrow_world *world, size_t *count)
{
	struct furrow_info info = {.size = sizeof info};
	must(furrow_info(world, &info));
	*count = (size_t)(info.columns * info.rows);
	double *posts = malloc(*count * sizeof *posts);
	if (posts == NULL)
		exit(1);
	must(furrow_read(world, FURROW_SURFACE, info.level, 0, 0, (uint32_t)info.columns, (uint32_t)info.rows, posts, (size_t)info.columns));
	return posts;
}

int main(int argc, char **argv)
{
	const int rounds = argc > 1 ? atoi(argv[1]) : 1000;
	const struct dem_synth synth = {.kind = DEM_SYNTH_PLAIN, .width = COLUMNS * CELLS + 1, .height = ROWS * CELLS + 1, .spacing = SPACING, .relief = 2, .seed = 1};
	const char *store = bench_path("rollback.furrow");
	double *ms = calloc((size_t)(rounds > 0 ? rounds : 1), sizeof *ms), worst = 0;
	furrow_body balls[TILES];
	size_t posts, after;
	if (rounds < 1 || ms == NULL)
		return 2;
	bench_store(store, &synth, CELLS);
	struct furrow_world *world = open_world(store);
	for (int i = 0; i < TILES; i++) {
		char object[64];
		snprintf(object, sizeof object, "{name: ball%d, shape: {sphere: {radius: %g}}}", i, RADIUS);
		must(furrow_body_add(world, object, &balls[i]));
	}
	must(furrow_checkpoint(world));
	double *before = read_all(world, &posts);
	struct page_stats stats;
	for (int round = 0; round < rounds; round++) {
		for (int i = 0; i < FORCED; i++) {
			press(world, balls);
			force_commit(world);
		}
		press(world, balls); /* changes that are not committed when the rollback comes */
		/* Wait until the GPU has done the step, so that the measured time is that of the rollback alone. */
		struct furrow_contact contact;
		for (int i = 0; i < TILES; i++)
			must(furrow_get_contacts(world, 1, &balls[i], &contact, sizeof contact));
		const double began = clock_seconds();
		must(furrow_rollback(world));
		ms[round] = (clock_seconds() - began) * 1e3;
		worst = fmax(worst, ms[round]);
	}
	double *now = read_all(world, &after);
	const bool same = posts == after && memcmp(before, now, posts * sizeof *now) == 0;
	page_cache_stats(world_resident(world->world)->cache, &stats);
	printf("{\"bench\": \"rollback\", \"rollbacks\": %d, \"tiles\": %d, \"cells\": %d, \"commits\": %llu, \"median_ms\": %.2f, \"worst_ms\": %.2f, "
	       "\"same\": %s, \"gl\": \"%s\"}\n", rounds, TILES, CELLS, (unsigned long long)stats.commits, bench_median(ms, (size_t)rounds), worst,
	       same ? "true" : "false", gpu_info(world_resident(world->world)->gpu)->renderer);
	must(furrow_world_close(world));
	free(before);
	free(now);
	free(ms);
	return same ? 0 : 1;
}
