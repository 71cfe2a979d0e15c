/*
 * Bodies at rest: they hold the soil below them. An interval has many regions, and there may be many bodies. So it notes once where each body is above,
 * and looks in each region at the bodies of its rows alone.
 */
#include "base/memory.h"
#include "bearing/internal.h"

struct soil_pose bearing_rest_pose(const struct bearing *bearing, const struct deform_rest *rest)
{
	struct soil_pose pose = rest->pose;
	if (rest->loaded_body > 0)
		pose.z += bearing->standing[rest->loaded_body - 1];
	return pose;
}

static struct post_rect shadow_of(const struct bearing *bearing, const struct deform_rest *rest)
{
	const struct soil_pose pose = bearing_rest_pose(bearing, rest);
	return soil_shadow(rest->shape, &pose, &pose, bearing->law.spacing);
}

static enum status hold(struct bearing *bearing, const struct deform_rest *rest)
{
	struct soil_planes *planes = &bearing->window.planes;
	const struct soil_kinematic kinematic = {.spacing = bearing->law.spacing, .reference = bearing->law.reference};
	const struct soil_pose pose = bearing_rest_pose(bearing, rest);
	const struct soil_kinematic_contact contact = {.shape = rest->shape};
	if (bearing->bears || rest->roofs)
		return bearing_roof(bearing, rest->shape, &pose);
	TRY(bearing_scratch_need(bearing, soil_kinematic_room(&kinematic, &contact, planes->width, (size_t)(planes->rect.y1 - planes->rect.y0))));
	soil_kinematic_hold(&kinematic, rest->shape, &pose, planes, bearing->window.scratch);
	return STATUS_OK;
}

enum status bearing_hold(struct bearing *bearing, const struct deform_rest *objects, size_t count)
{
	for (size_t i = 0; i < count; i++)
		if (!post_rect_empty(post_rect_intersect(shadow_of(bearing, &objects[i]), bearing->window.planes.rect)))
			TRY(hold(bearing, &objects[i]));
	return STATUS_OK;
}

static int from_south(const void *a, const void *b)
{
	const struct bearing_held *p = a, *q = b;
	return p->shadow.y0 < q->shadow.y0 ? -1 : p->shadow.y0 > q->shadow.y0;
}

enum status bearing_hold_begin(struct bearing *bearing, const struct deform_rest *objects, size_t count)
{
	bearing->held_count = 0;
	bearing->held_tallest = 0;
	if (count > bearing->held_room) {
		TRY(mem_resize(&bearing->held, count, sizeof *bearing->held, "relaxation"));
		bearing->held_room = count;
	}
	for (size_t i = 0; i < count; i++) {
		const struct post_rect shadow = shadow_of(bearing, &objects[i]);
		if (post_rect_empty(shadow))
			continue;
		bearing->held[bearing->held_count++] = (struct bearing_held){shadow, &objects[i]};
		bearing->held_tallest = shadow.y1 - shadow.y0 > bearing->held_tallest ? shadow.y1 - shadow.y0 : bearing->held_tallest;
	}
	if (bearing->held_count > 1)
		qsort(bearing->held, bearing->held_count, sizeof *bearing->held, from_south);
	return STATUS_OK;
}

/* Returns the first of the bodies whose shadow begins in this row, or north of it. */
static size_t first_from(const struct bearing *bearing, int64_t row)
{
	size_t low = 0, high = bearing->held_count;
	while (low < high) {
		const size_t middle = low + (high - low) / 2;
		if (bearing->held[middle].shadow.y0 < row)
			low = middle + 1;
		else
			high = middle;
	}
	return low;
}

enum status bearing_hold_near(struct bearing *bearing)
{
	const struct bearing *main = bearing->main;
	const struct post_rect rect = bearing->window.planes.rect;
	for (size_t i = first_from(main, rect.y0 - main->held_tallest + 1); i < main->held_count; i++) {
		const struct bearing_held *held = &main->held[i];
		if (held->shadow.y0 >= rect.y1)
			break;
		if (!post_rect_empty(post_rect_intersect(held->shadow, rect)))
			TRY(hold(bearing, held->rest));
	}
	return STATUS_OK;
}
