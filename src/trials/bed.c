/* The bed: a store of level ground, imported from a heightmap, in a folder of its own that is removed when the rig has ended. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "trials/internal.h"

#define NAME "/bed.furrow"
#define LEVEL "/level.raw"

/* Writes a raw heightmap: a square of so many posts a side, all of height 0. */
static enum status write_level(const char *path, int64_t posts)
{
	static const char zeros[4096];
	FILE *file = output_open(path, "w");
	if (file == NULL)
		return fail_with(STATUS_FAILED, "%s: %s; give a folder that can be written", path, strerror(errno));
	size_t left = (size_t)posts * (size_t)posts * 2;
	for (size_t part; left > 0; left -= part) {
		part = left < sizeof zeros ? left : sizeof zeros;
		if (fwrite(zeros, 1, part, file) != part)
			break;
	}
	return fclose(file) == 0 && left == 0 ? STATUS_OK : fail_with(STATUS_FAILED, "%s: %s; free some disk space", path, strerror(errno));
}

enum status trials_bed_make(const struct rig *rig, size_t lanes)
{
	char path[4096], options[160];
	const char *sources[] = {path};
	const double spacing = rig->found.spacing * rig->levels;
	const double columns = ceil((2 * rig->start + rig->found.way + (double)(rig->passes - 1) * rig->behind) / spacing);
	const double rows = ceil((2 * rig->start + (double)(lanes - 1) * rig->pitch) / spacing);
	snprintf(path, sizeof path, "%.*s%s", (int)(strlen(rig->bed) - strlen(NAME)), rig->bed, LEVEL);
	snprintf(options, sizeof options, "{spacing: %.17g, max_error: 0.0005, overwrite: true, jobs: 1}", spacing);
	TRY(write_level(path, (int64_t)fmax(columns, rows) + 2));
	const enum status status = trials_told(furrow_import(sources, 1, rig->bed, options, NULL, NULL));
	unlink(path);
	return status;
}

enum status trials_bed_begin(struct rig *rig)
{
	const char *folder = rig->params->folder;
	TRY(mem_make(&rig->bed, strlen(folder) + sizeof "/bed-XXXXXX" NAME, 1, "the rig"));
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
