/*
 * Bodies at rest keep ground out of themselves: soil fills the gap below such a body, and then goes elsewhere. What is laid goes elsewhere, too, where the
 * body leaves little room (src/soil/sliding/roofs.h; the CPU's part is src/bearing/roofs.c).
 *
 * Of each body two lower envelopes are drawn: its own, and that of the body upside down, which tells where its upper side is. A pass notes for each post
 * the highest offset to which soil may bring it (roof.frag). Programs and the texture of roofs are made before the first step if the parameters say that a
 * body will be at rest. Otherwise they are made when one first is.
 */
#include <math.h>
#include <string.h>

#include "deform/internal.h"

#define ROOF_NONE INT32_MAX /* lib/roofs.glsl */

/* std140 twin of roof.frag's block. */
struct roof_params {
	uint32_t zero[4];
	int32_t place[4];
};

enum status deform_need_roofs(struct deform *deform)
{
	const uint32_t layers = deform->layers;
	if (deform->roofs != NULL)
		return STATUS_OK;
	deform->params.roofs = true;
	deform_drop_layers(deform);
	return deform_need_layers(deform, layers, deform->side);
}

void deform_clear_roofs(struct deform *deform, uint32_t layer, struct gpu_rect posts)
{
	gpu_texture_clear(deform->roofs, layer, posts, ROOF_NONE);
}

/* Draws the lower envelope of a body in a pose. */
static enum status draw(struct deform *deform, const struct soil_shape *shape, const struct soil_pose *pose, struct post_rect posts)
{
	const struct deform_contact contact = {.shape = shape, .from = *pose, .to = *pose};
	const struct deform_window window = {.read = posts, .write = posts};
	deform->figures.resting += shape->kind != SOIL_MESH;
	return deform_envelope(deform, &contact, &window, 0);
}

enum status deform_roof_envelopes(struct deform *deform, const struct deform_rest *rest, struct post_rect posts)
{
	struct soil_shape shape = *rest->shape;
	struct soil_mesh mirrored = {.vertices = NULL};
	const struct soil_pose pose = soil_upside_down(&rest->pose);
	if (shape.kind == SOIL_MESH)
		TRY(soil_kinematic_mirror(rest->shape->mesh, &mirrored));
	shape.mesh = shape.kind == SOIL_MESH ? &mirrored : NULL;
	enum status status;
	TRY_OR(done, draw(deform, &shape, &pose, posts));
	/* The heights of a window are not used before soil slides there. */
	gpu_texture_copy(deform->rest, 0, 0, 0, deform->heights[1], 0,
			 (struct gpu_rect){0, 0, (uint32_t)(posts.x1 - posts.x0), (uint32_t)(posts.y1 - posts.y0)});
	TRY_OR(done, draw(deform, rest->shape, &rest->pose, posts));
done:
	mem_free(mirrored.vertices);
	return status;
}

enum status deform_roof_note(struct deform *deform, const struct deform_rest *rest, struct post_rect drawn, const struct deform_roof_place *place)
{
	const struct post_rect both = post_rect_intersect(drawn, place->posts);
	const int64_t zero = rest->pose.z - (int64_t)deform->params.reference * (1 << OFFSET_BITS);
	struct deform_request request;
	if (post_rect_empty(both))
		return STATUS_OK;
	deform_programs_roof(ROOF_NOTE, &request);
	TRY(deform_program(deform, &request, &deform->roof[ROOF_NOTE]));
	const int32_t x = (int32_t)(drawn.x0 - place->posts.x0) + (int32_t)place->x, y = (int32_t)(drawn.y0 - place->posts.y0) + (int32_t)place->y;
	const struct roof_params params = {
		.zero = {(uint32_t)zero, (uint32_t)((uint64_t)zero >> 32), 0, place->layer},
		.place = {x, y, (int32_t)lattice_offset(fmin(deform->spacing, 500))},
	};
	deform->figures.held++;
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_HOLD,
		.program = deform->roof[ROOF_NOTE],
		.target = deform->scratch[place->layer].to[TO_BARE],
		.viewport = {(uint32_t)(both.x0 - place->posts.x0) + place->x, (uint32_t)(both.y0 - place->posts.y0) + place->y, (uint32_t)(both.x1 - both.x0),
			     (uint32_t)(both.y1 - both.y0)},
		.images = {deform->rest, deform->heights[1], deform->bases, deform->planes_of[1][PLANE_OFFSET], deform->contacts, deform->roofs},
		.params = &params,
		.params_bytes = sizeof params,
	});
	return STATUS_OK;
}

enum status deform_find_roofs(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window, uint32_t layer)
{
	const struct deform_roof_place place = {.layer = layer, .posts = window->read};
	deform_clear_roofs(deform, layer, deform_window_rect(window));
	for (size_t i = 0; i < contact->rest_count; i++) {
		const struct deform_rest *rest = &contact->rests[i];
		const struct post_rect posts = post_rect_intersect(soil_shadow(rest->shape, &rest->pose, &rest->pose, deform->spacing), window->read);
		if (post_rect_empty(posts))
			continue;
		TRY(deform_roof_envelopes(deform, rest, posts));
		TRY(deform_roof_note(deform, rest, posts, &place));
	}
	deform->scratch[layer].roofed = true;
	return STATUS_OK;
}

enum status deform_roof_run(struct deform *deform, enum roof_pass pass, struct gpu_rect posts, uint32_t layer, struct gpu_texture *heights)
{
	const struct window_params params = {{(int32_t)posts.width, (int32_t)posts.height, (int32_t)layer, 0}};
	struct deform_request request;
	const bool limits = pass == ROOF_LIMIT;
	deform_programs_roof(pass, &request);
	TRY(deform_program(deform, &request, &deform->roof[pass]));
	deform->figures.held++;
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_HOLD,
		.program = deform->roof[pass],
		.target = deform->scratch[layer].to[TO_BARE],
		.viewport = posts,
		.images = {limits ? deform->deposits : heights, deform->roofs, limits ? deform->planes_of[1][PLANE_OFFSET] : deform->carried, limits ? NULL : deform->bases},
		.storage = {limits ? deform->tally : NULL},
		.params = &params,
		.params_bytes = sizeof params,
	});
	return STATUS_OK;
}
