/* Moves the soil that the object displaces to the nearest free posts: from `carried` into `deposits`. */
#include "deform/internal.h"

struct spread_params {
	int32_t place[4], written[4];
};

enum status deform_spread(struct deform *deform, const struct deform_window *window, uint32_t layer)
{
	struct deform_request request;
	deform_programs_spread(&request);
	enum status status = deform_program(deform, &request, &deform->spread);
	if (status != STATUS_OK)
		return status;
	struct gpu_rect written = deform_written(window);
	struct spread_params params = {
		.place = {(int32_t)layer},
		.written = {(int32_t)written.x, (int32_t)written.y, (int32_t)(written.x + written.width),
			    (int32_t)(written.y + written.height)},
	};
	gpu_texture_clear(deform->deposits, layer, written, 0);
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_SPREAD,
		.program = deform->spread,
		.target = deform->scratch[layer].to[TO_BARE],
		.viewport = written,
		.images = {deform->contacts, deform->carried, deform->deposits},
		.storage = {deform->tally},
		.params = &params,
		.params_bytes = sizeof params,
	});
	return STATUS_OK;
}
