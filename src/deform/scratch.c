/* The windows' textures: arrays of one layer a window, made when a sweep first needs so many. */
#include <string.h>

#include "deform/internal.h"

void deform_drop_layers(struct deform *deform)
{
	for (uint32_t i = 0; i <= DEFORM_WINDOWS_MAX; i++) {
		for (int k = 0; k < SCRATCH_TARGETS; k++)
			gpu_target_destroy(deform->scratch[i].to[k]);
		memset(&deform->scratch[i], 0, sizeof deform->scratch[i]);
	}
	struct gpu_texture **textures[] = {&deform->bases, &deform->under, &deform->rest, &deform->contacts,
					   &deform->carried, &deform->deposits, &deform->classes,
					   &deform->heights[0], &deform->heights[1], &deform->stills, &deform->floors};
	for (size_t i = 0; i < sizeof textures / sizeof *textures; i++) {
		gpu_texture_destroy(*textures[i]);
		*textures[i] = NULL;
	}
	for (int i = 0; i < 2; i++)
		for (int plane = 0; plane < PLANES; plane++) {
			gpu_texture_destroy(deform->planes_of[i][plane]);
			deform->planes_of[i][plane] = NULL;
		}
	deform->layers = 0;
}

bool deform_needs_contacts(const struct deform *deform)
{
	return deform->params.model != DEFORM_NONE || deform->params.dirt;
}

static enum gpu_format format_of(enum plane plane)
{
	return plane_bytes(plane) == 1 ? GPU_R8UI : plane_bytes(plane) == 2 ? GPU_R16UI : GPU_R32I;
}

static enum status make_sliding(struct deform *deform, uint32_t layers)
{
	const struct {
		struct gpu_texture **texture;
		enum gpu_format format;
		bool wanted;
	} all[] = {
		{&deform->carried, GPU_R32I, true},    {&deform->deposits, GPU_R32I, true},
		{&deform->heights[0], GPU_R32I, true}, {&deform->heights[1], GPU_R32I, true},
		{&deform->stills, GPU_R8UI, true},     {&deform->floors, GPU_R32I, deform_is_bounded(deform)},
		{&deform->classes, GPU_R8UI, deform->params.soil_count > 1},
	};
	enum status status = STATUS_OK;
	for (size_t i = 0; i < sizeof all / sizeof *all && status == STATUS_OK; i++)
		if (all[i].wanted)
			status = gpu_texture_create(deform->params.gpu, all[i].format, SIDE, SIDE, layers, all[i].texture);
	return status;
}

static enum status make_textures(struct deform *deform, uint32_t layers)
{
	struct gpu *gpu = deform->params.gpu;
	enum status status = gpu_texture_create(gpu, GPU_R32I, SIDE, SIDE, layers, &deform->bases);
	if (status == STATUS_OK)
		status = gpu_texture_create(gpu, GPU_R32I, SIDE, SIDE, layers, &deform->under);
	if (status == STATUS_OK && deform_needs_contacts(deform))
		status = gpu_texture_create(gpu, GPU_R32I, SIDE, SIDE, layers, &deform->rest);
	if (status == STATUS_OK && deform_needs_contacts(deform))
		status = gpu_texture_create(gpu, GPU_R8UI, SIDE, SIDE, layers, &deform->contacts);
	if (status == STATUS_OK && deform_conserves(deform->params.model))
		status = make_sliding(deform, layers);
	for (int plane = 0; plane < PLANES; plane++)
		for (int i = 0; i < 2 && status == STATUS_OK && (deform->planes & PLANE_BIT(plane)); i++)
			status = gpu_texture_create(gpu, format_of((enum plane)plane), SIDE, SIDE, layers,
						    &deform->planes_of[i][plane]);
	return status;
}

struct attachments {
	struct gpu_attachment list[8];
	uint32_t count;
};

/* NULL: not called for. */
static void attach(struct attachments *to, struct gpu_texture *texture, uint32_t layer)
{
	if (texture != NULL)
		to->list[to->count++] = (struct gpu_attachment){texture, layer};
}

static enum status make_targets(struct deform *deform, uint32_t number)
{
	struct gpu *gpu = deform->params.gpu;
	struct attachments of[SCRATCH_TARGETS] = {{.count = 0}};
	attach(&of[TO_UNDER], deform->under, number);
	attach(&of[TO_UNDER], deform->rest, number);
	attach(&of[TO_PRESSED], deform->planes_of[1][PLANE_OFFSET], number);
	attach(&of[TO_PRESSED], deform->contacts, number);
	attach(&of[TO_PRESSED], deform->carried, number);
	for (int i = 0; i < 2 && deform->params.model == DEFORM_BOX_FILTER; i++)
		attach(&of[TO_FIRST + i], deform->planes_of[i][PLANE_OFFSET], number);
	bool conserves = deform_conserves(deform->params.model);
	if (conserves) {
		attach(&of[TO_BEGUN], deform->planes_of[0][PLANE_OFFSET], number);
		attach(&of[TO_BEGUN], deform->heights[0], number);
		attach(&of[TO_BEGUN], deform->stills, number);
		attach(&of[TO_BEGUN], deform->planes_of[0][PLANE_HEAPED], number);
		attach(&of[TO_BEGUN], deform->floors, number);
		attach(&of[TO_HELD], deform->contacts, number);
		attach(&of[TO_HEIGHTS_0], deform->heights[0], number);
		attach(&of[TO_HEIGHTS_1], deform->heights[1], number);
		if (deform->params.model == DEFORM_SUMNER)
			attach(&of[TO_SHED], deform->carried, number);
		attach(&of[TO_SLID], deform->planes_of[1][PLANE_OFFSET], number);
		attach(&of[TO_SLID], deform->planes_of[1][PLANE_HEAPED], number);
	}
	attach(&of[TO_DIRT], deform->planes_of[1][PLANE_DIRT], number);
	enum status status = STATUS_OK;
	for (int k = 0; k < SCRATCH_TARGETS && status == STATUS_OK; k++)
		if (of[k].count > 0)
			status = gpu_target_create(gpu, of[k].list, of[k].count, (struct gpu_attachment){NULL, 0},
						   &deform->scratch[number].to[k]);
	if (status == STATUS_OK)
		status = gpu_target_create_bare(gpu, SIDE, SIDE, &deform->scratch[number].to[TO_BARE]);
	return status;
}

enum status deform_need_layers(struct deform *deform, uint32_t layers)
{
	if (layers <= deform->layers)
		return STATUS_OK;
	/* Growing loses what the layers hold: a sweep grows them before its first window. */
	deform_drop_layers(deform);
	uint32_t all = layers + deform_conserves(deform->params.model); /* and the atlas */
	enum status status = make_textures(deform, all);
	for (uint32_t i = 0; i < all && status == STATUS_OK; i++)
		status = make_targets(deform, i);
	if (status == STATUS_OK)
		deform->layers = layers;
	else
		deform_drop_layers(deform);
	return status;
}
