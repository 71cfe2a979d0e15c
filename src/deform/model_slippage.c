/* Li and Moshell 1993: the object pushes soil aside, all of it, and what is too steep to stand slips. */
#include "deform/internal.h"

enum status deform_slippage(struct deform *deform, const struct deform_sweep *sweep, const struct deform_window *window,
			    uint32_t layer)
{
	static const struct gpu_program_request request = {
		.vertex = "full.vert",
		.fragment = "deform/slippage.frag",
		.defines = {"CONTACT"},
	};
	enum status status = deform_program(deform, &request, &deform->press);
	if (status != STATUS_OK)
		return status;
	const struct post_rect read = window->read;
	struct press_params params = deform_press_params(deform, sweep, window, layer);
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_DISPLACE,
		.program = deform->press,
		.target = deform->scratch[layer].to[TO_PRESSED],
		.viewport = {0, 0, (uint32_t)(read.x1 - read.x0), (uint32_t)(read.y1 - read.y0)},
		.textures = {deform->bases, deform->planes_of[0][PLANE_OFFSET], deform->under, deform->rest},
		.storage = {deform->tally},
		.params = &params,
		.params_bytes = sizeof params,
	});
	deform->scratch[layer].now[PLANE_OFFSET] = 1;
	status = deform_spread(deform, window, layer);
	return status == STATUS_OK ? deform_slide(deform, window, layer) : status;
}
