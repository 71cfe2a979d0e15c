/* Sumner, O'Brien and Hodgins 1999: the object pushes aside what it does not compact, and the ground erodes. */
#include <math.h>
#include <stdio.h>

#include "deform/internal.h"

struct sumner_params {
	struct press_params press;
	uint32_t kept[DEFORM_SOILS][4];
};

enum status deform_sumner(struct deform *deform, const struct deform_sweep *sweep, const struct deform_window *window,
			  uint32_t layer)
{
	char soils[16];
	snprintf(soils, sizeof soils, "SOILS %d", deform_soil_slots(deform));
	const struct gpu_program_request request = {
		.vertex = "full.vert",
		.fragment = "deform/sumner.frag",
		.defines = {"CONTACT", soils},
	};
	enum status status = deform_program(deform, &request, &deform->press);
	if (status != STATUS_OK)
		return status;
	const struct post_rect read = window->read;
	struct sumner_params params = {.press = deform_press_params(deform, sweep, window, layer)};
	for (int i = 0; i < deform->params.soil_count; i++)
		params.kept[i][0] = (uint32_t)floor(ldexp(1 - deform->params.soils[i].compression, 31));
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_DISPLACE,
		.program = deform->press,
		.target = deform->scratch[layer].to[TO_PRESSED],
		.viewport = {0, 0, (uint32_t)(read.x1 - read.x0), (uint32_t)(read.y1 - read.y0)},
		.textures = {deform->bases, deform->planes_of[0][PLANE_OFFSET], deform->under, deform->rest,
			     deform->classes},
		.storage = {deform->tally},
		.params = &params,
		.params_bytes = sizeof params,
	});
	deform->scratch[layer].now[PLANE_OFFSET] = 1;
	status = deform_spread(deform, window, layer);
	return status == STATUS_OK ? deform_slide(deform, window, layer) : status;
}
