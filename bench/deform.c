/*
 * What deformation costs, by model, spacing and number of objects: wheels of 0.5 m radius and 0.4 m width,
 * 0.1 m deep, at 2 m/s over flat ground, one station a step (a post of travel), with the ground's
 * intervals every 0.05 s, and every tile resident. Soil that bears: bench/bearing.c.
 *
 * Wall clock around a finish. step_ms is the mean over all steps, intervals included; p50 and p95 of single steps beside it; of
 * several runs in turn the median. ms_a_metre: step_ms for a metre of travel. posts_per_s: posts of the windows that were written.
 * copy_fraction: the bytes of the planes of those posts, once read and once written, a second, over what memcpy moves in the same
 * process. interval_ms: the mean over intervals, blocks: active blocks of an interval. "draws": with the raster threads a process that
 * draws keeps. "quick": fewer runs. A model's name: it alone; "fine": at the finest spacing only. "soil=NAME": of that soil instead of
 * dry_sand; "cohesion=PA": with that cohesion. "--figures FILE": see record.h; of runs without disturbance.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "deform/deform.h"
#include "record.h"

#define INTERVAL 0.05 /* s: a scene's default */
enum { STEPS = 400, RUNS = 5, SIDE = 5, CELLS = 256, WHEELS_MOST = 4 };

static char renderer[256]; /* of the last ground */
static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4};

struct bench_case {
	enum deform_model model;
	double spacing;
	int wheels;
	bool dirt;
	const char *soil;
	double cohesion; /* Pa; below 0: the soil's own */
};

struct ground {
	struct bench_case of;
	struct extent extent;
	struct gpu *gpu;
	struct gpu_slots *slots;
	struct deform *deform;
	struct deform_rest rests[WHEELS_MOST];
	double posts; /* written by windows */
	double interval_s, intervals, blocks; /* seconds of all intervals, their number, active blocks of all of them */
};

struct figures {
	double mean, p50, p95; /* ms a step */
	double posts, passes;  /* a step */
	double interval_ms, blocks; /* an interval */
};

static struct soil_pose pose_of(const struct ground *ground, int step, int number)
{
	/* Begins a little before a tile's edge, and beside one. */
	double start = (CELLS - 40) * ground->of.spacing, lane = CELLS * ground->of.spacing + 2.0 * number;
	if (start < 1)
		start = 1;
	return (struct soil_pose){
		.x = lattice_offset(start + ground->of.spacing * step),
		.y = lattice_offset(lane),
		.z = lattice_offset(0.4),
	};
}

/* Every tile that shares a post with the rectangle. */
static size_t tiles_of(const struct ground *ground, struct post_rect rect, struct tile_slot tiles[SIDE * SIDE])
{
	size_t count = 0;
	struct tile first, last;
	if (!tile_range_of(&ground->extent, 0, rect, &first, &last))
		bench_must(fail_with(STATUS_FAILED, "bench: the path leaves the terrain; mend it"));
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x; x++)
			tiles[count++] = (struct tile_slot){{0, x, y}, y * SIDE + x};
	return count;
}

static void sweep(struct ground *ground, int step, int number)
{
	double seconds = ground->of.spacing / 2;
	struct deform_contact sweep = {
		.shape = &wheel,
		.from = pose_of(ground, step, number),
		.to = pose_of(ground, step + 1, number),
		.seconds = seconds,
		.turned = ground->of.spacing / (wheel.radius * 0.8), /* slip 0.2 */
	};
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	struct tile_slot tiles[SIDE * SIDE];
	size_t count;
	bench_must(deform_windows(ground->deform, &sweep, windows, &count));
	for (size_t i = 0; i < count; i++)
		bench_must(deform_compute(ground->deform, &sweep, &windows[i], (uint32_t)i, tiles,
					  tiles_of(ground, windows[i].read, tiles)));
	for (size_t i = 0; i < count; i++) {
		const struct post_rect write = windows[i].write;
		bench_must(deform_scatter(ground->deform, &windows[i], (uint32_t)i, tiles, tiles_of(ground, write, tiles)));
		bench_must(deform_wake_swept(ground->deform, &windows[i], (uint32_t)i));
		ground->posts += (double)((write.x1 - write.x0) * (write.y1 - write.y0));
	}
	ground->rests[number] = (struct deform_rest){.shape = &wheel, .pose = sweep.to};
}

static void interval(struct ground *ground)
{
	struct tile_slot tiles[SIDE * SIDE];
	struct deform_interval size;
	gpu_finish(ground->gpu);
	double began = clock_seconds();
	bench_must(deform_interval_begin(ground->deform, ground->rests, (size_t)ground->of.wheels, &size));
	for (size_t i = 0; i < size.regions; i++)
		bench_must(deform_interval_gather(ground->deform, i, tiles,
						  tiles_of(ground, deform_interval_reads(ground->deform, i), tiles)));
	for (size_t i = 0; i < size.runs; i++)
		bench_must(deform_interval_scatter(ground->deform, i, tiles,
						   tiles_of(ground, deform_interval_writes(ground->deform, i), tiles)));
	if (size.blocks > 0)
		bench_must(deform_interval_end(ground->deform));
	gpu_finish(ground->gpu);
	ground->interval_s += clock_seconds() - began;
	ground->intervals++;
	ground->blocks += (double)size.blocks;
}

static void one_step(struct ground *ground, int step)
{
	double seconds = ground->of.spacing / 2;
	for (int number = 0; number < ground->of.wheels; number++)
		sweep(ground, step, number);
	if (floor((step + 1) * seconds / INTERVAL) > floor(step * seconds / INTERVAL))
		interval(ground);
}

static void open_ground(const struct bench_case *of, bool draws, struct ground *ground)
{
	*ground = (struct ground){.of = *of, .extent = {SIDE * CELLS + 1, SIDE * CELLS + 1, of->spacing, CELLS}};
	bench_must(gpu_create(&(struct gpu_params){.draws = draws}, &ground->gpu));
	bench_must(gpu_slots_create(ground->gpu, CELLS, SIDE * SIDE, deform_planes(of->model, of->dirt, false), &ground->slots));
	size_t flat_bytes = (size_t)(CELLS + 1) * (CELLS + 1) * sizeof(int32_t);
	struct gpu_staging *flat;
	bench_must(gpu_staging_create(ground->gpu, flat_bytes, &flat));
	memset(gpu_staging_bytes(flat), 0, flat_bytes);
	for (uint32_t i = 0; i < SIDE * SIDE; i++)
		bench_must(gpu_slots_upload_base(ground->slots, i, flat, 0));
	gpu_staging_destroy(flat);
	struct deform_params params = {
		.gpu = ground->gpu,
		.slots = ground->slots,
		.extent = &ground->extent,
		.model = of->model,
		.box_radius = 1,
		.box_repetitions = 1,
		.soil_count = 1,
		.iterations = 1,
		.depth = deform_model_row(of->model)->depth,
		.along_lines = true,
		.disturbance = of->dirt,
	};
	bench_must(soil_named(of->soil, &params.soils[0]));
	if (of->cohesion >= 0)
		params.soils[0].cohesion = of->cohesion;
	params.soils[0].compression = 0.3; /* as when the figures were measured: sumner lays 0.7 of what is pressed */
	bench_must(deform_create(&params, &ground->deform));
	bench_must(deform_warm(ground->deform, &(struct deform_planned){&wheel, true, false}));
}

static void close_ground(struct ground *ground)
{
	deform_destroy(ground->deform);
	gpu_slots_destroy(ground->slots);
	gpu_destroy(ground->gpu);
}

static uint64_t passes(struct gpu *gpu)
{
	struct gpu_stats stats;
	gpu_stats(gpu, &stats);
	return gpu_group_passes(&stats, GPU_DISPLACE) + gpu_group_passes(&stats, GPU_REDISTRIBUTE) +
	       gpu_group_passes(&stats, GPU_ATTRIBUTES);
}

/* Over fresh ground each time. */
static void run_once(struct ground *ground, struct figures *figures)
{
	static double ms[STEPS];
	double sum = 0;
	for (uint32_t i = 0; i < SIDE * SIDE; i++) {
		gpu_slots_undeform(ground->slots, i);
		bench_must(gpu_slots_deform(ground->slots, i));
	}
	ground->posts = ground->interval_s = ground->intervals = ground->blocks = 0;
	uint64_t before = passes(ground->gpu);
	for (int step = 0; step < STEPS; step++) {
		gpu_finish(ground->gpu);
		double began = clock_seconds();
		one_step(ground, step);
		gpu_finish(ground->gpu);
		ms[step] = (clock_seconds() - began) * 1e3;
		sum += ms[step];
	}
	figures->mean = sum / STEPS;
	figures->p50 = bench_median(ms, STEPS);
	figures->p95 = ms[STEPS * 95 / 100];
	figures->posts = ground->posts / STEPS;
	figures->passes = (double)(passes(ground->gpu) - before) / STEPS;
	figures->interval_ms = ground->interval_s / ground->intervals * 1e3;
	figures->blocks = ground->blocks / ground->intervals;
}

/* Bytes a second, read and written, of a block that no cache holds. */
static double copy_rate(void)
{
	enum { BYTES = 64 << 20, TIMES = 7 };
	char *from = malloc(BYTES), *to = malloc(BYTES);
	double rates[TIMES];
	if (from == NULL || to == NULL)
		bench_must(fail_memory("bench"));
	memset(from, 1, BYTES);
	memset(to, 2, BYTES);
	for (int i = 0; i < TIMES; i++) {
		double began = clock_seconds();
		memcpy(to, from, BYTES);
		rates[i] = 2.0 * BYTES / (clock_seconds() - began);
		from[i] = to[BYTES - 1 - i];
	}
	free(from);
	free(to);
	return bench_median(rates, TIMES);
}

static size_t post_bytes(const struct bench_case *of)
{
	size_t bytes = sizeof(int32_t); /* base */
	for (int plane = 0; plane < PLANES; plane++)
		if (deform_planes(of->model, of->dirt, false) & PLANE_BIT(plane))
			bytes += plane_bytes((enum plane)plane);
	return bytes;
}

static void measure(const struct bench_case *of, bool draws, int runs, double rate)
{
	struct ground ground;
	struct figures each[RUNS];
	double mean[RUNS], p50[RUNS], p95[RUNS], interval_ms[RUNS];
	char key[64];
	open_ground(of, draws, &ground);
	run_once(&ground, &each[0]); /* warms */
	for (int i = 0; i < runs; i++) {
		run_once(&ground, &each[i]);
		mean[i] = each[i].mean;
		p50[i] = each[i].p50;
		p95[i] = each[i].p95;
		interval_ms[i] = each[i].interval_ms;
	}
	double ms = bench_median(mean, (size_t)runs), posts_per_s = each[0].posts / ms * 1e3;
	printf("{\"bench\": \"deform\", \"model\": \"%s\", \"soil\": \"%s\", \"posts_m\": %g, \"wheels\": %d, \"dirt\": %s, \"draws\": %s, "
	       "\"step_ms\": %.3f, \"ms_a_metre\": %.1f, \"p50\": %.3f, \"p95\": %.3f, \"posts\": %.0f, \"posts_per_s\": %.3g, \"passes\": %.1f, "
	       "\"interval_ms\": %.3f, \"blocks\": %.1f, \"post_bytes\": %zu, \"copy_fraction\": %.4f, \"gl\": \"%s\"}\n",
	       deform_model_row(of->model)->name, of->soil, of->spacing, of->wheels, of->dirt ? "true" : "false", draws ? "true" : "false", ms,
	       ms / of->spacing, bench_median(p50, (size_t)runs), bench_median(p95, (size_t)runs), each[0].posts, posts_per_s, each[0].passes,
	       bench_median(interval_ms, (size_t)runs), each[0].blocks, post_bytes(of), posts_per_s * (double)post_bytes(of) * 2 / rate, gpu_info(ground.gpu)->renderer);
	fflush(stdout);
	const int used = snprintf(key, sizeof key, "%s.w%d.%gcm", deform_model_row(of->model)->name, of->wheels, of->spacing * 100);
	if (!of->dirt) {
		snprintf(key + used, sizeof key - (size_t)used, ".p50");
		bench_record_add(key, "ms", p50, (size_t)runs);
		snprintf(key + used, sizeof key - (size_t)used, ".mean");
		bench_record_add(key, "ms", mean, (size_t)runs);
	}
	snprintf(renderer, sizeof renderer, "%s", gpu_info(ground.gpu)->renderer);
	close_ground(&ground);
}

/* Returns what follows `name` in an argument; NULL: there is none. */
static const char *value_of(int argc, char **argv, const char *name)
{
	for (int i = 1; i < argc; i++)
		if (strncmp(argv[i], name, strlen(name)) == 0)
			return argv[i] + strlen(name);
	return NULL;
}

static bool says(int argc, char **argv, const char *word)
{
	for (int i = 1; i < argc; i++)
		if (strcmp(argv[i], word) == 0)
			return true;
	return false;
}

int main(int argc, char **argv)
{
	enum { COUNT = 6 };
	static const double spacings[COUNT] = {0.25, 0.125, 0.04, 0.03125, 0.02, 0.01};
	/* A process settles llvmpipe's threads once: draws or not is an argument. */
	bench_record_begin("deform", &argc, argv);
	bool draws = says(argc, argv, "draws"), quick = says(argc, argv, "quick");
	double rate = copy_rate();
	printf("{\"bench\": \"deform\", \"memcpy_bytes_per_s\": %.3g}\n", rate);
	const char *soil = value_of(argc, argv, "soil="), *cohesion = value_of(argc, argv, "cohesion=");
	bool one = false, fine = says(argc, argv, "fine");
	for (int model = 0; model < DEFORM_MODELS; model++)
		one = one || says(argc, argv, deform_model_row((enum deform_model)model)->name);
	for (int model = 0; model < DEFORM_MODELS; model++)
		for (size_t s = fine ? COUNT - 1 : 0; s < COUNT && !deform_for_cpu((enum deform_model)model) && (!one || says(argc, argv, deform_model_row((enum deform_model)model)->name)); s++)
			for (int wheels = 1; wheels <= WHEELS_MOST; wheels *= 4)
				for (int dirt = 0; dirt < (spacings[s] == 0.125 ? 2 : 1); dirt++)
					measure(&(struct bench_case){(enum deform_model)model, spacings[s], wheels, dirt == 1,
								     soil != NULL ? soil : "dry_sand", cohesion != NULL ? atof(cohesion) : -1},
						draws, quick ? 1 : RUNS, rate);
	bench_record_end(renderer);
	return 0;
}
