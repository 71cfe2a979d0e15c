/* Lists what may be drawn beside the ground: the scene's objects, the world's figures, and bodies that a host has added. */
#include <string.h>

#include "render/view.h"

/* Lists the numbers of the bodies that a host has added and that are there. */
static enum status list_added(struct view *view)
{
	const struct world *world = view->world;
	const size_t first = world_scene(world)->object_count, count = world_scene(world)->hosted ? world_body_count(world) : 0;
	mem_free(view->added);
	view->added = NULL;
	view->added_count = 0;
	view->bodies = count;
	if (count <= first)
		return STATUS_OK;
	TRY(mem_make(&view->added, count - first, sizeof *view->added, "the view"));
	for (size_t number = first; number < count; number++)
		if (world_body(world, number) != NULL && world_body(world, number)->kind == BODY_HOST) /* the figures have those of vehicles */
			view->added[view->added_count++] = (int32_t)number;
	return STATUS_OK;
}

enum status render_view_list_drawn(struct view *view, struct render_params *params)
{
	const struct world *world = view->world;
	const size_t objects = world_scene(world)->object_count, figures = world_figures(world)->count;
	mem_free(view->drawn);
	view->drawn = NULL;
	TRY(list_added(view));
	if (figures + view->added_count == 0)
		return STATUS_OK;
	/* They share the memory of the scene's objects, of the figures and of the bodies. */
	TRY(mem_zeroed(&view->drawn, objects + figures + view->added_count, sizeof *view->drawn, "the view"));
	if (objects > 0)
		memcpy(view->drawn, world_scene(world)->objects, objects * sizeof *view->drawn);
	if (figures > 0)
		memcpy(view->drawn + objects, world_figures(world)->list, figures * sizeof *view->drawn);
	for (size_t i = 0; i < view->added_count; i++)
		view->drawn[objects + figures + i] = *world_body(world, (size_t)view->added[i])->object;
	params->objects = view->drawn;
	params->object_count = objects + figures + view->added_count;
	return STATUS_OK;
}

bool render_view_body(const struct view *view, size_t number, struct render_object *object)
{
	const struct body *body = world_body(view->world, number);
	if (body == NULL || body->host.removed || !body->host.placed)
		return false;
	*object = (struct render_object){.posed = true};
	memcpy(object->at, body->host.now.pose.position, sizeof object->at);
	world_axes(body->host.now.pose.orientation, object->axes);
	return true;
}
