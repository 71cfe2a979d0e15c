/*
 * Lists in the plan what a deform will make and run: programs, passes and memory. The file that makes or runs something also lists
 * it.
 */
#include "deform/internal.h"

static void add_program(void *user, const char *effect, const struct gpu_program_request *request)
{
	char name[GPU_PROGRAM_NAME];
	gpu_program_name(request, name, sizeof name);
	plan_add(user, &(struct plan_line){.kind = PLAN_PROGRAM, .effect = effect, .object = -1, .amount = 1}, name);
}

static void add_passes(struct plan *plan, const char *effect, int object, enum plan_unit unit, enum gpu_stage stage,
		       int amount)
{
	if (amount > 0)
		plan_add(plan, &(struct plan_line){.kind = PLAN_PASS, .unit = unit, .effect = effect, .object = object,
						   .amount = amount}, gpu_stage_name(stage));
}

void deform_plan_buffer(struct plan *plan, const char *effect, int64_t amount, uint64_t bytes, const char *name)
{
	plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .effect = effect, .object = -1, .amount = amount, .bytes = bytes},
		 name);
}

void deform_plan_planes(const struct deform_params *params, struct plan *plan)
{
	unsigned planes = deform_planes(params->model, params->disturbance, deform_memory(params));
	for (int plane = 0; plane < PLANES; plane++)
		if (planes & PLANE_BIT(plane))
			plan_add(plan, &(struct plan_line){.kind = PLAN_PLANE, .effect = deform_plane_effect(params->model, (enum plane)plane), .object = -1,
							   .amount = 1, .bytes = plane_bytes((enum plane)plane)},
				 plane_name((enum plane)plane));
}

/* Over one window of one object. */
static void plan_windows(const struct deform_params *params, const struct deform_planned *object, int number,
			 struct plan *plan)
{
	const char *displace = deform_displace_effect(params->model), *slide = deform_slide_effect(params->model);
	const bool elastic = deform_is_elastic(params->model);
	add_passes(plan, displace, number, PLAN_WINDOW, GPU_ENVELOPE, object->shape->kind == SOIL_MESH ? 0 : elastic ? 2 : 1);
	add_passes(plan, displace, number, PLAN_WINDOW, GPU_CONTACT, elastic ? 2 : 1);
	if (elastic)
		add_passes(plan, displace, number, PLAN_WINDOW, GPU_BEND, deform_sheet_passes(params));
	if (deform_model_row(params->model)->smooths && object->moves)
		add_passes(plan, deform_model_row(params->model)->effect.name, number, PLAN_MOVED, GPU_SMOOTH, params->box_repetitions);
	if (deform_conserves(params->model)) {
		add_passes(plan, "spread", number, PLAN_WINDOW, GPU_SPREAD, SPREAD_PASSES);
		add_passes(plan, slide, number, PLAN_WINDOW, GPU_SLIDE, deform_slide_passes(params, false));
	}
	if (params->disturbance)
		add_passes(plan, "dirt", number, PLAN_WINDOW, GPU_DISTURBANCE, 1);
	if (deform_marks(params) != 0)
		add_passes(plan, deform_marks_effect(params), number, PLAN_WINDOW, GPU_DISTURBANCE, 1);
}

/* The same stages in fixed regions. A contact that needs more than one window, or more than four tiles, is computed by windows. */
static void plan_regions(const struct deform_params *params, const struct deform_planned *object, int number, struct plan *plan)
{
	const char *displace = deform_displace_effect(params->model);
	add_passes(plan, displace, number, PLAN_REGION, GPU_ENVELOPE, object->shape->kind != SOIL_MESH);
	add_passes(plan, displace, number, PLAN_REGION, GPU_CONTACT, 1);
	if (deform_model_row(params->model)->smooths && object->moves)
		add_passes(plan, deform_model_row(params->model)->effect.name, number, PLAN_REGION_MOVED, GPU_SMOOTH, params->box_repetitions);
	if (params->disturbance)
		add_passes(plan, "dirt", number, PLAN_REGION, GPU_DISTURBANCE, 1);
}

/* What some of the objects call for, once. */
struct any {
	const char *facets; /* the effect that does; NULL: none */
	bool closed;        /* some are closed forms */
};

static void look(const struct deform_planned *object, struct any *any)
{
	const struct soil_shape *shape = object->shape;
	any->closed = any->closed || shape->kind != SOIL_MESH;
	if (any->facets == NULL && (shape->kind == SOIL_MESH || shape->grousers > 0))
		any->facets = shape->kind == SOIL_MESH ? "mesh" : "lugs";
}

static void plan_intervals(const struct deform_params *params, const struct any *any, struct plan *plan)
{
	const char *effect = deform_slide_effect(params->model);
	add_passes(plan, effect, -1, PLAN_ATLAS, GPU_SETTLE, deform_slide_passes(params, true));
	add_passes(plan, effect, -1, PLAN_HELD, GPU_HOLD, 1);
	if (any->closed)
		add_passes(plan, effect, -1, PLAN_RESTING, GPU_ENVELOPE, 1);
	deform_active_plan(effect, plan);
	deform_interval_plan(params, plan);
}

static void plan_batches(const struct deform_params *params, struct plan *plan)
{
	const char *displace = deform_displace_effect(params->model);
	deform_batch_plan(params, plan);
	add_passes(plan, displace, -1, PLAN_BATCH_ENVELOPE, GPU_ENVELOPE, 1);
	add_passes(plan, displace, -1, PLAN_BATCH_DRAW, GPU_CONTACT, 1);
	if (deform_model_row(params->model)->smooths) {
		const char *effect = deform_model_row(params->model)->effect.name;
		if (params->box_repetitions > 1)
			add_passes(plan, effect, -1, PLAN_BATCH, GPU_SMOOTH, params->box_repetitions - 1);
		add_passes(plan, effect, -1, PLAN_BATCH_STORE, GPU_SMOOTH, 1);
	} else {
		add_passes(plan, displace, -1, PLAN_BATCH_STORE, GPU_CONTACT, 1);
	}
	if (params->disturbance)
		add_passes(plan, "dirt", -1, PLAN_BATCH_STORE, GPU_DISTURBANCE, 1);
}

void deform_plan(const struct deform_params *params, const struct deform_planned *objects, size_t count, struct plan *plan)
{
	struct any any = {.facets = NULL};
	if (count == 0)
		return;
	deform_plan_planes(params, plan);
	for (size_t i = 0; i < count; i++) {
		deform_programs_each(params, &objects[i], add_program, plan);
		if (params->fixed)
			plan_regions(params, &objects[i], (int)i, plan);
		plan_windows(params, &objects[i], (int)i, plan);
		look(&objects[i], &any);
	}
	deform_scratch_plan(params, plan);
	deform_plan_buffer(plan, deform_displace_effect(params->model), 1, sizeof(struct deform_tally), "tally");
	if (params->batches && deform_model_row(params->model)->batch != NULL)
		plan_batches(params, plan);
	if (any.facets != NULL) {
		add_passes(plan, any.facets, -1, PLAN_FACETS, GPU_FACETS, 1);
		deform_facets_plan(any.facets, plan);
	}
	if (deform_conserves(params->model)) {
		deform_spread_plan(plan);
		plan_intervals(params, &any, plan);
	}
}

void deform_figures(const struct deform *deform, struct deform_figures *figures)
{
	*figures = deform->figures;
	figures->window_layers = deform_scratch_layers(deform);
}
