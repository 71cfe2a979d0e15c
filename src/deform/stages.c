/* Runs the passes over a window that was gathered: the lower envelope, the soil model's passes, and the attributes. */
#include <math.h>
#include <string.h>

#include "deform/internal.h"

enum status deform_program(struct deform *deform, const struct deform_request *request, struct gpu_program **place)
{
	return *place != NULL ? STATUS_OK : gpu_program_get(deform->params.gpu, &request->gl, place);
}

struct contact_params deform_contact_params(const struct deform *deform, const struct deform_contact *contact,
					const struct deform_window *window, uint32_t layer)
{
	int64_t zero = contact->to.z - (int64_t)deform->params.reference * (1 << OFFSET_BITS);
	struct contact_params params = {
		.zero = {(uint32_t)zero, (uint32_t)((uint64_t)zero >> 32), layer, (uint32_t)fmin(ldexp(2 * deform->spacing, OFFSET_BITS), 1 << 30)},
	};
	deform_posts_in(window, window->write, params.written);
	return params;
}

struct window_params deform_window_params(struct post_rect read, uint32_t layer)
{
	return (struct window_params){{(int32_t)(read.x1 - read.x0), (int32_t)(read.y1 - read.y0), (int32_t)layer, 0}};
}

struct gpu_rect deform_written(const struct deform_window *window)
{
	const struct post_rect read = window->read, write = window->write;
	return (struct gpu_rect){(uint32_t)(write.x0 - read.x0), (uint32_t)(write.y0 - read.y0),
				 (uint32_t)(write.x1 - write.x0), (uint32_t)(write.y1 - write.y0)};
}

void deform_posts_of(struct gpu_rect rect, int32_t posts[4])
{
	posts[0] = (int32_t)rect.x;
	posts[1] = (int32_t)rect.y;
	posts[2] = (int32_t)(rect.x + rect.width);
	posts[3] = (int32_t)(rect.y + rect.height);
}

void deform_posts_in(const struct deform_window *window, struct post_rect posts, int32_t in[4])
{
	in[0] = (int32_t)(posts.x0 - window->read.x0);
	in[1] = (int32_t)(posts.y0 - window->read.y0);
	in[2] = (int32_t)(posts.x1 - window->read.x0);
	in[3] = (int32_t)(posts.y1 - window->read.y0);
}

struct gpu_rect deform_window_rect(const struct deform_window *window)
{
	return (struct gpu_rect){0, 0, (uint32_t)(window->read.x1 - window->read.x0),
				 (uint32_t)(window->read.y1 - window->read.y0)};
}

enum status deform_run_contact(struct deform *deform, const void *params, size_t params_bytes,
			 const struct deform_window *window, uint32_t layer)
{
	struct deform_request request;
	deform_programs_contact(&deform->params, &request);
	TRY(deform_program(deform, &request, &deform->contact));
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_CONTACT,
		.program = deform->contact,
		.target = deform->scratch[layer].to[TO_CONTACT],
		.viewport = deform_window_rect(window),
		.images = {deform->bases, deform->planes_of[0][PLANE_OFFSET], deform->under, deform->rest},
		.textures = {[4] = deform->classes},
		.storage = {deform->tally},
		.params = params,
		.params_bytes = params_bytes,
	});
	deform->scratch[layer].now[PLANE_OFFSET] = 1;
	return STATUS_OK;
}

enum status deform_contact_plainly(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
				   uint32_t layer)
{
	const struct contact_params params = deform_contact_params(deform, contact, window, layer);
	return deform_run_contact(deform, &params, sizeof params, window, layer);
}

enum status deform_disturb(struct deform *deform, struct post_rect read, uint32_t layer)
{
	struct deform_request request;
	deform_programs_disturbance(&request);
	TRY(deform_program(deform, &request, &deform->disturbance));
	struct layer *scratch = &deform->scratch[layer];
	struct window_params params = deform_window_params(read, layer);
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_DISTURBANCE,
		.program = deform->disturbance,
		.target = scratch->to[TO_DISTURBANCE],
		.viewport = {0, 0, (uint32_t)params.window[0], (uint32_t)params.window[1]},
		.textures = {deform->planes_of[scratch->now[PLANE_OFFSET]][PLANE_OFFSET], deform->contacts,
			     deform->planes_of[0][PLANE_DISTURBANCE]},
		.params = &params,
		.params_bytes = sizeof params,
	});
	scratch->now[PLANE_DISTURBANCE] = 1;
	return STATUS_OK;
}

const char *deform_marks_effect(const struct deform_params *params)
{
	return params->heals > 0 ? "dirt" : "vegetation";
}

/* The pass that writes marks that fade. */
static enum status mark(struct deform *deform, const struct deform_contact *contact, struct post_rect read, uint32_t layer)
{
	struct deform_request request;
	deform_programs_marks(&deform->params, &request);
	TRY(deform_program(deform, &request, &deform->marks));
	struct layer *scratch = &deform->scratch[layer];
	const struct soil_mark mark = deform_mark_of(&deform->params, contact);
	const struct {
		int32_t window[4], mark[4];
	} params = {
		.window = {(int32_t)(read.x1 - read.x0), (int32_t)(read.y1 - read.y0), (int32_t)layer},
		.mark = {mark.now, mark.heals, mark.risen, mark.grown},
	};
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_DISTURBANCE,
		.program = deform->marks,
		.target = scratch->to[TO_MARKS],
		.viewport = {0, 0, (uint32_t)params.window[0], (uint32_t)params.window[1]},
		.textures = {deform->planes_of[scratch->now[PLANE_OFFSET]][PLANE_OFFSET], deform->contacts, deform->planes_of[0][PLANE_HEALED],
			     deform->planes_of[0][PLANE_RISEN], deform->planes_of[0][PLANE_GROWN]},
		.params = &params,
		.params_bytes = sizeof params,
	});
	scratch->now[PLANE_HEALED] = deform->params.heals > 0;
	scratch->now[PLANE_RISEN] = scratch->now[PLANE_GROWN] = deform->params.rises > 0;
	return STATUS_OK;
}

void deform_begin_layer(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window, uint32_t layer)
{
	struct layer *scratch = &deform->scratch[layer];
	const struct post_rect all = deform_reached(deform, contact), write = window->write;
	memset(scratch->now, 0, sizeof scratch->now);
	scratch->alone = window->parts == 0 && all.x0 == write.x0 && all.y0 == write.y0 && all.x1 == write.x1 && all.y1 == write.y1;
	scratch->above = contact->above;
	scratch->roofed = false;
	scratch->near = deform_is_swept(deform, contact);
}

enum status deform_run_stages(struct deform *deform, const struct deform_contact *contact,
			      const struct deform_window *window, uint32_t layer)
{
	deform_begin_layer(deform, contact, window, layer);
	if (!deform_is_elastic(deform->params.model)) /* its contact draws two */
		TRY(deform_envelope(deform, contact, window, layer));
	TRY(deform_model_row(deform->params.model)->contact(deform, contact, window, layer));
	if (deform_marks(&deform->params) != 0)
		TRY(mark(deform, contact, window->read, layer));
	return deform->params.disturbance ? deform_disturb(deform, window->read, layer) : STATUS_OK;
}
