/* The dissertation's smoothing (5.5): where an object has just left, posts take the mean offset of their neighbourhood. */
#include "deform/internal.h"

static enum status filter(struct deform *deform, struct post_rect read, uint32_t layer)
{
	struct deform_request request;
	deform_programs_box(&deform->params, &request);
	enum status status = deform_program(deform, &request, &deform->box);
	if (status != STATUS_OK)
		return status;
	struct layer *scratch = &deform->scratch[layer];
	struct window_params params = deform_window_params(read, layer);
	for (int i = 0; i < deform->params.box_repetitions; i++) {
		int now = scratch->now[PLANE_OFFSET];
		gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
			.stage = GPU_SMOOTH,
			.program = deform->box,
			.target = scratch->to[now == 0 ? TO_SECOND : TO_FIRST],
			.viewport = {0, 0, (uint32_t)params.window[0], (uint32_t)params.window[1]},
			.textures = {deform->bases, deform->planes_of[now][PLANE_OFFSET], deform->contacts},
			.params = &params,
			.params_bytes = sizeof params,
		});
		scratch->now[PLANE_OFFSET] = 1 - now;
	}
	return STATUS_OK;
}

enum status deform_box(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
		       uint32_t layer)
{
	enum status status = deform_none(deform, contact, window, layer);
	/* A contact without motion leaves no post, so there is nothing to smooth. */
	if (status == STATUS_OK && !deform_is_contact_only(contact))
		status = filter(deform, window->read, layer);
	return status;
}
