/* Beds on the GPU are whole tiles, all resident, of a world as large. */
#include "validation_bed.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"

#define CELLS 64

struct bed {
	bool on_gpu;
	struct deform_params params;
	struct reference_ground ground;
	struct extent extent;
	struct gpu_slots *slots;
	struct deform *deform;
	struct tile_slot *tiles;
	size_t tile_count;
};

static struct gpu *bed_gpu;

bool bed_open(void)
{
	enum status status = gpu_create(&(struct gpu_params){.draws = false}, &bed_gpu);
	if (status == STATUS_NO_GL)
		return false;
	bench_must(status);
	return true;
}

void bed_close(void)
{
	gpu_destroy(bed_gpu);
}

static void make_tiles(struct bed *bed, uint32_t side)
{
	const size_t bytes = (CELLS + 1) * (CELLS + 1) * sizeof(int32_t);
	struct gpu_staging *flat;
	bed->tile_count = (size_t)side * side;
	bed->tiles = mem_calloc(bed->tile_count, sizeof *bed->tiles);
	if (bed->tiles == NULL)
		bench_must(fail_memory("bench"));
	bench_must(gpu_slots_create(bed_gpu, CELLS, side * side, deform_planes(DEFORM_SCM, false, false), &bed->slots));
	bench_must(gpu_staging_create(bed_gpu, bytes, &flat));
	memset(gpu_staging_bytes(flat), 0, bytes);
	for (uint32_t k = 0; k < side * side; k++) {
		bed->tiles[k] = (struct tile_slot){{0, k % side, k / side}, k};
		bench_must(gpu_slots_upload_base(bed->slots, k, flat, 0));
	}
	gpu_staging_destroy(flat);
}

struct bed *bed_create(bool on_gpu, int width, int height, double spacing, const struct soil_numbers *soil)
{
	struct bed *bed = mem_calloc(1, sizeof *bed);
	if (bed == NULL)
		bench_must(fail_memory("bench"));
	bed->on_gpu = on_gpu;
	bed->params = (struct deform_params){.model = DEFORM_SCM, .soils = {*soil}, .soil_count = 1, .iterations = 1};
	if (!on_gpu) {
		bench_must(reference_ground_init(&bed->ground, width, height, spacing));
		return bed;
	}
	int most = width > height ? width : height;
	uint32_t side = (uint32_t)(most + CELLS - 2) / CELLS;
	bed->extent = (struct extent){side * CELLS + 1, side * CELLS + 1, spacing, CELLS};
	make_tiles(bed, side);
	bed->params.gpu = bed_gpu;
	bed->params.slots = bed->slots;
	bed->params.extent = &bed->extent;
	bench_must(deform_create(&bed->params, &bed->deform));
	return bed;
}

void bed_destroy(struct bed *bed)
{
	if (bed->on_gpu) {
		deform_destroy(bed->deform);
		gpu_slots_destroy(bed->slots);
		mem_free(bed->tiles);
	} else {
		reference_ground_finish(&bed->ground);
	}
	mem_free(bed);
}

void bed_sweep(struct bed *bed, const struct deform_contact *sweep, struct reference_forces *forces, double *lower)
{
	if (!bed->on_gpu) {
		bench_must(reference_sweep(&bed->ground, &bed->params, sweep, forces, lower));
		return;
	}
	struct deform_contact asked = *sweep;
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	struct deform_forces got = {.tag = 0};
	size_t count;
	bool taken;
	asked.tag = 1;
	bench_must(deform_windows(bed->deform, &asked, windows, &count));
	for (size_t i = 0; i < count; i++)
		bench_must(deform_compute(bed->deform, &asked, &windows[i], (uint32_t)i, bed->tiles, bed->tile_count));
	for (size_t i = 0; i < count; i++)
		bench_must(deform_scatter(bed->deform, &windows[i], (uint32_t)i, bed->tiles, bed->tile_count));
	bench_must(deform_forces_begin(bed->deform));
	bench_must(deform_forces_take(bed->deform, true, &got, &taken));
	*forces = (struct reference_forces){.normal = got.force[2], .area = got.area, .sinkage = got.sinkage};
	memcpy(forces->force, got.force, sizeof got.force);
	memcpy(forces->moment, got.moment, sizeof got.moment);
	*lower = lattice_offset_metres(sweep->to.z - got.z);
}
