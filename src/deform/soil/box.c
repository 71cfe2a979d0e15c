/*
 * The soil model "box": smooths the ground that an object has just left (dissertation 5.5). Each post there takes the mean offset
 * of the posts around it.
 */
#include "deform/internal.h"

static enum status filter(struct deform *deform, struct post_rect read, uint32_t layer)
{
	struct deform_request request;
	deform_programs_box(&deform->params, &request);
	TRY(deform_program(deform, &request, &deform->box));
	struct layer *scratch = &deform->scratch[layer];
	struct window_params params = deform_window_params(read, layer);
	for (int i = 0; i < deform->params.box_repetitions; i++) {
		int now = scratch->now[PLANE_OFFSET];
		gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
			.stage = GPU_SMOOTH,
			.program = deform->box,
			.target = scratch->to[now == 0 ? TO_SECOND : TO_FIRST],
			.viewport = {0, 0, (uint32_t)params.window[0], (uint32_t)params.window[1]},
			.images = {deform->planes_of[now][PLANE_OFFSET], deform->contacts},
			.params = &params,
			.params_bytes = sizeof params,
		});
		scratch->now[PLANE_OFFSET] = 1 - now;
	}
	return STATUS_OK;
}

static enum status contact(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			   uint32_t layer)
{
	TRY(deform_contact_plainly(deform, contact, window, layer));
	/* A contact without motion leaves no post, so there is nothing to smooth. */
	return deform_is_contact_only(contact) ? STATUS_OK : filter(deform, window->read, layer);
}

static enum status batch(struct deform *deform)
{
	TRY(deform_batch_contact(deform));
	return deform_batch_smooth(deform);
}

const struct soil_model deform_model_box = {
	.name = "box",
	.use = "takes the imprint; the dissertation's smoothing",
	.volume = "compacted",
	.effect = {
		"box", "redistribute.model", "", EFFECT_LIST("deform/box.frag", "deform/gather.frag", "deform/store.frag"), "base, offset", "offset", 4,
		EFFECT_LIST("redistribute.radius", "redistribute.repetitions", "redistribute.regions"),
		"reads as many posts around the trail as the radius times the repetitions: 32 at most",
		"smooths the trail: the mean of the posts around"},
	.contact_effect = "displace",
	.keys = EFFECT_LIST("radius", "repetitions", "regions"),
	.contact = contact,
	.batch = batch,
	.shader = "deform/none.frag",
	.smooths = true,
};
