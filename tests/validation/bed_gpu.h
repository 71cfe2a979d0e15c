/*
 * The GPU's kind of bed: whole tiles from the world's south-western corner on, those posts without data that the bed does
 * not have. Its sums are exact: that nothing is lost is checked after whatever happens to it.
 */
#ifndef FURROW_TESTS_VALIDATION_BED_GPU_H
#define FURROW_TESTS_VALIDATION_BED_GPU_H

#include "bed.h"

#define BED_CELLS 64

struct bed_gpu {
	struct ground ground;
	struct bed_params params;
	int32_t *pressed;
	bool read; /* ground.offset is what the GPU has */
};

static const struct bed_params *bed_gpu_made; /* while it is made */

static int32_t bed_gpu_height(int64_t x, int64_t y)
{
	if (x >= bed_gpu_made->width || y >= bed_gpu_made->height)
		return BASE_NODATA;
	return bed_gpu_made->ground == NULL ? 0 : (int32_t)lattice_base(bed_gpu_made->ground((int)x, (int)y));
}

static void *bed_gpu_make(const struct bed_params *params)
{
	need_gpu();
	struct bed_gpu *bed = mem_calloc(1, sizeof *bed);
	assert_non_null(bed);
	bed->params = *params;
	bed_gpu_made = params;
	int most = params->width > params->height ? params->width : params->height;
	ground_init(&bed->ground, &(struct ground_params){
		.cells = BED_CELLS, .tiles = (uint32_t)((most + BED_CELLS - 2) / BED_CELLS), .spacing = params->spacing,
		.height = bed_gpu_height, .model = params->deform.model, .soils = params->deform.soils,
		.soil_count = params->deform.soil_count, .iterations = params->deform.iterations, .depth = params->deform.depth,
		.bulldozing = params->deform.bulldozing});
	bed->pressed = ground_room(bed->ground.posts * bed->ground.posts, sizeof *bed->pressed);
	return bed;
}

static void bed_gpu_destroy(void *user)
{
	struct bed_gpu *bed = user;
	ground_finish(&bed->ground);
	mem_free(bed->pressed);
	mem_free(bed);
}

/* Of what is pressed since, J: the soil yielded along Bekker's curve. */
static double bed_gpu_work(struct bed_gpu *bed, const struct soil_shape *shape)
{
	const struct soil_numbers *soil = &bed->params.deform.soils[0];
	double width = shape->kind == SOIL_WHEEL ? shape->width : fmin(shape->size[0], shape->size[1]);
	double power = soil->bekker_n + 1, sum = 0;
	int32_t *now = ground_room((BED_CELLS + 1) * (BED_CELLS + 1), sizeof *now);
	for (uint32_t k = 0; k < bed->ground.tile_count; k++) {
		int32_t *before = bed->pressed + k / bed->ground.params.tiles * BED_CELLS * bed->ground.posts +
				  k % bed->ground.params.tiles * BED_CELLS;
		assert_ok(staged_read_planes(test_gpu, bed->ground.slots, BED_CELLS, k, (void *[PLANES]){[PLANE_PLASTIC_SINKAGE] = now}));
		for (int64_t i = 0; i < (BED_CELLS + 1) * (BED_CELLS + 1); i++) {
			int32_t *at = before + i / (BED_CELLS + 1) * bed->ground.posts + i % (BED_CELLS + 1);
			sum += pow(lattice_offset_metres(now[i]), power) - pow(lattice_offset_metres(*at), power);
			*at = now[i];
		}
	}
	mem_free(now);
	return reference_stiffness(soil, width) * sum / power * bed->params.spacing * bed->params.spacing;
}

static double bed_gpu_volume(void *user)
{
	struct bed_gpu *bed = user;
	struct deform_tally tally;
	int64_t sum = 0;
	if (!bed->read)
		ground_read(&bed->ground);
	bed->read = true;
	for (int64_t i = 0; i < bed->ground.posts * bed->ground.posts; i++)
		sum += bed->ground.offset[i];
	assert_ok(deform_tally(bed->ground.deform, &tally));
	assert_int_equal(sum + tally.compacted, 0);
	assert_int_equal(tally.refused, 0);
	return lattice_offset_metres(sum + tally.compacted) * bed->params.spacing * bed->params.spacing;
}

static void bed_gpu_sweep(void *user, const struct deform_contact *sweep, struct reference_forces *forces, double *lower)
{
	struct bed_gpu *bed = user;
	struct deform_contact asked = *sweep;
	struct deform_forces got;
	bool taken;
	asked.tag = 1;
	bed->read = false;
	ground_sweep(&bed->ground, &asked);
	assert_ok(deform_forces_begin(bed->ground.deform));
	assert_ok(deform_forces_take(bed->ground.deform, true, &got, &taken));
	assert_true(taken && got.state != DEFORM_SUNK && got.saturated == 0);
	/* On level ground shear is level, and all that bears is normal stress. */
	*forces = (struct reference_forces){.normal = got.force[2], .area = got.area, .sinkage = got.sinkage};
	memcpy(forces->force, got.force, sizeof got.force);
	memcpy(forces->moment, got.moment, sizeof got.moment);
	forces->work = bed_gpu_work(bed, sweep->shape);
	*lower = lattice_offset_metres(sweep->to.z - got.z);
	bed_gpu_volume(bed);
}

/* To the last quantum. */
static void bed_gpu_settle(void *user, double tolerance)
{
	struct bed_gpu *bed = user;
	struct deform *deform = bed->ground.deform;
	size_t blocks = 1;
	(void)tolerance;
	bed->read = false;
	assert_ok(deform_wake(deform, (struct post_rect){0, 0, bed->ground.posts, bed->ground.posts}));
	for (int n = 0; n < 100000 && blocks > 0; n++) {
		blocks = ground_interval(&bed->ground, NULL, 0).blocks;
		gpu_finish(test_gpu);
	}
	assert_int_equal(blocks, 0);
}

static double bed_gpu_surface(void *user, int x, int y)
{
	struct bed_gpu *bed = user;
	int64_t at = y * bed->ground.posts + x;
	if (!bed->read)
		ground_read(&bed->ground);
	bed->read = true;
	return lattice_base_metres(bed->ground.base[at]) + lattice_offset_metres(bed->ground.offset[at]);
}

/* Stress: exp2 and log2 in single precision. */
static const struct bed_kind bed_gpu = {
	0x1p-20, 0x1p-15, 1e-5, bed_gpu_make, bed_gpu_destroy, bed_gpu_sweep,
	bed_gpu_settle, bed_gpu_surface, bed_gpu_volume,
};

/* The kinds, each test with each of them. The program's group opens and closes the GPU. */
#define bed_tests(test)                                              \
	{#test " (reference)", test, NULL, NULL, (void *)&bed_reference}, \
		{#test " (gpu)", test, NULL, NULL, (void *)&bed_gpu}

#endif
