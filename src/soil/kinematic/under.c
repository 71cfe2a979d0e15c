/* The lower envelope of a moving body over a rectangle of posts. See under.h. */
#include "soil/kinematic/under.h"

#include <math.h>

#include "soil/kinematic/closed.h"
#include "soil/kinematic/facet_rows.h"
#include "soil/kinematic/rows.h"
#include "soil/shape/facets.h"

/* Where facets are drawn. */
struct drawing {
	size_t stride;
	int32_t *under, *rest;
};

static void draw(void *user, const struct facet *facet)
{
	const struct drawing *drawing = user;
	soil_facet_rows(facet, drawing->stride, drawing->under, drawing->rest);
}

static bool is_still(const struct under_motion *motion)
{
	return motion->from->x == motion->to->x && motion->from->y == motion->to->y && motion->from->z == motion->to->z;
}

static void closed(const struct under_motion *motion, const struct body_frame *frame, const struct drawing *drawing)
{
	const struct post_rect posts = motion->posts;
	const struct closed_posts all = {0, 0, (int)(posts.x1 - posts.x0), (int)(posts.y1 - posts.y0)};
	struct closed_form form = {.form = soil_kind_in(motion->shape, motion->to)};
	soil_body_of(motion->shape, motion->to, motion->to, frame, &form.end);
	if (is_still(motion))
		form.motion = form.end;
	else
		soil_body_of(motion->shape, motion->from, motion->to, frame, &form.motion);
	soil_closed(&form, &all, drawing->stride, drawing->under, drawing->rest);
}

size_t soil_under_stride(int64_t posts)
{
	return ((size_t)posts + LANES - 1) / LANES * LANES;
}

void soil_under(const struct under_motion *motion, struct facet_corner *corners, int32_t *under, int32_t *rest)
{
	const struct soil_shape *shape = motion->shape;
	const struct post_rect posts = motion->posts;
	const struct drawing drawing = {soil_under_stride(posts.x1 - posts.x0), under, rest};
	struct facets_motion facets = {
		.shape = shape, .from = motion->from, .to = motion->to, .turned = is_still(motion) ? 0 : motion->turned,
		.frame = {.x0 = posts.x0, .y0 = posts.y0, .spacing = motion->spacing, .zero = motion->to->z},
		.width = (int32_t)(posts.x1 - posts.x0), .height = (int32_t)(posts.y1 - posts.y0),
	};
	if (shape->kind == SOIL_MESH) {
		for (size_t i = 0; i < drawing.stride * (size_t)facets.height; i++)
			under[i] = rest[i] = UNDER_NONE;
		soil_mesh_facets(&facets, corners, draw, (void *)&drawing);
		return;
	}
	if (shape->kind == SOIL_WHEEL) {
		facets.frame.yaw[0] = cosl(motion->to->yaw);
		facets.frame.yaw[1] = sinl(motion->to->yaw);
	}
	closed(motion, &facets.frame, &drawing);
	if (shape->kind == SOIL_WHEEL && shape->grousers > 0)
		soil_grouser_facets(&facets, draw, (void *)&drawing);
}
