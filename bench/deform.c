/*
 * What deformation costs: four wheels of 0.5 m radius and 0.4 m width, one station each a step, at
 * 0.125 m posts, under each model, without dirt and with. Wall clock around a finish; the median of
 * the steps of the median run. "draws": with the raster threads a process that draws keeps.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "deform/deform.h"

#define STEPS 400
#define RUNS 5
#define SCM_STEPS 200
#define SIDE 4 /* tiles a side */

static const struct world world = {SIDE * 256 + 1, SIDE * 256 + 1, 0.125, 256};
static const struct deform_shape wheel = {.kind = DEFORM_WHEEL, .radius = 0.5, .width = 0.4};

struct figures {
	double median, p95;
	struct gpu_stats stats;
	char renderer[256];
};

static struct deform_pose pose_of(int step, int number)
{
	/* Across the corners of tiles: 32 m tiles, a diagonal through them. */
	double along = 10 + 0.125 * step, side = number % 2 ? 0.9 : -0.9, back = number / 2 ? 2.6 : 0;
	double yaw = M_PI / 4, c = cos(yaw), s = sin(yaw);
	return (struct deform_pose){
		.x = lattice_offset((along - back) * c - side * s + 4),
		.y = lattice_offset((along - back) * s + side * c + 4),
		.z = lattice_offset(0.4),
		.yaw = yaw,
	};
}

static void sweep_tiles(struct deform *deform, const struct world *ground, const struct deform_sweep *sweep)
{
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count;
	bench_must(deform_windows(deform, sweep, windows, &count));
	struct deform_tile tiles[16];
	size_t tile_count = 0;
	struct tile first, last;
	if (count != 1 || !tile_range_of(ground, 0, windows[0].read, &first, &last))
		bench_must(fail_with(STATUS_FAILED, "bench: the path leaves the terrain; mend it"));
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x; x++)
			tiles[tile_count++] = (struct deform_tile){{0, x, y}, y * SIDE + x};
	bench_must(deform_compute(deform, sweep, &windows[0], 0, tiles, tile_count));
	bench_must(deform_scatter(deform, &windows[0], 0, tiles, tile_count));
}

static void one_step(struct deform *deform, int step)
{
	for (int number = 0; number < 4; number++) {
		struct deform_sweep sweep = {.shape = &wheel, .from = pose_of(step, number), .to = pose_of(step + 1, number)};
		sweep_tiles(deform, &world, &sweep);
	}
}

static void fill_flat(struct gpu *gpu, struct gpu_slots *slots)
{
	size_t flat_bytes = (size_t)tile_posts(&world) * tile_posts(&world) * sizeof(int32_t);
	struct gpu_staging *flat;
	bench_must(gpu_staging_create(gpu, flat_bytes, &flat));
	memset(gpu_staging_bytes(flat), 0, flat_bytes);
	for (uint32_t i = 0; i < SIDE * SIDE; i++) {
		bench_must(gpu_slots_upload_base(slots, i, flat, 0));
		bench_must(gpu_slots_deform(slots, i));
	}
	gpu_staging_destroy(flat);
}

static void measure(enum deform_model model, bool dirt, bool draws, struct figures *figures)
{
	struct gpu *gpu;
	struct gpu_slots *slots;
	struct deform *deform;
	bench_must(gpu_create(&(struct gpu_params){.draws = draws}, &gpu));
	bench_must(gpu_slots_create(gpu, world.cells, SIDE * SIDE, deform_planes(model, dirt), &slots));
	fill_flat(gpu, slots);
	struct deform_params params = {
		.gpu = gpu,
		.slots = slots,
		.world = &world,
		.model = model,
		.box_radius = 1,
		.box_repetitions = 1,
		.dirt = dirt,
	};
	bench_must(deform_create(&params, &deform));
	static double ms[STEPS];
	double medians[RUNS], p95s[RUNS];
	for (int run = 0; run < RUNS; run++) {
		for (int step = 0; step < STEPS; step++) {
			gpu_finish(gpu);
			double began = clock_seconds();
			one_step(deform, step);
			gpu_finish(gpu);
			ms[step] = (clock_seconds() - began) * 1e3;
		}
		medians[run] = bench_median(ms, STEPS);
		p95s[run] = ms[STEPS * 95 / 100];
	}
	figures->median = bench_median(medians, RUNS);
	figures->p95 = bench_median(p95s, RUNS);
	gpu_stats(gpu, &figures->stats);
	snprintf(figures->renderer, sizeof figures->renderer, "%s", gpu_info(gpu)->renderer);
	deform_destroy(deform);
	gpu_slots_destroy(slots);
	gpu_destroy(gpu);
}

/* A cylinder's drive at 2 m/s over 1 cm posts, 0.1 m deep, with its rim and its forces; one station a step. */
static void measure_scm(int wheels, bool draws)
{
	static const struct world fine = {SIDE * 256 + 1, SIDE * 256 + 1, 0.01, 256};
	struct gpu *gpu;
	struct gpu_slots *slots;
	struct deform *deform;
	struct deform_params params = {.world = &fine, .model = DEFORM_SCM, .soil_count = 1, .iterations = 4, .bulldozing = 0.5, .relief = 100};
	bench_must(gpu_create(&(struct gpu_params){.draws = draws}, &gpu));
	bench_must(gpu_slots_create(gpu, fine.cells, SIDE * SIDE, deform_planes(DEFORM_SCM, false), &slots));
	fill_flat(gpu, slots);
	bench_must(deform_soil_named("dry_sand", &params.soils[0]));
	params.gpu = gpu;
	params.slots = slots;
	bench_must(deform_create(&params, &deform));
	static double ms[SCM_STEPS];
	double median[RUNS];
	for (int run = 0; run < RUNS; run++) {
		for (int step = 0; step < SCM_STEPS; step++) {
			gpu_finish(gpu);
			double began = clock_seconds();
			for (int number = 0; number < wheels; number++) {
				struct deform_sweep sweep = {.shape = &wheel, .seconds = 0.005, .turned = 0.02 / 0.8, .tag = 1};
				struct deform_pose pose = {.x = lattice_offset(1.5 + 0.01 * step), .z = lattice_offset(0.4),
							   .y = lattice_offset(1 + 2.0 * number)};
				sweep.from = sweep.to = pose;
				sweep.to.x = lattice_offset(1.5 + 0.01 * (step + 1));
				sweep_tiles(deform, &fine, &sweep);
			}
			bench_must(deform_forces_begin(deform));
			struct deform_forces forces;
			bool taken = true;
			while (taken)
				bench_must(deform_forces_take(deform, true, &forces, &taken));
			gpu_finish(gpu);
			ms[step] = (clock_seconds() - began) * 1e3;
		}
		for (uint32_t i = 0; i < SIDE * SIDE; i++)
			gpu_slots_undeform(slots, i);
		median[run] = bench_median(ms, SCM_STEPS);
	}
	printf("{\"bench\": \"deform\", \"model\": \"scm\", \"wheels\": %d, \"posts_m\": 0.01, \"draws\": %s, \"step_ms\": %.3f, "
	       "\"gl\": \"%s\"}\n",
	       wheels, draws ? "true" : "false", bench_median(median, RUNS), gpu_info(gpu)->renderer);
	fflush(stdout);
	deform_destroy(deform);
	gpu_slots_destroy(slots);
	gpu_destroy(gpu);
}

int main(int argc, char **argv)
{
	/* A process settles llvmpipe's threads once: draws or not is an argument. */
	bool draws = argc > 1 && argv[1][0] == 'd';
	for (int wheels = 1; wheels <= 4; wheels += 3)
		measure_scm(wheels, draws);
	for (int model = DEFORM_NONE; model <= DEFORM_BOX_FILTER; model++)
		for (int dirt = 0; dirt < 2; dirt++) {
			struct figures f;
			measure((enum deform_model)model, dirt, draws, &f);
			double steps = (double)STEPS * RUNS;
			printf("{\"bench\": \"deform\", \"model\": \"%s\", \"dirt\": %s, \"wheels\": 4, \"posts_m\": 0.125, "
			       "\"draws\": %s, \"step_ms\": %.3f, \"step_ms_p95\": %.3f, \"passes\": %.1f, \"gl\": \"%s\"}\n",
			       model == DEFORM_NONE ? "none" : "box", dirt ? "true" : "false", draws ? "true" : "false", f.median,
			       f.p95,
			       (double)(f.stats.passes[GPU_DISPLACE] + f.stats.passes[GPU_REDISTRIBUTE] +
					f.stats.passes[GPU_ATTRIBUTES]) /
				       steps,
			       f.renderer);
			fflush(stdout);
		}
	return 0;
}
