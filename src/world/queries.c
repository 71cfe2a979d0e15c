/* Questions about the ground as it is now. */
#include "world/internal.h"

static enum status need_newest(struct world *world)
{
	return world->newest != NULL ? STATUS_OK : newest_create(world->store, world, &world->newest);
}

enum status world_heights(struct world *world, const struct terrain_point *points, size_t count, struct terrain_height *heights)
{
	enum status status = need_newest(world);
	return status == STATUS_OK ? newest_heights(world->newest, points, count, heights) : status;
}

enum status world_rays(struct world *world, const struct terrain_ray *rays, size_t count, struct terrain_hit *hits)
{
	enum status status = need_newest(world);
	return status == STATUS_OK ? newest_rays(world->newest, rays, count, hits) : status;
}
