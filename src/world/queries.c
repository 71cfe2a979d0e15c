/* Queries about the ground as it is now. */
#include <math.h>

#include "world/internal.h"

static enum status need_newest(struct world *world)
{
	if (world->resident.newest == NULL)
		TRY(resident_newest_create(world->resident.store, world->resident.pages, &world->resident.newest));
	return world->facts.limits.queries > 0 ? resident_newest_keep(world->resident.newest, world->facts.limits.queries) : STATUS_OK;
}

enum status world_heights(struct world *world, const struct resident_point *points, size_t count, struct resident_height *heights)
{
	TRY(need_newest(world));
	return resident_newest_heights(world->resident.newest, points, count, heights);
}

enum status world_rays(struct world *world, const struct resident_ray *rays, size_t count, struct resident_hit *hits)
{
	TRY(need_newest(world));
	return resident_newest_rays(world->resident.newest, rays, count, hits);
}

enum status world_read_posts(struct world *world, enum store_layer layer, int level, struct post_rect rect, double *values)
{
	TRY(need_newest(world));
	return resident_read_posts(world->resident.newest, layer, level, rect, values);
}

enum status world_soil_at(struct world *world, double x, double y, int *soil)
{
	const struct extent *extent = &world->resident.meta->extent;
	const double column = floor(x / world->resident.spacing + 0.5), row = floor(y / world->resident.spacing + 0.5);
	*soil = -1;
	if (!(column >= 0 && row >= 0 && column < (double)extent_posts(extent->width, world->resident.level) &&
	      row < (double)extent_posts(extent->height, world->resident.level)))
		return STATUS_OK;
	uint8_t class = 0;
	enum status status = STATUS_OK;
	if (world->resident.soil_map != NULL)
		status = resident_soil_map_at(world->resident.soil_map, world->resident.level, (int64_t)column, (int64_t)row, &class);
	*soil = class;
	return status;
}
