/* Draws the lower envelope of a moving mesh over a window: the facets of soil_mesh_facets. */

#include "soil/shape/facets.h"
#include "deform/internal.h"

struct facets_motion deform_facets_motion(const struct deform *deform, const struct deform_contact *contact, const struct deform_window *window)
{
	const struct post_rect read = window->read;
	const bool moves = !deform_is_contact_only(contact);
	return (struct facets_motion){
		.shape = contact->shape, .from = moves ? &contact->from : &contact->to, .to = &contact->to, .turned = moves ? contact->turned : 0,
		.frame = {.x0 = read.x0, .y0 = read.y0, .spacing = deform->spacing, .zero = contact->to.z},
		.width = (int32_t)(read.x1 - read.x0), .height = (int32_t)(read.y1 - read.y0),
	};
}

enum status deform_mesh(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			uint32_t layer)
{
	const struct facets_motion motion = deform_facets_motion(deform, contact, window);
	const struct gpu_rect all = deform_window_rect(window);
	struct facet_corner *corners = mem_alloc(contact->shape->mesh->vertex_count, sizeof *corners);
	TRY_MEM(corners, "the vertices of a mesh");
	enum status status;
	TRY_OR(done, deform_facets_begin(deform, window->read, layer));
	gpu_texture_clear(deform->under, layer, all, UNDER_NONE);
	if (deform->rest != NULL)
		gpu_texture_clear(deform->rest, layer, all, UNDER_NONE);
	soil_mesh_facets(&motion, corners, deform_facets_add, deform);
	deform_facets_end(deform);
done:
	mem_free(corners);
	return status;
}
