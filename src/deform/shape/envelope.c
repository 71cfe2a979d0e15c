/*
 * The first stage over a window: the object's lower envelope above each post. The soil model decides what the ground does
 * then. So shapes and models do not depend on each other.
 */
#include <math.h>
#include <string.h>

#include "soil/shape/body.h"
#include "deform/internal.h"

/* The same for a body that needs few functions of a post's position. */
struct brief_body {
	struct functional f[2];
	int32_t a[4], b[4], c[4];
};
struct brief_params {
	struct brief_body motion, end;
};
_Static_assert(sizeof(struct brief_params) == DEFORM_BRIEF_BYTES, "lib/envelope.glsl");

bool deform_envelope_is_brief(enum soil_shape_kind kind, bool sideways)
{
	return kind == SOIL_SPHERE || (kind == SOIL_WHEEL && !sideways);
}

static struct brief_body brief(const struct body *body)
{
	struct brief_body out;
	memcpy(out.f, body->f, sizeof out.f);
	memcpy(out.a, body->a, sizeof out.a);
	memcpy(out.b, body->b, sizeof out.b);
	memcpy(out.c, body->c, sizeof out.c);
	return out;
}

void deform_under_of(const struct deform *deform, const struct deform_contact *contact, int64_t x0, int64_t y0, struct under_params *params)
{
	const struct soil_pose *from = deform_is_contact_only(contact) ? &contact->to : &contact->from;
	struct body_frame frame = {.x0 = x0, .y0 = y0, .spacing = deform->spacing, .zero = contact->to.z};
	if (contact->shape->kind == SOIL_WHEEL) {
		frame.yaw[0] = cosl(contact->to.yaw);
		frame.yaw[1] = sinl(contact->to.yaw);
	}
	soil_body_of(contact->shape, from, &contact->to, &frame, &params->motion);
	soil_body_of(contact->shape, &contact->to, &contact->to, &frame, &params->end);
	params->kind = soil_kind_in(contact->shape, &contact->to);
	/* Only a wheel that moves sideways needs the times at which its sides pass over a post. */
	params->sideways = params->kind == SOIL_WHEEL && (params->motion.c[1] != 0 || params->end.c[1] != 0);
}

enum status deform_under_run(struct deform *deform, const struct under_params *params, struct gpu_rect posts, uint32_t layer)
{
	const struct brief_params few = {brief(&params->motion), brief(&params->end)};
	bool is_brief = deform_envelope_is_brief(params->kind, params->sideways);
	struct deform_request request;
	deform_programs_envelope(&deform->params, params->kind, params->sideways, &request);
	struct gpu_program **program = &deform->under_program[params->kind + (params->sideways ? SOIL_SHAPES : 0)];
	TRY(deform_program(deform, &request, program));
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_ENVELOPE,
		.program = *program,
		.target = deform->scratch[layer].to[TO_UNDER],
		.viewport = posts,
		.params = is_brief ? (const void *)&few : params,
		.params_bytes = is_brief ? sizeof few : 2 * sizeof(struct body),
	});
	return STATUS_OK;
}

enum status deform_envelope(struct deform *deform, const struct deform_contact *contact,
			     const struct deform_window *window, uint32_t layer)
{
	const struct post_rect read = window->read;
	struct under_params params;
	if (contact->shape->kind == SOIL_MESH)
		return deform_mesh(deform, contact, window, layer);
	deform_under_of(deform, contact, read.x0, read.y0, &params);
	TRY(deform_under_run(deform, &params, deform_window_rect(window), layer));
	bool grousers = contact->shape->kind == SOIL_WHEEL && contact->shape->grousers > 0;
	return grousers ? deform_grousers(deform, contact, window, layer) : STATUS_OK;
}
