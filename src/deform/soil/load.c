/*
 * Two numbers that scm needs before its contact pass: how many posts the object touches, and its equilibrium height. They
 * depend on the ground. One compute pass of one work group searches both on the GPU (scm_find.comp). Nothing is read back.
 */
#include <assert.h>

#include "deform/internal.h"

/* Fills the textures, images and buffers of the search. */
static void bind(struct deform *deform, enum soil_shape_kind kind, struct gpu_buffer *tally, struct gpu_buffer *found, struct gpu_pass *pass)
{
	bool posts_only = kind == SOIL_MESH; /* lib/soil.glsl */
	*pass = (struct gpu_pass){
		.stage = GPU_LOAD,
		.textures = {deform->under, deform->classes, deform->numbers, posts_only ? deform->bases : deform->rest},
		.images = {deform->planes_of[0][PLANE_DUG], deform->planes_of[1][PLANE_DEPOSITED], posts_only ? deform->rest : deform->bases, NULL,
			   deform->planes_of[0][PLANE_PLASTIC_SINKAGE], deform->planes_of[0][PLANE_SHEAR], NULL, deform->carried},
		.storage = {tally, NULL, found, deform->standing},
	};
}

enum status deform_find(struct deform *deform, const struct scm_params *params, unsigned what, enum soil_shape_kind kind,
			struct gpu_buffer *tally)
{
	struct gpu_program **program = &deform->find[0][FIND_SHAPE * kind + what];
	struct deform_request request;
	deform_programs_find(&deform->params, what, kind, false, &request);
	enum status status = deform_program(deform, &request, program);
	if (status == STATUS_OK && deform->found == NULL)
		status = gpu_buffer_create(deform->params.gpu, GPU_STORAGE, DEFORM_FOUND_BYTES, NULL, &deform->found);
	if (status != STATUS_OK)
		return status;
	struct gpu_pass pass;
	bind(deform, kind, tally, deform->found, &pass);
	pass.program = *program;
	pass.groups = 1;
	pass.params = params;
	pass.params_bytes = sizeof *params;
	gpu_pass_run(deform->params.gpu, &pass);
	return STATUS_OK;
}

enum status deform_find_together(struct deform *deform, const struct scm_params *params, unsigned what, enum soil_shape_kind kind, uint32_t count)
{
	struct gpu_program **program = &deform->find[1][FIND_SHAPE * kind + what];
	struct gpu_pass pass;
	struct deform_request request;
	deform_programs_find(&deform->params, what, kind, true, &request);
	enum status status = deform_program(deform, &request, program);
	if (status != STATUS_OK)
		return status;
	bind(deform, kind, deform->tally, deform_together_found(deform), &pass);
	pass.program = *program;
	pass.params = params;
	pass.params_bytes = sizeof *params;
	deform_together_compute(deform, count, &pass);
	deform->figures.batch_searches++;
	return STATUS_OK;
}

void deform_find_plan(const char *effect, struct plan *plan)
{
	deform_plan_buffer(plan, effect, 1, DEFORM_FOUND_BYTES, "equilibrium");
}

void deform_set_equilibrium(struct deform *deform, uint32_t loaded_body, int32_t raised)
{
	assert(loaded_body > 0 && loaded_body <= deform->params.loaded_bodies);
	gpu_buffer_write(deform->standing, (loaded_body - 1) * sizeof raised, sizeof raised, &raised);
}
