/* How far the ground reaches into the space above a rectangle: whether a body that is high above it can touch anything. */
#include <math.h>

#include "world/internal.h"

/* The limit of the space at a post, m. */
static double limit_at(const struct world_space *space, double x, double y)
{
	return fmax(space->lowest, space->at[2] + space->slope[0] * (x - space->at[0]) + space->slope[1] * (y - space->at[1]));
}

/* Posts of a tile that are in `rect`. */
static double reach_of_tile(const struct world *world, const struct world_space *space, const struct tile_slot *held, struct post_rect rect)
{
	const struct extent *extent = &world->resident.meta->extent;
	const struct post_rect own = tile_post_rect(extent, held->tile), in = post_rect_intersect(rect, own);
	const double spacing = world->resident.spacing, reference = resident_ground_reference(world->resident.store);
	struct host_slot slot;
	double most = -INFINITY;
	if (post_rect_empty(in))
		return most;
	resident_host_get(world->resident.host, held->slot, &slot);
	const int32_t *offsets = slot.planes[PLANE_OFFSET];
	for (int64_t y = in.y0; y < in.y1 && slot.base != NULL; y++)
		for (int64_t x = in.x0; x < in.x1; x++) {
			const size_t at = (size_t)(y - own.y0) * (extent->cells + 1) + (size_t)(x - own.x0);
			if (slot.base[at] == BASE_NODATA)
				continue;
			const double height = reference + lattice_base_metres(slot.base[at]) + (offsets != NULL ? lattice_offset_metres(offsets[at]) : 0);
			most = fmax(most, height - limit_at(space, (double)x * spacing, (double)y * spacing));
		}
	return most;
}

/* The same of each held tile, as this rank has it. Of a tile that another rank has changed, that rank's number is taken. */
static enum status reach_of_all(struct world *world, const struct world_space *space, struct post_rect rect, struct held_tiles *held, double *depths)
{
	TRY(world_hold_own(world, rect, held));
	for (size_t i = 0; i < held->count; i++)
		depths[i] = reach_of_tile(world, space, &held->tiles[i], rect);
	return STATUS_OK;
}

enum status world_reach_into(struct world *world, const struct world_space *space, double *depth)
{
	const double spacing = world->resident.spacing;
	const struct post_rect rect = {
		(int64_t)floor(space->low[0] / spacing), (int64_t)floor(space->low[1] / spacing),
		(int64_t)ceil(space->high[0] / spacing) + 1, (int64_t)ceil(space->high[1] / spacing) + 1,
	};
	const size_t tiles = world_tiles_in(world, rect);
	const struct world_ranks *ranks = world->ranks;
	struct held_tiles held = {.count = 0};
	double depths[WORLD_TILES_MOST];
	*depth = -INFINITY;
	if (world->resident.host == NULL || tiles > world->counts.windows.tiles) {
		*depth = INFINITY;
		return STATUS_OK;
	}
	if (tiles == 0)
		return STATUS_OK;
	enum status status = reach_of_all(world, space, rect, &held, depths);
	if (ranks != NULL)
		status = ranks->newest(ranks->user, held.count, held.keys, depths, status);
	for (size_t i = 0; i < held.count; i++)
		*depth = fmax(*depth, depths[i]);
	world_release(world, &held);
	return status;
}
