/* The bed: a store of level ground, in a folder of its own that is removed when the rig has ended. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "dem/dem.h"
#include "trials/internal.h"
#include "store/store.h"

#define CELLS 256
#define NAME "/bed.furrow"

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

enum status trials_bed_make(const struct rig *rig, size_t lanes)
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

enum status trials_bed_begin(struct rig *rig)
{
	const char *folder = rig->params->folder;
	rig->bed = mem_alloc(strlen(folder) + sizeof "/bed-XXXXXX" NAME, 1);
	if (rig->bed == NULL)
		return fail_memory("the rig");
	char *const end = rig->bed + sprintf(rig->bed, "%s/bed-XXXXXX", folder);
	if (mkdtemp(rig->bed) != NULL) {
		strcpy(end, NAME);
		return STATUS_OK;
	}
	mem_free(rig->bed);
	rig->bed = NULL;
	return fail_with(STATUS_FAILED, "%s: no folder can be made in it: %s; give another folder", folder, strerror(errno));
}

void trials_bed_remove(struct rig *rig)
{
	static const char *const ends[] = {"", "-wal", "-shm", ".part"};
	char path[4096];
	if (rig->bed == NULL)
		return;
	for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
		snprintf(path, sizeof path, "%s%s", rig->bed, ends[i]);
		unlink(path);
	}
	rig->bed[strlen(rig->bed) - strlen(NAME)] = '\0';
	rmdir(rig->bed);
	mem_free(rig->bed);
}
