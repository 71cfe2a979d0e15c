/*
 * Soil that bears: the CPU (src/bearing) beside the GPU's passes of model scm, in one run. A wheel of radius 0.5 m and width 0.4 m with 5 kN rolls
 * straight over level ground at slip 0.2: Project Chrono's soft soil, rim on, one relaxation iteration a path sample, path samples one post apart.
 * Every tile is resident. Wall clock of a path sample: search of the equilibrium height, contact, laying, sliding, and the tiles put back. The two
 * ways take turns; medians of RUNS runs. "wheels": one wheel, or four, the rear ones in the ruts of the front ones.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bearing/bearing.h"
#include "bench.h"
#include "deform/deform.h"
#include "resident/host_slots.h"

enum { RUNS = 5, SIDE = 5, CELLS = 256, MOST = 4 };
static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4};

struct ground {
	double spacing;
	int wheels, steps;
	struct extent extent;
	struct gpu *gpu;
	struct gpu_slots *slots;
	struct deform *deform;
	struct host_slots *host;
	struct bearing *bearing;
	double sinkage; /* m, of the last sample of wheel 0 */
};

static struct deform_params params_of(const struct ground *ground)
{
	struct deform_params params = {
		.extent = &ground->extent, .model = DEFORM_SCM, .box_radius = 1, .box_repetitions = 1, .soil_count = 1, .iterations = 1, .depth = INFINITY,
		.bulldozing = 0.5, .slip_sinkage = 0, .along_lines = true, .undisturbed_stable = true, .loaded_bodies = MOST,
	};
	soil_clear(&params.soils[0]);
	params.soils[0].bekker_kc = params.soils[0].cohesion = 0;
	params.soils[0].bekker_kphi = 0.2e6;
	params.soils[0].bekker_n = 1.1;
	params.soils[0].friction_angle = params.soils[0].repose = 30 * M_PI / 180;
	params.soils[0].janosi_shear = 0.01;
	params.soils[0].elastic_stiffness = 4e7;
	params.soils[0].damping = 3e4;
	params.soils[0].unit_weight = 16e3;
	return params;
}

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

static void open_ground(struct ground *ground)
{
	const size_t posts = (size_t)(CELLS + 1) * (CELLS + 1);
	struct gpu_staging *flat;
	ground->extent = (struct extent){SIDE * CELLS + 1, SIDE * CELLS + 1, ground->spacing, CELLS};
	struct deform_params params = params_of(ground);
	const unsigned planes = deform_planes(DEFORM_SCM, false, false);
	bench_must(gpu_create(&(struct gpu_params){.draws = false}, &ground->gpu));
	bench_must(gpu_slots_create(ground->gpu, CELLS, SIDE * SIDE, planes, &ground->slots));
	bench_must(gpu_staging_create(ground->gpu, posts * sizeof(int32_t), &flat));
	memset(gpu_staging_bytes(flat), 0, posts * sizeof(int32_t));
	for (uint32_t i = 0; i < SIDE * SIDE; i++) {
		bench_must(gpu_slots_upload_base(ground->slots, i, flat, 0));
		bench_must(gpu_slots_deform(ground->slots, i));
	}
	gpu_staging_destroy(flat);
	params.gpu = ground->gpu;
	params.slots = ground->slots;
	bench_must(deform_create(&params, &ground->deform));
	bench_must(deform_warm(ground->deform, &(struct deform_planned){&wheel, 5000, true, false}, true));
	bench_must(resident_host_create(CELLS, SIDE * SIDE, planes, &ground->host));
	for (uint32_t i = 0; i < SIDE * SIDE; i++) {
		int32_t *base;
		bench_must(resident_host_tile_base(ground->host, &host_entry(ground->host, i)->tile, &base));
		memset(base, 0, posts * sizeof *base);
		bench_must(resident_host_write(ground->host, i, planes));
	}
	bench_must(bearing_create(&params, ground->host, &ground->bearing));
}

static void close_ground(struct ground *ground)
{
	bearing_destroy(ground->bearing);
	resident_host_destroy(ground->host);
	deform_destroy(ground->deform);
	gpu_slots_destroy(ground->slots);
	gpu_destroy(ground->gpu);
}

static struct deform_contact contact_of(const struct ground *ground, int step, int number)
{
	/* Two axles 3 m apart, a track of 1.6 m. */
	const double x = (CELLS - 40) * ground->spacing + (number < 2 ? 3 : 0), y = CELLS * ground->spacing + 1.6 * (number % 2), d = ground->spacing;
	struct deform_contact contact = {
		.shape = &wheel, .load = 5000, .loaded_body = (uint32_t)number + 1, .tag = 1, .turned = step > 0 ? d / (wheel.radius * 0.8) : 0,
		.to = {.x = lattice_offset(x + d * step), .y = lattice_offset(y), .z = lattice_offset(0.5)},
	};
	contact.from = contact.to;
	if (step > 0)
		contact.from.x = lattice_offset(x + d * (step - 1));
	return contact;
}

static double run_gpu(struct ground *ground)
{
	struct tile_slot tiles[SIDE * SIDE];
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	struct deform_forces forces = {.sinkage = 0};
	bool taken = true;
	size_t count;
	gpu_finish(ground->gpu);
	const double began = clock_seconds();
	for (int step = 0; step < ground->steps; step++) {
		for (int number = 0; number < ground->wheels; number++) {
			const struct deform_contact contact = contact_of(ground, step, number);
			bench_must(deform_windows(ground->deform, &contact, windows, &count));
			for (size_t i = 0; i < count; i++)
				bench_must(deform_compute(ground->deform, &contact, &windows[i], (uint32_t)i, tiles, tiles_of(ground, windows[i].read, tiles)));
			for (size_t i = 0; i < count; i++) {
				bench_must(deform_scatter(ground->deform, &windows[i], (uint32_t)i, tiles, tiles_of(ground, windows[i].write, tiles)));
				bench_must(deform_wake_swept(ground->deform, &windows[i], (uint32_t)i));
			}
		}
		bench_must(deform_forces_begin(ground->deform));
		for (taken = true; taken;)
			bench_must(deform_forces_take(ground->deform, true, &forces, &taken));
	}
	gpu_finish(ground->gpu);
	ground->sinkage = forces.sinkage;
	return clock_seconds() - began;
}

static double run_cpu(struct ground *ground)
{
	struct tile_slot tiles[SIDE * SIDE];
	struct bearing_area area;
	struct bearing_contact done = {.forces = {.sinkage = 0}};
	const double began = clock_seconds();
	for (int step = 0; step < ground->steps; step++)
		for (int number = 0; number < ground->wheels; number++) {
			const struct deform_contact contact = contact_of(ground, step, number);
			bench_must(bearing_area(ground->bearing, &contact, &area));
			done = (struct bearing_contact){.contact = &contact, .area = area};
			const size_t count = tiles_of(ground, area.read, tiles);
			bench_must(bearing_meeting_begin(ground->bearing, &done, 1, true));
			bearing_meeting_gather(ground->bearing, tiles, count);
			bench_must(bearing_meeting_compute(ground->bearing, &done, 1, NULL, 0));
			bench_must(bearing_meeting_scatter(ground->bearing, &done, 1, tiles, count));
		}
	ground->sinkage = done.forces.sinkage;
	return clock_seconds() - began;
}

static void measure(double spacing, int wheels)
{
	double gpu[RUNS], cpu[RUNS], sunk[2] = {0, 0};
	char renderer[256] = "";
	for (int run = 0; run < RUNS; run++) {
		struct ground ground = {.spacing = spacing, .wheels = wheels, .steps = spacing < 0.03 ? 150 : 200};
		open_ground(&ground);
		const double samples = ground.steps * wheels;
		gpu[run] = run_gpu(&ground) / samples * 1e6;
		sunk[0] = ground.sinkage;
		cpu[run] = run_cpu(&ground) / samples * 1e6;
		sunk[1] = ground.sinkage;
		snprintf(renderer, sizeof renderer, "%s", gpu_info(ground.gpu)->renderer);
		close_ground(&ground);
	}
	const double passes = bench_median(gpu, RUNS), soil = bench_median(cpu, RUNS);
	printf("{\"bench\": \"bearing\", \"posts_m\": %g, \"wheels\": %d, \"gpu_us\": %.1f, \"cpu_us\": %.1f, \"times\": %.2f, \"gpu_ms_a_metre\": %.2f, "
	       "\"cpu_ms_a_metre\": %.2f, \"gpu_sinkage_mm\": %.2f, \"cpu_sinkage_mm\": %.2f, \"gl\": \"%s\"}\n",
	       spacing, wheels, passes, soil, passes / soil, passes * wheels / spacing * 1e-3, soil * wheels / spacing * 1e-3, sunk[0] * 1e3, sunk[1] * 1e3, renderer);
	fflush(stdout);
}

int main(int argc, char **argv)
{
	static const double spacings[] = {0.25, 0.125, 0.04, 0.02, 0.01};
	(void)argc;
	(void)argv;
	for (size_t s = 0; s < sizeof spacings / sizeof *spacings; s++)
		for (int wheels = 1; wheels <= MOST; wheels *= 4)
			measure(spacings[s], wheels);
	return 0;
}
