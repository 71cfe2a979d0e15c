/* The roads of a scene as straight parts in local metres. */
#include "world/internal.h"

struct parts {
	struct road_part *list;
	size_t count, room;
};

static enum status add_line(const struct world *world, const struct scene_road *road, const struct scene_path *line, struct parts *parts)
{
	struct scene_path route;
	TRY(world_route(world, line, "ground.roads", &route));
	enum status status = STATUS_OK;
	for (size_t i = 0; i + 1 < route.count + (route.count == 1) && status == STATUS_OK; i++) {
		const struct scene_waypoint *from = &route.points[i], *to = &route.points[i + (route.count > 1)];
		status = mem_grow(&parts->list, &parts->room, parts->count + 1, sizeof *parts->list, "roads");
		if (status == STATUS_OK)
			parts->list[parts->count++] = (struct road_part){{from->x, from->y}, {to->x, to->y}, road->width / 2, road->soil};
	}
	motion_route_finish(&route);
	return status;
}

enum status world_road_parts(const struct world *world, struct road_part **list, size_t *count)
{
	const struct scene *scene = world->scene;
	struct parts parts = {.list = NULL};
	enum status status = STATUS_OK;
	for (size_t i = 0; i < scene->road_count && status == STATUS_OK; i++)
		for (size_t k = 0; k < scene->roads[i].line_count && status == STATUS_OK; k++)
			status = add_line(world, &scene->roads[i], &scene->roads[i].lines[k], &parts);
	*list = parts.list;
	*count = parts.count;
	return status;
}
