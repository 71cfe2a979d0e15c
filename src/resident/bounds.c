#include "resident/resident.h"

#include <math.h>

enum status resident_bounds_add(struct offset_bounds *bounds, struct tile tile, double low, double high)
{
	const int coarsest = extent_coarsest(bounds->extent);
	for (int level = tile.level; level <= coarsest; level++) {
		const uint64_t key = tile_key(tile_ancestor(tile, level));
		const struct key_pair *had = key_map_find(&bounds->added, key);
		if (had != NULL && had->a <= low && had->b >= high)
			return STATUS_OK; /* and so have all tiles above it */
		low = had != NULL ? fmin(had->a, low) : low;
		high = had != NULL ? fmax(had->b, high) : high;
		TRY(key_map_put(&bounds->added, key, low, high));
	}
	return STATUS_OK;
}

bool resident_bounds_widen(const struct offset_bounds *bounds, struct tile tile, double *low, double *high)
{
	const struct key_pair *added = key_map_find(&bounds->added, tile_key(tile));
	if (added == NULL)
		return false;
	*low = fmin(*low, added->a);
	*high = fmax(*high, added->b);
	return true;
}

void resident_bounds_clear(struct offset_bounds *bounds)
{
	key_set_clear(&bounds->added.keys);
}

void resident_bounds_finish(struct offset_bounds *bounds)
{
	key_map_finish(&bounds->added);
}
