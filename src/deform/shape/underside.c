/*
 * The first stage over a window: how low the object is above each post. What the ground makes of it is
 * the model's; so shapes and models need not know of each other.
 */
#include "deform/shape/body.h"
#include "deform/internal.h"

/* std140 twin of lib/underside.glsl's block. */
struct under_params {
	struct body sweep, end;
};

/* The posts that it can be above, in the window; if there are none, any: a window's passes are as many wherever it lies. */
static struct gpu_rect shadow_of(const struct deform *deform, const struct deform_sweep *sweep, struct post_rect read)
{
	struct post_rect in = post_rect_intersect(deform_shadow(deform, sweep), read);
	if (post_rect_empty(in))
		return (struct gpu_rect){0, 0, 1, 1};
	return (struct gpu_rect){(uint32_t)(in.x0 - read.x0), (uint32_t)(in.y0 - read.y0), (uint32_t)(in.x1 - in.x0),
				 (uint32_t)(in.y1 - in.y0)};
}

enum status deform_underside(struct deform *deform, const struct deform_sweep *sweep,
			     const struct deform_window *window, uint32_t layer)
{
	enum deform_shape_kind kind = sweep->shape->kind;
	if (kind == DEFORM_MESH)
		return deform_mesh(deform, sweep, window, layer);
	const struct post_rect read = window->read;
	const struct deform_pose *from = deform_is_contact_only(sweep) ? &sweep->to : &sweep->from;
	struct body_frame frame = {
		.x0 = read.x0,
		.y0 = read.y0,
		.spacing = deform->spacing,
		.zero = sweep->to.z,
	};
	struct under_params params;
	deform_body_of(sweep->shape, from, &sweep->to, &frame, &params.sweep);
	deform_body_of(sweep->shape, &sweep->to, &sweep->to, &frame, &params.end);
	/* A wheel that goes where it rolls needs no times at which its sides pass. */
	bool sideways = kind == DEFORM_WHEEL && (params.sweep.c[1] != 0 || params.end.c[1] != 0);
	struct deform_request request;
	deform_programs_underside(&deform->params, kind, sideways, &request);
	struct gpu_program **program = &deform->under_program[kind + (sideways ? DEFORM_SHAPES : 0)];
	enum status status = deform_program(deform, &request, program);
	if (status != STATUS_OK)
		return status;
	/* Beyond its shadow it is above no post, and scm does not look there. */
	const struct gpu_rect all = {0, 0, (uint32_t)(read.x1 - read.x0), (uint32_t)(read.y1 - read.y0)};
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_ENVELOPE,
		.program = *program,
		.target = deform->scratch[layer].to[TO_UNDER],
		.viewport = deform->params.model == DEFORM_SCM ? shadow_of(deform, sweep, read) : all,
		.params = &params,
		.params_bytes = sizeof params,
	});
	return kind == DEFORM_WHEEL && sweep->shape->lugs > 0 ? deform_lugs(deform, sweep, window, layer) : STATUS_OK;
}
