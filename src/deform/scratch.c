/*
 * Makes the textures in which windows are computed. Each texture is an array with one layer for each window. It grows when a
 * contact needs more layers.
 */
#include <stddef.h>
#include <string.h>

#include "deform/internal.h"

/* One of these textures. */
struct row {
	const char *name, *effect; /* for the plan: its name, and the effect that needs it */
	enum gpu_format format;
	size_t place; /* offset of its pointer in struct deform */
};
struct rows {
	struct row list[14 + 2 * PLANES];
	size_t count;
};

#define PLACE(member) offsetof(struct deform, member)

bool deform_needs_contacts(const struct deform_params *params)
{
	return !deform_model_row(params->model)->blind || params->disturbance || deform_marks(params) != 0;
}

bool deform_has_classes(const struct deform_params *params)
{
	return deform_conserves(params->model) && params->soil_count > 1;
}

static void add(struct rows *rows, bool wanted, struct row row)
{
	if (wanted)
		rows->list[rows->count++] = row;
}

static enum gpu_format format_of(enum plane plane)
{
	return plane_bytes(plane) == 1 ? GPU_R8UI : GPU_R32I;
}

/* The only list of the textures: deform_need_layers makes them, and deform_scratch_plan plans them. */
static void rows_of(const struct deform_params *params, struct rows *rows)
{
	const char *displace = deform_displace_effect(params->model), *slide = deform_slide_effect(params->model);
	const bool plants = deform_model_row(params->model)->blind && !params->disturbance && params->heals == 0;
	const char *touched = plants ? "vegetation" : deform_contact_effect(params->model);
	bool contacts = deform_needs_contacts(params), conserves = deform_conserves(params->model);
	unsigned planes = deform_planes(params->model, params->disturbance, deform_marks(params));
	rows->count = 0;
	add(rows, true, (struct row){"window's base", displace, GPU_R32I, PLACE(bases)});
	add(rows, true, (struct row){"under", displace, GPU_R32I, PLACE(under)});
	add(rows, contacts, (struct row){"rest", touched, GPU_R32I, PLACE(rest)});
	add(rows, contacts, (struct row){"contacts", touched, GPU_R8UI, PLACE(contacts)});
	add(rows, deform_is_elastic(params->model), (struct row){"bent", displace, GPU_R32I, PLACE(bent)});
	add(rows, deform_is_elastic(params->model), (struct row){"holders", displace, GPU_R32I, PLACE(holders)});
	add(rows, conserves, (struct row){"carried", "spread", GPU_R32I, PLACE(carried)});
	add(rows, conserves, (struct row){"deposits", "spread", GPU_R32I, PLACE(deposits)});
	add(rows, conserves, (struct row){"heights", slide, GPU_R32I, PLACE(heights[0])});
	add(rows, conserves, (struct row){"heights", slide, GPU_R32I, PLACE(heights[1])});
	add(rows, conserves, (struct row){"stills", slide, GPU_R8UI, PLACE(stills)});
	add(rows, conserves && deform_is_bounded(params), (struct row){"floors", slide, GPU_R32I, PLACE(floors)});
	add(rows, conserves && params->roofs, (struct row){"roofs", slide, GPU_R32I, PLACE(roofs)});
	add(rows, deform_has_classes(params), (struct row){"window's classes", "soil_map", GPU_R8UI, PLACE(classes)});
	for (int plane = 0; plane < PLANES; plane++)
		for (int i = 0; i < 2; i++)
			add(rows, (planes & PLANE_BIT(plane)) != 0,
			    (struct row){plane_name((enum plane)plane), deform_plane_effect(params->model, (enum plane)plane), format_of((enum plane)plane),
					 PLACE(planes_of[0][0]) + (size_t)(i * PLANES + plane) * sizeof(struct gpu_texture *)});
	add(rows, deform_has_slopes(params), (struct row){plane_name(PLANE_SLOPE), slide, GPU_R32I, PLACE(planes_of[1][PLANE_SLOPE])});
}

static struct gpu_texture **place_of(struct deform *deform, const struct row *row)
{
	return (struct gpu_texture **)((char *)deform + row->place);
}

/* Returns how many layers the textures have beside the windows' layers: 1 for the atlas, or 0. */
static uint32_t beside_windows(const struct deform_params *params)
{
	return deform_conserves(params->model);
}

void deform_scratch_plan(const struct deform_params *params, struct plan *plan)
{
	struct rows rows;
	rows_of(params, &rows);
	for (size_t i = 0; i < rows.count; i++) {
		const struct row *row = &rows.list[i];
		uint64_t layer = (uint64_t)SIDE * SIDE * gpu_format_bytes(row->format);
		struct plan_line line = {.kind = PLAN_TEXTURE, .unit = PLAN_ONCE, .effect = row->effect, .object = -1, .amount = 1,
					 .bytes = layer * beside_windows(params)};
		plan_add(plan, &line, row->name);
		/* Another layer adds bytes, but no texture. */
		line.unit = PLAN_WINDOW_LAYER;
		line.amount = 0;
		line.bytes = layer;
		plan_add(plan, &line, row->name);
	}
}

void deform_drop_layers(struct deform *deform)
{
	struct rows rows;
	for (uint32_t i = 0; i <= DEFORM_WINDOWS_MAX; i++) {
		for (int k = 0; k < SCRATCH_TARGETS; k++)
			gpu_target_destroy(deform->scratch[i].to[k]);
		memset(&deform->scratch[i], 0, sizeof deform->scratch[i]);
	}
	rows_of(&deform->params, &rows);
	for (size_t i = 0; i < rows.count; i++) {
		struct gpu_texture **texture = place_of(deform, &rows.list[i]);
		gpu_texture_destroy(*texture);
		*texture = NULL;
	}
	deform->layers = 0;
}

static enum status make_textures(struct deform *deform, uint32_t layers)
{
	struct rows rows;
	rows_of(&deform->params, &rows);
	for (size_t i = 0; i < rows.count; i++)
		TRY(gpu_texture_create(deform->params.gpu, rows.list[i].format, deform->side, deform->side, layers, place_of(deform, &rows.list[i])));
	return STATUS_OK;
}

struct attachments {
	struct gpu_attachment list[8];
	uint32_t count;
};

/* Adds an attachment. Does nothing if the texture is NULL, which means that it is not needed. */
static void attach(struct attachments *to, struct gpu_texture *texture, uint32_t layer)
{
	if (texture != NULL)
		to->list[to->count++] = (struct gpu_attachment){texture, layer};
}

static enum status make_targets(struct deform *deform, uint32_t number, bool atlas)
{
	struct gpu *gpu = deform->params.gpu;
	struct attachments of[SCRATCH_TARGETS] = {{.count = 0}};
	attach(&of[TO_UNDER], deform->under, number);
	attach(&of[TO_UNDER], deform->rest, number);
	attach(&of[TO_CONTACT], deform->planes_of[1][PLANE_OFFSET], number);
	attach(&of[TO_CONTACT], deform->contacts, number);
	attach(&of[TO_CONTACT], deform->carried, number);
	attach(&of[TO_CONTACT], deform->bent, number);
	attach(&of[TO_CONTACT], deform->holders, number);
	if (deform_is_elastic(deform->params.model))
		attach(&of[TO_FREED], deform->planes_of[1][PLANE_FLOOR], number);
	for (int i = 0; i < 2 && deform_model_row(deform->params.model)->smooths; i++)
		attach(&of[TO_FIRST + i], deform->planes_of[i][PLANE_OFFSET], number);
	bool conserves = deform_conserves(deform->params.model);
	if (conserves) {
		attach(&of[TO_BEGUN], deform->heights[0], number);
		attach(&of[TO_BEGUN], deform->stills, number);
		attach(&of[TO_BEGUN], deform->floors, number);
		attach(&of[TO_HELD], deform->contacts, number);
		attach(&of[TO_HEIGHTS_0], deform->heights[0], number);
		attach(&of[TO_HEIGHTS_1], deform->heights[1], number);
		if (deform_model_row(deform->params.model)->slide->pass_count > 1)
			attach(&of[TO_SHED], deform->carried, number);
		if (atlas && deform_has_slopes(&deform->params)) {
			attach(&of[TO_SLOPES_FIRST], deform->deposits, number);
			attach(&of[TO_SLOPES_FIRST], deform->carried, number);
			attach(&of[TO_SLOPES_0], deform->under, number);
			attach(&of[TO_SLOPES_1], deform->deposits, number);
		}
	}
	attach(&of[TO_DISTURBANCE], deform->planes_of[1][PLANE_DISTURBANCE], number);
	for (int plane = PLANE_HEALED; plane <= PLANE_GROWN; plane++)
		attach(&of[TO_MARKS], deform->planes_of[1][plane], number);
	for (int k = 0; k < SCRATCH_TARGETS; k++)
		if (of[k].count > 0)
			TRY(gpu_target_create(gpu, of[k].list, of[k].count, (struct gpu_attachment){NULL, 0}, &deform->scratch[number].to[k]));
	return gpu_target_create_bare(gpu, deform->side, deform->side, &deform->scratch[number].to[TO_BARE]);
}

/* Makes the textures with `layers` layers, and the targets of each layer. Layer `atlas` is the atlas, if it is below `layers`. */
static enum status make_layers(struct deform *deform, uint32_t layers, uint32_t atlas)
{
	TRY(make_textures(deform, layers));
	for (uint32_t i = 0; i < layers; i++)
		TRY(make_targets(deform, i, i == atlas));
	return STATUS_OK;
}

enum status deform_need_layers(struct deform *deform, uint32_t layers, uint32_t side)
{
	if (layers <= deform->layers && side <= deform->side)
		return STATUS_OK;
	/* Growing loses the content of the layers. So a contact grows them before its first window. */
	layers = layers > deform->layers ? layers : deform->layers;
	deform_drop_layers(deform);
	deform->side = side > deform->side ? side : deform->side;
	enum status status = make_layers(deform, layers + beside_windows(&deform->params), layers);
	if (status != STATUS_OK) {
		deform_drop_layers(deform);
		return status;
	}
	deform->layers = layers;
	return STATUS_OK;
}

uint64_t deform_scratch_layers(const struct deform *deform)
{
	uint32_t beside = beside_windows(&deform->params), times = deform->side / SIDE;
	return (uint64_t)(deform->layers + beside) * times * times - beside;
}
