/*
 * The lower envelope of a moving mesh over a window. At each post it is the lowest height of all triangles during the
 * motion. The order of a triangle's vertices does not matter. So a mesh may be concave, open or cut through itself. An exactly
 * vertical triangle has no area from above. It lowers the ground only if another triangle shares its edges.
 *
 * Vertices are rotated in doubles. Then their x and y are rounded to 2^-FACET_BITS posts. Everything after that is whole
 * numbers.
 */
#include <math.h>

#include "soil/shape/body.h"
#include "soil/shape/facet.h"
#include "deform/internal.h"

static const double unit[3] = {2, 2, 2}; /* of which half is one */

static void turn(const float vertex[3], double axes[3][3], double at[3])
{
	for (int k = 0; k < 3; k++)
		at[k] = vertex[0] * axes[0][k] + vertex[1] * axes[1][k] + vertex[2] * axes[2][k];
}

/* Where the vertices are at the contact's end. */
static void place(const struct soil_mesh *mesh, const struct soil_pose *to, const struct body_motion *motion,
		  double spacing, struct facet_corner *corners)
{
	double axes[3][3], posts = ldexp(1, FACET_BITS) / spacing;
	double x = (double)(motion->x + motion->dx), y = (double)(motion->y + motion->dy), z = (double)(motion->z + motion->dz);
	soil_body_axes(unit, to->yaw, to->pitch, to->roll, axes);
	for (uint32_t i = 0; i < mesh->vertex_count; i++) {
		double at[3];
		turn(mesh->vertices[i], axes, at);
		corners[i] = (struct facet_corner){
			.x = (int32_t)lrint((x + at[0]) * posts),
			.y = (int32_t)lrint((y + at[1]) * posts),
			.z = z + ldexp(at[2], OFFSET_BITS),
		};
	}
}

static void draw(struct deform *deform, const struct soil_mesh *mesh, const struct facet_corner *corners,
		 const struct facet_motion *motion, const struct facet_window *around)
{
	for (uint32_t t = 0; t < mesh->triangle_count; t++) {
		const uint32_t *index = mesh->triangles[t];
		const struct facet_corner at[3] = {corners[index[0]], corners[index[1]], corners[index[2]]};
		if (soil_facet_of(at, motion, true, around, deform_facets_next(deform)))
			deform_facets_keep(deform);
	}
	deform_facets_end(deform);
}

enum status deform_mesh(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			uint32_t layer)
{
	const struct soil_mesh *mesh = contact->shape->mesh;
	const struct post_rect read = window->read;
	const struct gpu_rect all = deform_window_rect(window);
	const struct body_frame frame = {.x0 = read.x0, .y0 = read.y0, .spacing = deform->spacing, .zero = contact->to.z};
	const struct soil_pose *from = deform_is_contact_only(contact) ? &contact->to : &contact->from;
	struct body_motion motion = soil_body_motion_of(from, &contact->to, &frame);
	struct facet_corner *corners = mem_alloc(mesh->vertex_count, sizeof *corners);
	if (corners == NULL)
		return fail_memory("the vertices of a mesh");
	enum status status = deform_facets_begin(deform, read, layer);
	if (status == STATUS_OK) {
		double posts = ldexp(1, FACET_BITS) / deform->spacing;
		struct facet_motion by = {(int32_t)lrint((double)motion.dx * posts), (int32_t)lrint((double)motion.dy * posts),
					  (int32_t)motion.dz};
		struct facet_window around = {motion.x0, motion.y0, (int32_t)all.width, (int32_t)all.height};
		gpu_texture_clear(deform->under, layer, all, UNDER_NONE);
		if (deform->rest != NULL)
			gpu_texture_clear(deform->rest, layer, all, UNDER_NONE);
		place(mesh, &contact->to, &motion, deform->spacing, corners);
		draw(deform, mesh, corners, &by, &around);
	}
	mem_free(corners);
	return status;
}
