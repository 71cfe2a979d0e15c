/* Pure compaction: what is pressed is gone (dissertation 4.4.2). */
#include "deform/internal.h"

enum status deform_none(struct deform *deform, const struct deform_sweep *sweep, const struct deform_window *window,
			uint32_t layer)
{
	const struct gpu_program_request request = {
		.vertex = "full.vert",
		.fragment = "deform/none.frag",
		.defines = {deform->contacts != NULL ? "CONTACT" : NULL},
	};
	enum status status = deform_program(deform, &request, &deform->none);
	if (status != STATUS_OK)
		return status;
	const struct post_rect read = window->read;
	struct press_params params = deform_press_params(deform, sweep, window, layer);
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_DISPLACE,
		.program = deform->none,
		.target = deform->scratch[layer].to[TO_PRESSED],
		.viewport = {0, 0, (uint32_t)(read.x1 - read.x0), (uint32_t)(read.y1 - read.y0)},
		.textures = {deform->bases, deform->planes_of[0][PLANE_OFFSET], deform->under, deform->rest},
		.storage = {deform->tally},
		.params = &params,
		.params_bytes = sizeof params,
	});
	deform->scratch[layer].now[PLANE_OFFSET] = 1;
	return STATUS_OK;
}
