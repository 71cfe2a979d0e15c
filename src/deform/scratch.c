/* The windows' textures: arrays of one layer a window, made when a sweep first needs so many. */
#include <string.h>

#include "deform/internal.h"

void deform_drop_layers(struct deform *deform)
{
	for (uint32_t i = 0; i < DEFORM_WINDOWS_MAX; i++) {
		struct layer *layer = &deform->scratch[i];
		gpu_target_destroy(layer->displaced);
		gpu_target_destroy(layer->filtered[0]);
		gpu_target_destroy(layer->filtered[1]);
		gpu_target_destroy(layer->dirtied);
		memset(layer, 0, sizeof *layer);
	}
	struct gpu_texture **textures[] = {&deform->bases,	 &deform->offsets[0], &deform->offsets[1],
					   &deform->contacts, &deform->dirts[0],   &deform->dirts[1]};
	for (size_t i = 0; i < sizeof textures / sizeof *textures; i++) {
		gpu_texture_destroy(*textures[i]);
		*textures[i] = NULL;
	}
	deform->layers = 0;
}

static bool needs_contacts(const struct deform *deform)
{
	return deform->params.model == DEFORM_BOX_FILTER || deform->params.dirt;
}

static enum status make_textures(struct deform *deform, uint32_t layers)
{
	struct gpu *gpu = deform->params.gpu;
	enum status status = gpu_texture_create(gpu, GPU_R32I, SIDE, SIDE, layers, &deform->bases);
	for (int i = 0; i < 2 && status == STATUS_OK; i++)
		status = gpu_texture_create(gpu, GPU_R32I, SIDE, SIDE, layers, &deform->offsets[i]);
	if (status == STATUS_OK && needs_contacts(deform))
		status = gpu_texture_create(gpu, GPU_R8UI, SIDE, SIDE, layers, &deform->contacts);
	for (int i = 0; i < 2 && status == STATUS_OK && deform->params.dirt; i++)
		status = gpu_texture_create(gpu, GPU_R8UI, SIDE, SIDE, layers, &deform->dirts[i]);
	return status;
}

static enum status make_targets(struct deform *deform, uint32_t number)
{
	struct gpu *gpu = deform->params.gpu;
	struct layer *layer = &deform->scratch[number];
	const struct gpu_attachment none = {NULL, 0};
	struct gpu_attachment colours[2] = {{deform->offsets[1], number}, {deform->contacts, number}};
	enum status status =
		gpu_target_create(gpu, colours, needs_contacts(deform) ? 2 : 1, none, &layer->displaced);
	for (int i = 0; i < 2 && status == STATUS_OK && deform->params.model == DEFORM_BOX_FILTER; i++) {
		struct gpu_attachment offsets = {deform->offsets[i], number};
		status = gpu_target_create(gpu, &offsets, 1, none, &layer->filtered[i]);
	}
	struct gpu_attachment dirt = {deform->dirts[1], number};
	if (status == STATUS_OK && deform->params.dirt)
		status = gpu_target_create(gpu, &dirt, 1, none, &layer->dirtied);
	return status;
}

enum status deform_need_layers(struct deform *deform, uint32_t layers)
{
	if (layers <= deform->layers)
		return STATUS_OK;
	/* Growing loses what the layers hold: a sweep grows them before its first window. */
	deform_drop_layers(deform);
	enum status status = make_textures(deform, layers);
	for (uint32_t i = 0; i < layers && status == STATUS_OK; i++)
		status = make_targets(deform, i);
	if (status == STATUS_OK)
		deform->layers = layers;
	else
		deform_drop_layers(deform);
	return status;
}
