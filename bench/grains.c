/*
 * Measures soil in flight: milliseconds of a processor for a step of a 64th of a second, in which each grain is looked at once, without grains and with so many. Prints a JSON line for
 * each. "flying": none lands. "landing": each flies for about a second, and new ones leave for those that landed.
 *
 *     bench_grains [GRAINS] [--figures FILE]      default 10000 grains
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>

#include "bench.h"
#include "record.h"
#include "world/made.h"

enum { CELLS = 256, STEPS = 192, REST = 16 };
#define SPACING 0.0625 /* m */
#define SECOND (1 << THROWN_BITS)

/* A ball far from the grains creeps on, so that the scene throws soil. */
static const char text[] = "scene: 1\ntime_step: 0.015625\nend_time: 600\nsoil: {name: dry_sand}\nredistribute: {model: scm, thrown: on}\ncache: {slots: 16}\n"
			   "objects:\n- {name: ball, shape: {sphere: {radius: 0.1}}, sink: 0.001, path: {points: [[1, 1], [15, 1]], speed: 0.02}}\n";

static double processor(void)
{
	struct rusage used;
	getrusage(RUSAGE_SELF, &used);
	return (double)used.ru_utime.tv_sec + 1e-6 * (double)used.ru_utime.tv_usec + (double)used.ru_stime.tv_sec + 1e-6 * (double)used.ru_stime.tv_usec;
}

/* Adds grains until so many fly. They leave all over the ground, 1 m above it. up: m/s. */
static void add(struct world *world, size_t count, double up)
{
	static uint32_t number;
	const int64_t now = llround(world_time(world) * SECOND), height = (int64_t)21 * SECOND;
	for (size_t flying = world_grains(world, 0, NULL); flying < count; flying++) {
		const uint32_t by_chance = ++number * 2654435761u;
		const struct bearing_grain grain = {
			.from = {SECOND / 16 * (int64_t)(24 + (by_chance >> 16 & 127)), SECOND / 16 * (int64_t)(24 + (by_chance >> 24 & 127)), height},
			.since = now, .volume = 1000, .velocity = {(int32_t)(by_chance & 1023) * 512, 0, (int32_t)(up * SECOND)},
		};
		world_made_throw(world, &grain, 1);
	}
}

static double ms_a_step(struct world *world, const char *how, size_t grains, double up)
{
	double ms[STEPS];
	size_t flew = 0;
	for (int i = -REST; i < STEPS; i++) {
		add(world, grains, up);
		const double began = processor();
		for (int k = 0; k < (grains == 0 ? 64 : 1); k++) {
			bench_must(world_step(world));
			world_rows_clear(world);
		}
		if (i >= 0)
			ms[i] = (processor() - began) * 1e3 / (grains == 0 ? 64 : 1);
		flew += i >= 0 ? world_grains(world, 0, NULL) : 0;
	}
	double mean = 0;
	for (int i = 0; i < STEPS; i++)
		mean += ms[i] / STEPS;
	char key[32];
	snprintf(key, sizeof key, "%s.%zu", how, grains);
	bench_record_add(key, "ms", ms, STEPS);
	printf("{\"bench\": \"grains\", \"how\": \"%s\", \"grains\": %zu, \"ms_a_step\": %.4f}\n", how, flew / STEPS, mean);
	return mean;
}

static void drain(struct world *world)
{
	while (world_grains(world, 0, NULL) > 0) {
		bench_must(world_step(world));
		world_rows_clear(world);
	}
}

int main(int argc, char **argv)
{
	bench_record_begin("grains", &argc, argv);
	const long grains = argc > 1 ? atol(argv[1]) : 10000;
	const struct dem_synth synth = {.kind = DEM_SYNTH_PLAIN, .width = CELLS + 1, .height = CELLS + 1, .spacing = SPACING, .relief = 0.01, .seed = 1};
	const char *store = bench_path("grains.furrow"), *file = bench_path("grains.yaml");
	struct scene *scene;
	struct world *world;
	if (grains < 1 || grains > WORLD_THROWN_MOST)
		return 2;
	bench_store(store, &synth, CELLS);
	FILE *out = fopen(file, "w");
	if (out == NULL || fputs(text, out) < 0 || fclose(out) != 0)
		return 1;
	bench_must(scene_load(file, NULL, 0, &scene));
	const struct world_params params = {.scene = scene, .store = store, .rows = true};
	bench_must(world_open(&params, &world));
	bench_must(world_start(world));
	bench_must(world_start_pages(world, NULL, NULL));
	bench_must(world_warm(world));
	world_seal(world);
	bench_must(world_begin(world));
	world_rows_clear(world);
	const double empty = ms_a_step(world, "none", 0, 0);
	const double flying = ms_a_step(world, "flying", (size_t)grains, 200);
	drain(world);
	const double landing = ms_a_step(world, "landing", (size_t)grains, 5);
	printf("{\"bench\": \"grains\", \"flying_by_empty\": %.1f, \"landing_by_empty\": %.1f}\n", flying / empty, landing / empty);
	bench_must(world_end(world, false));
	world_stop(world);
	world_finish(world, STATUS_OK);
	scene_destroy(scene);
	bench_record_end("");
	return 0;
}
