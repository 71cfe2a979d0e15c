/* Runs passes over an atlas of blocks. */
#include <assert.h>
#include <string.h>

#include "deform/internal.h"

#define PARAMS_MOST 12288
#define BLOCK_CELLS (SOIL_BLOCK / CELL * (SOIL_BLOCK / CELL))

/* std140 twin of the block in regions.vert. */
struct atlas_params {
	int32_t squares[ATLAS_MOST][4];
	uint8_t own[PARAMS_MOST];
};

static uint32_t regions_of(const struct slide_atlas *atlas, int64_t trim, int32_t squares[ATLAS_MOST][4])
{
	for (uint32_t i = 0; i < atlas->region_count; i++) {
		const int32_t *region = atlas->regions[i], by = (int32_t)trim;
		const int32_t square[4] = {region[0] + by, region[1] + by, (region[2] - 2 * by) | (region[3] - 2 * by) << 16};
		memcpy(squares[i], square, sizeof square);
	}
	return atlas->region_count;
}

static uint32_t blocks_of(const struct slide_atlas *atlas, int32_t squares[ATLAS_MOST][4])
{
	for (uint32_t i = 0; i < atlas->block_count; i++) {
		const int32_t *block = atlas->blocks[i];
		const int32_t square[4] = {block[0], block[1], SOIL_BLOCK | SOIL_BLOCK << 16, block[2]};
		memcpy(squares[i], square, sizeof square);
	}
	return atlas->block_count;
}

void deform_atlas_run(struct deform *deform, const struct slide_place *place, enum atlas_part part, int64_t trim, const struct gpu_pass *pass)
{
	const struct slide_atlas *atlas = place->atlas;
	struct gpu_pass own = *pass;
	own.viewport = place->all;
	own.instances = 1;
	if (atlas == NULL) {
		gpu_pass_run(deform->params.gpu, &own);
		return;
	}
	struct atlas_params params;
	assert(pass->params_bytes <= sizeof params.own);
	uint32_t quads = part == ATLAS_REGIONS ? regions_of(atlas, trim, params.squares) : blocks_of(atlas, params.squares);
	memcpy(params.own, pass->params, pass->params_bytes);
	own.params = &params;
	own.params_bytes = offsetof(struct atlas_params, own) + pass->params_bytes;
	own.indices = atlas->quads;
	own.index_count = 6 * (part == ATLAS_CELLS ? CELLS_ACROSS * CELLS_ACROSS : part == ATLAS_BLOCK_CELLS ? BLOCK_CELLS * quads : quads);
	if (part == ATLAS_CELLS || part == ATLAS_BLOCK_CELLS)
		own.textures[0] = atlas->cells;
	gpu_pass_run(deform->params.gpu, &own);
}
