/*
 * Two numbers that scm needs before its contact pass: how many posts the object touches, and its equilibrium height. They
 * depend on the ground. Both are searched on the GPU, with one pass for each try. Nothing is read back.
 *
 * A try sums over the window. In the next pass each invocation computes the next height to try from these sums
 * (lib/found.glsl). So no invocation waits for another. Once the height is found, the remaining tries read no post.
 */
#include <assert.h>
#include <math.h>

#include "deform/internal.h"

#define TRIES 32 /* enough to halve a bracket of 2^26 fixed-point units, 64 m, to one unit; most soils need four */

struct attempt {
	uint32_t words[12]; /* lib/found.glsl */
};

static enum status find_program(struct deform *deform, enum find_what what, bool patch, enum deform_shape_kind kind,
				struct gpu_program **program)
{
	struct gpu_program **place = &deform->find[4 * (int)kind + (int)what + (what == FIND_BEARS && patch)];
	struct deform_request request;
	deform_programs_find(&deform->params, what, patch, kind, &request);
	enum status status = deform_program(deform, &request, place);
	*program = *place;
	return status;
}

static void run(struct deform *deform, struct gpu_program *program, const struct scm_params *params, uint32_t layer, int try)
{
	struct scm_params now = *params;
	now.zero[3] = try;
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_LOAD,
		.program = program,
		.target = deform->scratch[layer].to[TO_BARE],
		.viewport = deform_rows(now.shadow),
		.textures = {deform->under, deform->classes},
		.images = {deform->bases, deform->planes_of[1][PLANE_DEPOSITED], deform->rest,
			   deform->planes_of[0][PLANE_PLASTIC_SINKAGE], deform->planes_of[0][PLANE_SHEAR]},
		.storage = {[2] = deform->tries},
		.params = &now,
		.params_bytes = sizeof now,
	});
}

enum status deform_find(struct deform *deform, const struct scm_params *params, uint32_t layer, unsigned what,
			enum deform_shape_kind kind, int *last)
{
	bool patch = what & DEFORM_FIND_PATCH, load = what & DEFORM_FIND_LOAD;
	struct gpu_program *gap = NULL, *count = NULL, *bears = NULL;
	enum status status = STATUS_OK;
	*last = load ? TRIES - 1 : 0;
	if (deform->tries == NULL)
		status = gpu_buffer_create(deform->params.gpu, GPU_STORAGE, TRIES * sizeof(struct attempt), NULL, &deform->tries);
	if (status == STATUS_OK && load)
		status = find_program(deform, FIND_GAP, false, kind, &gap);
	if (status == STATUS_OK && load)
		status = find_program(deform, FIND_BEARS, patch, kind, &bears);
	if (status == STATUS_OK && patch)
		status = find_program(deform, FIND_COUNT, false, kind, &count);
	if (status != STATUS_OK)
		return status;
	gpu_buffer_clear(deform->tries, 0, TRIES * sizeof(struct attempt));
	if (load)
		run(deform, gap, params, layer, 0);
	for (int try = 1; try < *last; try++) {
		if (patch)
			run(deform, count, params, layer, try);
		run(deform, bears, params, layer, try);
	}
	/* The contact pass is the last try, so its patch is counted here. */
	if (patch)
		run(deform, count, params, layer, *last);
	return STATUS_OK;
}

/* Returns the number of passes of a search. Try 0 finds the first contact. The last try is the contact pass itself, but its patch
 * is counted here. */
int deform_find_passes(bool patch, bool load)
{
	return load ? 1 + (TRIES - 2) * (1 + patch) + patch : patch;
}

void deform_find_plan(const char *effect, struct plan *plan)
{
	deform_plan_buffer(plan, effect, 1, TRIES * sizeof(struct attempt), "tries");
}

void deform_set_equilibrium(struct deform *deform, uint32_t loaded_body, int32_t raised)
{
	assert(loaded_body > 0 && loaded_body <= deform->params.loaded_bodies);
	gpu_buffer_write(deform->standing, (loaded_body - 1) * sizeof raised, sizeof raised, &raised);
}

double deform_sinkage_guess(const struct deform_shape *shape, const struct deform_soil *soil, double load)
{
	double n = soil->bekker_n, sinkage;
	if (shape->kind == DEFORM_BOX) {
		double width = fmin(shape->size[0], shape->size[1]), k = soil->bekker_kc / width + soil->bekker_kphi;
		sinkage = pow(load / (shape->size[0] * shape->size[1] * k), 1 / n);
	} else if (shape->kind == DEFORM_MESH) {
		sinkage = 0;
	} else {
		double width = shape->kind == DEFORM_WHEEL ? shape->width : shape->radius;
		double k = soil->bekker_kc / width + soil->bekker_kphi;
		sinkage = pow(3 * load / (width * k * fmax(3 - n, 0.1) * sqrt(2 * shape->radius)), 2 / (2 * n + 1));
	}
	double most = deform_shape_reach(shape, 0, 0);
	return sinkage < most ? sinkage : most;
}
