/*
 * Prints what each stage of a step takes: a mean over the steps of a scene, in microseconds, and its share of the step.
 *
 *     bench_stages SCENE STORE [STEPS]
 *
 * Pictures are not drawn, and rows are not written. The overlay is a new one. Vehicles count apart: their engine, and the probes that it asks.
 */
#include <stdio.h>
#include <stdlib.h>

#include "bench.h"
#include "vehicle/vehicle.h"
#include "world/world.h"

static void start(struct world *world, struct vehicles *vehicles)
{
	bench_must(world_start(world));
	bench_must(world_start_pages(world, NULL, NULL));
	bench_must(world_warm(world));
	if (vehicles != NULL)
		bench_must(vehicle_join(vehicles, world));
	world_seal(world);
	bench_must(world_begin(world));
	if (vehicles != NULL)
		bench_must(vehicle_begin(vehicles));
	world_rows_clear(world);
}

static void step(struct world *world, struct vehicles *vehicles)
{
	bench_must(vehicles != NULL ? vehicle_step(vehicles) : world_step(world));
	world_rows_clear(world);
}

static void print(const struct world *world, const double before[WORLD_STAGES], int64_t steps, double all)
{
	double known = 0;
	printf("%-8s %10s %7s\n", "stage", "us a step", "share");
	for (int i = 0; i < WORLD_STAGES; i++) {
		const double seconds = world_counts(world)->stage_seconds[i] - before[i];
		known += seconds;
		printf("%-8s %10.2f %6.1f%%\n", world_stage_name((enum world_stage)i), 1e6 * seconds / (double)steps, 100 * seconds / all);
	}
	printf("%-8s %10.2f %6.1f%%\n", "vehicles", 1e6 * (all - known) / (double)steps, 100 * (all - known) / all);
	printf("%-8s %10.2f\n", "step", 1e6 * all / (double)steps);
}

int main(int argc, char **argv)
{
	struct scene *given, scene;
	struct vehicles *vehicles = NULL;
	struct world *world = NULL;
	if (argc < 3) {
		fprintf(stderr, "usage: bench_stages SCENE STORE [STEPS]\n");
		return 2;
	}
	bench_must(scene_load(argv[1], NULL, 0, &given));
	scene_unwatched(given, &scene);
	scene.view.present = false;
	bench_must(vehicle_load(&scene, &vehicles));
	const struct world_params params = {.scene = &scene, .store = argv[2], .overlay = bench_path("ruts.furrow"), .attached = vehicle_attached(vehicles), .rows = true};
	bench_must(world_open(&params, &world));
	start(world, vehicles);
	const int64_t last = world_step_count(world), asked = argc > 3 ? atoll(argv[3]) : last, steps = asked < last ? asked : last;
	double before[WORLD_STAGES];
	for (int i = 0; i < WORLD_STAGES; i++)
		before[i] = world_counts(world)->stage_seconds[i];
	const double began = clock_seconds();
	for (int64_t i = 0; i < steps; i++)
		step(world, vehicles);
	print(world, before, steps, clock_seconds() - began);
	bench_must(world_end(world, false));
	world_stop(world);
	world_finish(world, STATUS_OK);
	vehicle_destroy(vehicles);
	scene_destroy(given);
	return 0;
}
