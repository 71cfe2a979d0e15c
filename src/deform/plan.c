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
	unsigned planes = deform_planes(params->model, params->disturbance, params->slip_sinkage > 0);
	for (int plane = 0; plane < PLANES; plane++)
		if (planes & PLANE_BIT(plane))
			plan_add(plan, &(struct plan_line){.kind = PLAN_PLANE, .effect = deform_plane_effect(params->model, (enum plane)plane), .object = -1,
							   .amount = 1, .bytes = plane_bytes((enum plane)plane)},
				 plane_name((enum plane)plane));
}

static bool is_loaded(const struct deform_params *params, const struct deform_planned *object)
{
	return deform_tells_forces(params->model) && object->load > 0;
}

/* True if a search runs before the object's contacts. */
static bool is_searched(const struct deform_params *params, const struct deform_planned *object)
{
	bool load = is_loaded(params, object);
	return load || deform_is_counted(params, object->shape, load);
}

/* Over one window of one object. */
static void plan_windows(const struct deform_params *params, const struct deform_planned *object, int number,
			 struct plan *plan)
{
	const char *displace = deform_displace_effect(params->model), *slide = deform_slide_effect(params->model);
	add_passes(plan, displace, number, PLAN_WINDOW, GPU_ENVELOPE, object->shape->kind != SOIL_MESH);
	add_passes(plan, is_loaded(params, object) ? "load" : displace, number, PLAN_WINDOW, GPU_LOAD, is_searched(params, object));
	add_passes(plan, displace, number, PLAN_WINDOW, GPU_CONTACT, 1);
	if (deform_model_row(params->model)->smooths && object->moves)
		add_passes(plan, deform_model_row(params->model)->effect.name, number, PLAN_MOVED, GPU_SMOOTH, params->box_repetitions);
	if (deform_conserves(params->model)) {
		add_passes(plan, "spread", number, PLAN_WINDOW, GPU_SPREAD, SPREAD_PASSES - (int)deform_spread_first(params->model));
		add_passes(plan, slide, number, PLAN_WINDOW, GPU_SLIDE, deform_slide_passes(params, false));
	}
	if (params->disturbance)
		add_passes(plan, "dirt", number, PLAN_WINDOW, GPU_DISTURBANCE, 1);
}

/* What some of the objects call for, once. */
struct any {
	const char *facets, *found, *forces; /* the effect that does; NULL: none */
	bool closed;                         /* some are closed forms */
};

static void look(const struct deform_params *params, const struct deform_planned *object, bool forces, struct any *any)
{
	const struct soil_shape *shape = object->shape;
	bool load = is_loaded(params, object);
	any->closed = any->closed || shape->kind != SOIL_MESH;
	if (any->facets == NULL && (shape->kind == SOIL_MESH || shape->grousers > 0))
		any->facets = shape->kind == SOIL_MESH ? "mesh" : "lugs";
	if (any->found == NULL && (load || deform_is_counted(params, shape, false)))
		any->found = load ? "load" : deform_displace_effect(params->model);
	if (any->forces == NULL && deform_tells_forces(params->model) && (load || forces))
		any->forces = "forces";
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

/* A batch of a model that conserves soil: together.c. Its lines are in two draws each. `search`: the effect of the search before contacts; NULL: none
 * needs one. */
static void plan_together(const struct deform_params *params, const char *search, struct plan *plan)
{
	const char *displace = deform_displace_effect(params->model);
	add_passes(plan, displace, -1, PLAN_BATCH_ENVELOPE, GPU_ENVELOPE, 1);
	add_passes(plan, displace, -1, PLAN_BATCH_DRAW, GPU_CONTACT, 1);
	if (search != NULL)
		add_passes(plan, search, -1, PLAN_BATCH_SEARCH, GPU_LOAD, 1);
	add_passes(plan, "spread", -1, PLAN_BATCH, GPU_SPREAD, SPREAD_PASSES - (int)deform_spread_first(params->model));
	add_passes(plan, deform_slide_effect(params->model), -1, PLAN_BATCH, GPU_SLIDE,
		   deform_slide_passes(params, false) + deform_line_passes(params));
	if (params->disturbance)
		add_passes(plan, "dirt", -1, PLAN_BATCH, GPU_DISTURBANCE, 1);
}

static void plan_batches(const struct deform_params *params, const struct any *any, struct plan *plan)
{
	const char *displace = deform_displace_effect(params->model);
	deform_batch_plan(params, plan);
	if (deform_conserves(params->model)) {
		plan_together(params, any->found, plan);
		return;
	}
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

void deform_plan(const struct deform_params *params, const struct deform_planned *objects, size_t count, bool forces,
		 struct plan *plan)
{
	struct any any = {.facets = NULL};
	if (count == 0)
		return;
	deform_plan_planes(params, plan);
	for (size_t i = 0; i < count; i++) {
		deform_programs_each(params, &objects[i], forces, add_program, plan);
		plan_windows(params, &objects[i], (int)i, plan);
		look(params, &objects[i], forces, &any);
	}
	deform_scratch_plan(params, plan);
	deform_plan_buffer(plan, deform_displace_effect(params->model), 1, sizeof(struct deform_tally), "tally");
	if (params->batches && deform_model_row(params->model)->batch != NULL)
		plan_batches(params, &any, plan);
	if (params->loaded_bodies > 0)
		deform_plan_buffer(plan, "load", 1, params->loaded_bodies * sizeof(int32_t), "heights of the loaded");
	if (any.facets != NULL) {
		add_passes(plan, any.facets, -1, PLAN_FACETS, GPU_FACETS, 1);
		deform_facets_plan(any.facets, plan);
	}
	if (any.found != NULL)
		deform_find_plan(any.found, plan);
	if (any.forces != NULL)
		deform_forces_plan(any.forces, plan);
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
