/* Writes raw heightmaps: little-endian uint16 posts and nothing else. The first row in the file is the northernmost, as dem_raw.c
 * reads it. */
#include "dem_internal.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

struct raw_sink {
	struct dem_sink sink;
	const struct dem_raster *raster;
	FILE *file;
	uint8_t *row;
};

static enum status refuse(const struct dem_raster *raster)
{
	return fail_with(STATUS_FAILED, "%s: cannot be written: %s; free some disk space", raster->path, strerror(errno));
}

static enum status sink_row(struct dem_sink *sink, int64_t y, const double *values)
{
	struct raw_sink *raw = (struct raw_sink *)sink;
	int64_t width = raw->raster->width, from_north = raw->raster->height - 1 - y;
	for (int64_t x = 0; x < width; x++) {
		unsigned value = (unsigned)dem_raster_value(raw->raster, values[x]);
		raw->row[2 * x] = (uint8_t)value;
		raw->row[2 * x + 1] = (uint8_t)(value >> 8);
	}
	bool written = fseeko(raw->file, (off_t)(2 * from_north * width), SEEK_SET) == 0 &&
		       fwrite(raw->row, 2, (size_t)width, raw->file) == (size_t)width;
	return written ? STATUS_OK : refuse(raw->raster);
}

static enum status sink_finish(struct dem_sink *sink)
{
	struct raw_sink *raw = (struct raw_sink *)sink;
	int closed = fclose(raw->file);
	raw->file = NULL;
	return closed == 0 ? STATUS_OK : refuse(raw->raster);
}

static void sink_destroy(struct dem_sink *sink)
{
	struct raw_sink *raw = (struct raw_sink *)sink;
	if (raw->file != NULL)
		fclose(raw->file);
	mem_free_all(raw->row, raw);
}

enum status dem_raw_sink(const struct dem_raster *raster, const char *part, struct dem_sink **out)
{
	struct raw_sink *raw = mem_calloc(1, sizeof *raw);
	TRY_MEM(raw, raster->path);
	raw->sink = (struct dem_sink){sink_row, sink_finish, sink_destroy};
	raw->raster = raster;
	raw->row = mem_alloc((size_t)raster->width, 2);
	enum status status;
	TRY_OR(failed, raw->row != NULL ? STATUS_OK : fail_memory(raster->path));
	if ((raw->file = dem_part_open(part)) == NULL)
		TRY_OR(failed, fail_with(STATUS_FAILED, "%s: cannot be created: %s; check the folder and its permissions", raster->path,
					 input_problem()));
	*out = &raw->sink;
	return STATUS_OK;
failed:
	sink_destroy(&raw->sink);
	return status;
}
