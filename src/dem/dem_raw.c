/*
 * Reads raw heightmaps: squares of posts of 8 bits, or of 16 bits with the lower byte first. The first row in the file is the northernmost.
 *
 * The size of a file tells which: no number of bytes is both a square and twice a square. Posts of 8 bits say nothing of metres, so they need a
 * height range.
 */
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
	uint8_t *row; /* bytes * width */
	int bytes;    /* of a post */
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
	size_t bytes = (size_t)raw->bytes * (size_t)width;
	for (int64_t y = rect.y0; y < rect.y1; y++, heights += width) {
		int64_t from_north = grid->height - 1 - y;
		if (fseeko(raw->file, (off_t)(raw->bytes * (from_north * grid->width + rect.x0)), SEEK_SET) != 0 ||
		    fread(raw->row, 1, bytes, raw->file) != bytes)
			return fail_with(STATUS_INPUT, "%s: reading row %lld failed: %s; check the disk",
					 raw->path, (long long)from_north, strerror(errno));
		for (int64_t x = 0; x < width; x++)
			heights[x] = raw->bytes == 1 ? raw->row[x] : raw->row[2 * x] | raw->row[2 * x + 1] << 8;
		dem_metres(&raw->meaning, heights, width, heights);
	}
	return STATUS_OK;
}

static int64_t root_of(int64_t posts)
{
	const int64_t side = (int64_t)llround(sqrt((double)posts));
	return side * side == posts ? side : 0;
}

/* Finds the bytes of a post, and the posts of a side. */
static enum status find_side(const struct dem_params *params, const char *path, int64_t size, int *bytes, int64_t *side)
{
	const bool wide = dem_path_ends(path, ".r16"), narrow = dem_path_ends(path, ".r8");
	*bytes = !wide && root_of(size) > 0 ? 1 : 2;
	*side = *bytes == 1 ? root_of(size) : size % 2 == 0 && !narrow ? root_of(size / 2) : 0;
	if (*side == 0)
		return fail_with(STATUS_INPUT, "%s: %lld bytes are no square of %s heights; give a square one, or a GeoTIFF", path, (long long)size,
				 wide ? "16-bit" : narrow ? "8-bit" : "8-bit or 16-bit");
	if (*bytes == 1 && !params->has_height_range)
		return fail_with(STATUS_INPUT, "%s: its %lld x %lld heights have 8 bits, which are no metres; give --height-range MIN,MAX, the heights that 0 and 255 "
				       "mean", path, (long long)*side, (long long)*side);
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
	int64_t side;
	TRY_OR(failed, find_side(params, path, file.st_size, &raw->bytes, &side));
	const int full = raw->bytes == 1 ? 255 : 65535;
	double span = params->has_height_range ? params->height_max - params->height_min : full;
	raw->path = mem_strdup(path);
	raw->row = mem_alloc((size_t)side, (size_t)raw->bytes);
	raw->nodata = mem_alloc(params->nodata_count, sizeof *raw->nodata);
	if (raw->path == NULL || raw->row == NULL || raw->nodata == NULL)
		TRY_OR(failed, fail_memory(path));
	for (size_t i = 0; i < params->nodata_count; i++)
		raw->nodata[i] = params->nodata[i];
	raw->meaning = (struct dem_meaning){
		.scale = span / full,
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
