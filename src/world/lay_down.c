/*
 * The end of a run for soil aboard bodies of a host.
 *
 * The record keeps what lies aboard objects and vehicles of the scene, and the next run may go on with it. Of bodies that a host added it keeps nothing. Their soil would
 * be gone with them, and the pit that it came from would stay. So it lands where they are, as if they were removed, and slides until it lies.
 */
#include "world/internal.h"

#define LANDS_WITHIN 10.0 /* s of simulated time */

/* Tells whether soil lies aboard a body that no record keeps. */
static bool is_left(const struct world *world, size_t number)
{
	const struct body *body = world->bodies[number];
	if (body == NULL || body->carried == NULL || body->carried->total == 0 || body->elsewhere)
		return false;
	return body->host.removed || (number >= world->scene->object_count && (body->kind != BODY_VEHICLE || world->params.carrying_count == 0));
}

enum status world_lay_down(struct world *world)
{
	bool any = false;
	for (size_t i = 0; i < world->body_count && world_has_begun(world); i++) {
		if (!is_left(world, i))
			continue;
		any = true;
		if (!world->bodies[i]->host.removed)
			TRY(world_body_lift(world, (int32_t)i));
		world->bodies[i]->host.removed = true;
	}
	if (!any)
		return STATUS_OK;
	world_tear(world);
	TRY(world_relax_for(world, LANDS_WITHIN));
	return world_end_change(world);
}
