/* The imagery of a drive's pictures: where it is made, and which pages future pictures will show. */
#include <math.h>

#include "render/view.h"

enum status render_view_make_imagery(struct view *view)
{
	const struct world *world = view->world;
	const struct resident *resident = world_resident(world);
	if (!(world_scene(world)->view.effects >> EFFECT_IMAGERY & 1) || view->imagery != NULL)
		return STATUS_OK;
	return render_imagery_create(resident->gpu, resident->store, world_scene(world)->view.imagery_budget, world_facts(world)->limits.loaders, &view->imagery);
}

/* Adds the pages of a tile. They are asked for ahead, so a height that is not known yet does not count. */
static enum status add_tile(struct view *view, struct tile tile, struct imagery_area *area, struct imagery_pages *pages)
{
	struct key_pair range;
	TRY(render_view_base_range(view, tile, &range));
	if (isnan(range.a))
		return STATUS_OK;
	render_box(&view->imagery->extent, tile, area->low, area->high);
	area->low[2] = range.a;
	area->high[2] = range.b;
	return render_imagery_need(view->imagery, area, pages);
}

enum status render_view_look_imagery(struct view *view, const struct render_camera *camera, struct view_look *look)
{
	struct render_axes axes;
	struct render_view whole;
	look->imagery.count = 0;
	if (view->imagery == NULL)
		return STATUS_OK;
	render_axes(view->render, camera, &axes);
	render_view(view->render, camera, &whole);
	struct imagery_area area = {.view = &whole, .focal = axes.focal};
	/* Of a tile and its children the same pages come twice: a request counts once. */
	for (size_t i = 0; i < look->count; i++)
		TRY(add_tile(view, tile_from_key(look->keys[i]), &area, &look->imagery));
	return STATUS_OK;
}

enum status render_view_want_imagery(struct view *view)
{
	const struct view_look *order[VIEW_LOOKS + SCENE_CAMERAS];
	struct imagery_pages all = {.count = 0};
	if (view->imagery == NULL)
		return STATUS_OK;
	enum status status = STATUS_OK;
	const size_t count = render_view_order_ahead(view, order);
	for (size_t i = 0; i < count && all.count < view->imagery->slots; i++)
		for (size_t k = 0; k < order[i]->imagery.count; k++) {
			TRY_OR(done, mem_grow(&all.keys, &all.room, all.count + 1, sizeof *all.keys, "imagery"));
			all.keys[all.count++] = order[i]->imagery.keys[k];
		}
	TRY_OR(done, render_imagery_want(view->imagery, all.keys, all.count));
	TRY_OR(done, render_imagery_poll(view->imagery));
done:
	mem_free(all.keys);
	return status;
}
