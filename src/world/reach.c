/* How far the ground reaches into the space above a rectangle: whether a body that is high above it can touch anything. */
#include <math.h>

#include "world/internal.h"

/* A row of posts. */
struct row {
	const int32_t *base, *offsets; /* offsets: NULL: they are 0 */
	int64_t first, count;          /* the first one's column, how many */
	double reference;              /* of base, m */
};

/* How far the ground of a row at y is above the limit of the space, m. */
static double reach_of_row(const struct world_space *space, const struct row *row, double y, double spacing)
{
	double most = -INFINITY;
	for (int64_t i = 0; i < row->count; i++) {
		const double x = (double)(row->first + i) * spacing, plane = space->at[2] + space->slope[0] * (x - space->at[0]) + space->slope[1] * (y - space->at[1]);
		const double limit = plane > space->lowest ? plane : space->lowest;
		const double height = row->reference + row->base[i] * (1.0 / (1 << BASE_BITS)) + (row->offsets != NULL ? row->offsets[i] * (1.0 / (1 << OFFSET_BITS)) : 0);
		most = row->base[i] != BASE_NODATA && height - limit > most ? height - limit : most;
	}
	return most;
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
	for (int64_t y = in.y0; y < in.y1 && slot.base != NULL; y++) {
		const size_t row = (size_t)(y - own.y0) * (extent->cells + 1) + (size_t)(in.x0 - own.x0);
		const double reached = reach_of_row(space, &(struct row){slot.base + row, offsets != NULL ? offsets + row : NULL, in.x0, in.x1 - in.x0, reference}, (double)y * spacing, spacing);
		most = reached > most ? reached : most;
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
