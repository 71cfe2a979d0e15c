/*
 * Facets of a mesh and of grousers. The lower envelope of a mesh at a post is the lowest height of all its triangles during the motion. The
 * order of a triangle's vertices does not matter. So a mesh may be concave, open or cut through itself. An exactly vertical triangle has no
 * area from above. It lowers the ground only if another triangle shares its edges.
 *
 * Vertices are rotated in doubles. Then their x and y are rounded to 2^-FACET_BITS posts. Everything after that is whole numbers.
 */
#include "soil/shape/facets.h"

#include <math.h>

#include "soil/shape/bars.h"

static const double unit[3] = {2, 2, 2}; /* of which half is one */

static double posts_a_metre(const struct facets_motion *motion)
{
	return ldexp(1, FACET_BITS) / motion->frame.spacing;
}

static struct facet_window window_of(const struct facets_motion *motion, const struct body_motion *body)
{
	return (struct facet_window){body->x0, body->y0, motion->width, motion->height};
}

/* Computes where the vertices are at the motion's end. */
static void place(const struct facets_motion *motion, const struct body_motion *body, struct facet_corner *corners)
{
	const struct soil_mesh *mesh = motion->shape->mesh;
	const double posts = posts_a_metre(motion);
	const double x = (double)(body->x + body->dx), y = (double)(body->y + body->dy), z = (double)(body->z + body->dz);
	double axes[3][3];
	soil_body_axes(unit, motion->to->yaw, motion->to->pitch, motion->to->roll, axes);
	for (uint32_t i = 0; i < mesh->vertex_count; i++) {
		const float *vertex = mesh->vertices[i];
		double at[3];
		for (int k = 0; k < 3; k++)
			at[k] = vertex[0] * axes[0][k] + vertex[1] * axes[1][k] + vertex[2] * axes[2][k];
		corners[i] = (struct facet_corner){
			.x = (int32_t)lrint((x + at[0]) * posts),
			.y = (int32_t)lrint((y + at[1]) * posts),
			.z = z + ldexp(at[2], OFFSET_BITS),
		};
	}
}

void soil_mesh_facets(const struct facets_motion *motion, struct facet_corner *corners, facets_fn draw, void *user)
{
	const struct soil_mesh *mesh = motion->shape->mesh;
	const struct body_motion body = soil_body_motion_of(motion->from, motion->to, &motion->frame);
	const double posts = posts_a_metre(motion);
	const struct facet_motion by = {(int32_t)lrint((double)body.dx * posts), (int32_t)lrint((double)body.dy * posts), (int32_t)body.dz};
	const struct facet_window window = window_of(motion, &body);
	place(motion, &body, corners);
	for (uint32_t t = 0; t < mesh->triangle_count; t++) {
		const uint32_t *index = mesh->triangles[t];
		const struct facet_corner at[3] = {corners[index[0]], corners[index[1]], corners[index[2]]};
		struct facet facet;
		if (soil_facet_of(at, &by, true, &window, &facet))
			draw(user, &facet);
	}
}

/* The state while the faces of bars are drawn. */
struct grousers {
	facets_fn draw;
	void *user;
	double posts; /* 2^-FACET_BITS posts a metre */
	struct facet_window window;
};

static struct facet_corner corner_of(const struct grousers *grousers, const double at[3])
{
	return (struct facet_corner){
		.x = (int32_t)lrint(at[0] * grousers->posts), .y = (int32_t)lrint(at[1] * grousers->posts), .z = ldexp(at[2], OFFSET_BITS)};
}

static void draw_face(void *user, const struct bar_face *face)
{
	const struct grousers *grousers = user;
	const struct facet_corner start = corner_of(grousers, face->from), end = corner_of(grousers, face->to);
	const struct facet_motion motion = {end.x - start.x, end.y - start.y, (int32_t)lrint(end.z - start.z)};
	struct facet_corner at[4];
	for (int k = 0; k < 4; k++)
		at[k] = corner_of(grousers, face->at[k]);
	const struct facet_corner halves[2][3] = {{at[0], at[1], at[2]}, {at[0], at[2], at[3]}};
	for (int i = 0; i < 2; i++) {
		struct facet facet;
		if (soil_facet_of(halves[i], &motion, face->resting, &grousers->window, &facet))
			grousers->draw(grousers->user, &facet);
	}
}

void soil_grouser_facets(const struct facets_motion *motion, facets_fn draw, void *user)
{
	const struct body_motion body = soil_body_motion_of(motion->from, motion->to, &motion->frame);
	const struct bars_motion bars = {
		.x = body.x, .y = body.y, .dx = body.dx, .dy = body.dy, .z = ldexp((double)body.z, -OFFSET_BITS),
		.dz = ldexp((double)body.dz, -OFFSET_BITS), .turned = motion->turned,
	};
	struct grousers grousers = {draw, user, posts_a_metre(motion), window_of(motion, &body)};
	soil_bars(motion->shape, motion->to, &bars, draw_face, &grousers);
}
