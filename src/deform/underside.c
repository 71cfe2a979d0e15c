/*
 * The first stage over a window: how low the object is above each post. What the ground makes of it is
 * the model's; so shapes and models need not know of each other.
 */
#include "deform/body.h"
#include "deform/internal.h"

/* std140 twin of lib/underside.glsl's block. */
struct under_params {
	struct body sweep, end;
};

enum status deform_underside(struct deform *deform, const struct deform_sweep *sweep,
			     const struct deform_window *window, uint32_t layer)
{
	static const char *const shapes[DEFORM_SHAPES] = {"SHAPE_WHEEL", "SHAPE_SPHERE", "SHAPE_BOX"};
	enum deform_shape_kind kind = sweep->shape->kind;
	if (kind == DEFORM_MESH)
		return deform_mesh(deform, sweep, window, layer);
	const struct gpu_program_request request = {
		.vertex = "full.vert",
		.fragment = "deform/under.frag",
		.defines = {shapes[kind], deform->rest != NULL ? "REST" : NULL},
	};
	enum status status = deform_program(deform, &request, &deform->under_program[kind]);
	if (status != STATUS_OK)
		return status;
	const struct post_rect read = window->read;
	const struct deform_pose *from = deform_is_contact_only(sweep) ? &sweep->to : &sweep->from;
	struct body_frame frame = {
		.x0 = read.x0,
		.y0 = read.y0,
		.spacing = deform->spacing,
		.zero = sweep->to.z,
	};
	struct under_params params;
	body_of(sweep->shape, from, &sweep->to, &frame, &params.sweep);
	body_of(sweep->shape, &sweep->to, &sweep->to, &frame, &params.end);
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_DISPLACE,
		.program = deform->under_program[kind],
		.target = deform->scratch[layer].to[TO_UNDER],
		.viewport = {0, 0, (uint32_t)(read.x1 - read.x0), (uint32_t)(read.y1 - read.y0)},
		.params = &params,
		.params_bytes = sizeof params,
	});
	return kind == DEFORM_WHEEL && sweep->shape->lugs > 0 ? deform_lugs(deform, sweep, window, layer) : STATUS_OK;
}
