/* Queries about the ground as it is now. */
#include <math.h>

#include "world/internal.h"

static enum status need_newest(struct world *world)
{
	if (world->newest == NULL) {
		enum status status = resident_newest_create(world->store, world->pages, &world->newest);
		if (status != STATUS_OK)
			return status;
	}
	return world->limits.queries > 0 ? resident_newest_keep(world->newest, world->limits.queries) : STATUS_OK;
}

enum status world_heights(struct world *world, const struct resident_point *points, size_t count, struct resident_height *heights)
{
	enum status status = need_newest(world);
	return status == STATUS_OK ? resident_newest_heights(world->newest, points, count, heights) : status;
}

enum status world_rays(struct world *world, const struct resident_ray *rays, size_t count, struct resident_hit *hits)
{
	enum status status = need_newest(world);
	return status == STATUS_OK ? resident_newest_rays(world->newest, rays, count, hits) : status;
}

enum status world_read_posts(struct world *world, enum store_layer layer, int level, struct post_rect rect, double *values)
{
	enum status status = need_newest(world);
	return status == STATUS_OK ? resident_read_posts(world->newest, layer, level, rect, values) : status;
}

enum status world_soil_at(struct world *world, double x, double y, int *soil)
{
	const struct extent *extent = &world->meta->extent;
	const double column = floor(x / world->spacing + 0.5), row = floor(y / world->spacing + 0.5);
	*soil = -1;
	if (!(column >= 0 && row >= 0 && column < (double)extent_posts(extent->width, world->level) &&
	      row < (double)extent_posts(extent->height, world->level)))
		return STATUS_OK;
	uint8_t class = 0;
	enum status status = STATUS_OK;
	if (world->soil_map != NULL)
		status = resident_soil_map_at(world->soil_map, world->level, (int64_t)column, (int64_t)row, &class);
	*soil = class;
	return status;
}
