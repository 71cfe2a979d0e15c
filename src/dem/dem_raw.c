/* Reads raw heightmaps: squares of little-endian uint16 posts. The first row in the file is the northernmost. */
#include "dem_internal.h"

#include <errno.h>
#include <stdio.h>
#include <sys/stat.h>

struct raw {
	struct dem_grid grid;
	FILE *file;
	char *path;
	struct dem_meaning meaning;
	double *nodata;
	uint8_t *row; /* 2 * width bytes */
};

static void raw_destroy(struct dem_grid *grid)
{
	struct raw *raw = (struct raw *)grid;
	if (raw->file != NULL)
		fclose(raw->file);
	mem_free_all(raw->path, raw->nodata, raw->row, raw);
}

static enum status raw_read(struct dem_grid *grid, struct post_rect rect, double *heights)
{
	struct raw *raw = (struct raw *)grid;
	int64_t width = rect.x1 - rect.x0;
	size_t bytes = 2 * (size_t)width;
	for (int64_t y = rect.y0; y < rect.y1; y++, heights += width) {
		int64_t from_north = grid->height - 1 - y;
		if (fseeko(raw->file, (off_t)(2 * (from_north * grid->width + rect.x0)), SEEK_SET) != 0 ||
		    fread(raw->row, 1, bytes, raw->file) != bytes)
			return fail_with(STATUS_INPUT, "%s: reading row %lld failed: %s; check the disk",
					 raw->path, (long long)from_north, strerror(errno));
		for (int64_t x = 0; x < width; x++)
			heights[x] = (double)(raw->row[2 * x] | raw->row[2 * x + 1] << 8);
		dem_metres(&raw->meaning, heights, width, heights);
	}
	return STATUS_OK;
}

enum status dem_raw_open(const struct dem_params *params, const char *path, struct dem_grid **out)
{
	struct raw *raw = mem_calloc(1, sizeof *raw);
	TRY_MEM(raw, path);
	raw->grid.destroy = raw_destroy;
	enum status status;
	raw->file = input_open(path);
	struct stat file;
	if (raw->file == NULL || fstat(fileno(raw->file), &file) != 0)
		TRY_OR(failed, fail_with(STATUS_INPUT, "%s: cannot be opened: %s; check its permissions", path,
					 input_problem()));
	int64_t posts = file.st_size / 2, side = (int64_t)llround(sqrt((double)posts));
	if (file.st_size % 2 != 0 || side * side != posts)
		TRY_OR(failed, fail_with(STATUS_INPUT, "%s: %lld bytes are no square of 16-bit heights; give a square "
					 "one, or a GeoTIFF", path, (long long)file.st_size));
	double span = params->has_height_range ? params->height_max - params->height_min : 65535;
	raw->path = mem_strdup(path);
	raw->row = mem_alloc((size_t)side, 2);
	raw->nodata = mem_alloc(params->nodata_count, sizeof *raw->nodata);
	if (raw->path == NULL || raw->row == NULL || raw->nodata == NULL)
		TRY_OR(failed, fail_memory(path));
	for (size_t i = 0; i < params->nodata_count; i++)
		raw->nodata[i] = params->nodata[i];
	raw->meaning = (struct dem_meaning){
		.scale = span / 65535,
		.offset = params->has_height_range ? params->height_min : 0,
		.nodata = raw->nodata,
		.nodata_count = params->nodata_count,
		.single = true,
	};
	raw->grid.read = raw_read;
	raw->grid.width = raw->grid.height = side;
	raw->grid.spacing = params->spacing > 0 ? params->spacing : 1;
	raw->grid.unit = raw->meaning.scale;
	raw->grid.whole = dem_unit_exact(raw->grid.unit) && fmod(raw->meaning.offset, raw->grid.unit) == 0;
	*out = &raw->grid;
	return STATUS_OK;
failed:
	dem_grid_destroy(&raw->grid);
	return status;
}
