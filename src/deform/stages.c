/* The passes over a gathered window: displace, redistribute, attributes. */
#include <stdio.h>

#include "deform/body.h"
#include "deform/internal.h"

/* std140 twins of the shaders' blocks. */
struct displace_params {
	struct body sweep, end;
	uint32_t zero[4];
	int32_t written[4];
};

struct window_params {
	int32_t window[4];
};

static enum status displace_program(struct deform *deform, enum deform_shape_kind kind, struct gpu_program **out)
{
	static const char *const shapes[] = {"SHAPE_WHEEL", "SHAPE_SPHERE", "SHAPE_BOX"};
	struct gpu_program_request request = {
		.vertex = "full.vert",
		.fragment = "deform/displace.frag",
		.defines = {shapes[kind], deform->contacts != NULL ? "CONTACT" : NULL},
	};
	enum status status = STATUS_OK;
	if (deform->displace[kind] == NULL)
		status = gpu_program_get(deform->params.gpu, &request, &deform->displace[kind]);
	*out = deform->displace[kind];
	return status;
}

static enum status displace(struct deform *deform, const struct deform_sweep *sweep,
			    const struct deform_window *window, uint32_t layer)
{
	const struct post_rect read = window->read, write = window->write;
	struct gpu_program *program;
	enum status status = displace_program(deform, sweep->shape->kind, &program);
	if (status != STATUS_OK)
		return status;
	const struct deform_pose *from = deform_is_contact_only(sweep) ? &sweep->to : &sweep->from;
	struct body_frame frame = {
		.x0 = read.x0,
		.y0 = read.y0,
		.spacing = deform->spacing,
		.zero = sweep->to.z,
	};
	struct displace_params params;
	body_of(sweep->shape, from, &sweep->to, &frame, &params.sweep);
	body_of(sweep->shape, &sweep->to, &sweep->to, &frame, &params.end);
	int64_t zero = frame.zero - (int64_t)deform->params.reference * (1 << OFFSET_BITS);
	params.zero[0] = (uint32_t)zero;
	params.zero[1] = (uint32_t)((uint64_t)zero >> 32);
	params.zero[2] = layer;
	params.zero[3] = 0;
	params.written[0] = (int32_t)(write.x0 - read.x0);
	params.written[1] = (int32_t)(write.y0 - read.y0);
	params.written[2] = (int32_t)(write.x1 - read.x0);
	params.written[3] = (int32_t)(write.y1 - read.y0);
	struct gpu_pass pass = {
		.stage = GPU_DISPLACE,
		.program = program,
		.target = deform->scratch[layer].displaced,
		.viewport = {0, 0, (uint32_t)(read.x1 - read.x0), (uint32_t)(read.y1 - read.y0)},
		.textures = {deform->bases, deform->offsets[0]},
		.storage = {deform->refusals},
		.params = &params,
		.params_bytes = sizeof params,
	};
	gpu_pass_run(deform->params.gpu, &pass);
	deform->scratch[layer].result = 1;
	return STATUS_OK;
}

static enum status filter(struct deform *deform, struct post_rect read, uint32_t layer)
{
	char radius[16];
	snprintf(radius, sizeof radius, "RADIUS %d", deform->params.box_radius);
	struct gpu_program_request request = {.vertex = "full.vert", .fragment = "deform/box.frag", .defines = {radius}};
	enum status status = STATUS_OK;
	if (deform->box == NULL)
		status = gpu_program_get(deform->params.gpu, &request, &deform->box);
	if (status != STATUS_OK)
		return status;
	struct layer *scratch = &deform->scratch[layer];
	struct window_params params = {{(int32_t)(read.x1 - read.x0), (int32_t)(read.y1 - read.y0), (int32_t)layer, 0}};
	for (int i = 0; i < deform->params.box_repetitions; i++) {
		struct gpu_pass pass = {
			.stage = GPU_REDISTRIBUTE,
			.program = deform->box,
			.target = scratch->filtered[1 - scratch->result],
			.viewport = {0, 0, (uint32_t)params.window[0], (uint32_t)params.window[1]},
			.textures = {deform->bases, deform->offsets[scratch->result], deform->contacts},
			.params = &params,
			.params_bytes = sizeof params,
		};
		gpu_pass_run(deform->params.gpu, &pass);
		scratch->result = 1 - scratch->result;
	}
	return STATUS_OK;
}

static enum status dirty(struct deform *deform, struct post_rect read, uint32_t layer)
{
	static const struct gpu_program_request request = {.vertex = "full.vert", .fragment = "deform/dirt.frag"};
	enum status status = STATUS_OK;
	if (deform->dirt == NULL)
		status = gpu_program_get(deform->params.gpu, &request, &deform->dirt);
	if (status != STATUS_OK)
		return status;
	struct layer *scratch = &deform->scratch[layer];
	struct window_params params = {{(int32_t)(read.x1 - read.x0), (int32_t)(read.y1 - read.y0), (int32_t)layer, 0}};
	struct gpu_pass pass = {
		.stage = GPU_ATTRIBUTES,
		.program = deform->dirt,
		.target = scratch->dirtied,
		.viewport = {0, 0, (uint32_t)params.window[0], (uint32_t)params.window[1]},
		.textures = {deform->offsets[scratch->result], deform->contacts, deform->dirts[0]},
		.params = &params,
		.params_bytes = sizeof params,
	};
	gpu_pass_run(deform->params.gpu, &pass);
	return STATUS_OK;
}

enum status deform_run_stages(struct deform *deform, const struct deform_sweep *sweep,
			      const struct deform_window *window, uint32_t layer)
{
	enum status status = displace(deform, sweep, window, layer);
	/* An object that only stands uncovers nothing: there is nothing to smooth. */
	if (status == STATUS_OK && deform->params.model == DEFORM_BOX_FILTER && !deform_is_contact_only(sweep))
		status = filter(deform, window->read, layer);
	if (status == STATUS_OK && deform->params.dirt)
		status = dirty(deform, window->read, layer);
	return status;
}
