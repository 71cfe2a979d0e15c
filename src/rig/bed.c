/* The bed: a store of level ground, in a file that is removed when the rig has ended. */
#include <math.h>
#include <stdio.h>
#include <unistd.h>

#include "dem/dem.h"
#include "rig/internal.h"
#include "store/store.h"

#define CELLS 256

static enum status level(void *user, struct post_rect rect, double *heights)
{
	(void)user;
	for (int64_t i = 0; i < (rect.x1 - rect.x0) * (rect.y1 - rect.y0); i++)
		heights[i] = 0;
	return STATUS_OK;
}

static enum status put(void *user, const struct dem_tile *tile)
{
	const struct store_range range = {tile->low, tile->high, tile->error};
	return store_put_base(user, tile->tile, tile->codes, &range);
}

enum status rig_bed_make(const struct rig *rig, size_t lanes)
{
	struct store *store;
	const double spacing = rig->found.spacing * rig->levels;
	const struct store_meta meta = {
		.extent = {(int64_t)ceil((2 * rig->start + rig->found.way + (double)(rig->passes - 1) * rig->behind) / spacing) + 2,
			   (int64_t)ceil((2 * rig->start + (double)(lanes - 1) * rig->pitch) / spacing) + 2, spacing, CELLS},
		.step = 0.001,
		.max_error = 0.0005,
		.srs = "",
		.vertical = "",
		.sources = "a level bed",
	};
	enum status status = store_create(rig->bed, &meta, true, &store);
	if (status != STATUS_OK)
		return status;
	status = dem_cut(&(struct dem_cut){.extent = &meta.extent, .step = meta.step, .posts = level, .emit = put, .emit_user = store});
	if (status == STATUS_OK)
		status = store_publish(store);
	store_close(store);
	return status;
}

void rig_bed_remove(const struct rig *rig)
{
	static const char *const ends[] = {"", "-wal", "-shm", ".part"};
	char path[4096];
	for (size_t i = 0; rig->bed != NULL && i < sizeof ends / sizeof *ends; i++) {
		snprintf(path, sizeof path, "%s%s", rig->bed, ends[i]);
		unlink(path);
	}
}
