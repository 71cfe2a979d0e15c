/*
 * Reads a grey PNG that lies over the terrain. A PNG has no coordinates: each pixel is one post of level 0, and the first pixel is
 * the north-west post. Values are as they are stored, 0 to 255 or 0 to 65535.
 */
#include <stdio.h>
#include <string.h>

#include "dem_placed.h"

#define PNG_PIXELS ((int64_t)1 << 30) /* two bytes each in a temporary file */

struct png_of_values {
	struct dem_placed raster;
	const struct dem_placed_params *params;
	struct dem_grid *grid;
};

static void png_destroy(struct dem_placed *raster)
{
	struct png_of_values *png = (struct png_of_values *)raster;
	dem_grid_destroy(png->grid);
	mem_free(png);
}

static void png_locate(struct dem_placed *raster, size_t count, double *x, double *y)
{
	const struct png_of_values *png = (const struct png_of_values *)raster;
	double north = (double)(png->params->extent->height - 1);
	for (size_t i = 0; i < count; i++) {
		x[i] = x[i] + 0.5;
		y[i] = north - y[i] + 0.5;
	}
}

static enum status png_window(struct dem_placed *raster, struct post_rect pixels, double *values)
{
	struct png_of_values *png = (struct png_of_values *)raster;
	int64_t width = pixels.x1 - pixels.x0;
	for (int64_t row = pixels.y0; row < pixels.y1; row++, values += width) {
		int64_t y = raster->height - 1 - row; /* the grid's are from the south */
		TRY(png->grid->read(png->grid, (struct post_rect){pixels.x0, y, pixels.x1, y + 1}, values));
	}
	return STATUS_OK;
}

static int64_t big_endian(const unsigned char bytes[4])
{
	return (int64_t)bytes[0] << 24 | bytes[1] << 16 | bytes[2] << 8 | bytes[3];
}

/* Checks the PNG's header. It refuses pictures that the reader of heightmaps takes, but that hold no numbers. */
static enum status png_check(const char *path, enum dem_placed_kind kind)
{
	unsigned char header[26];
	FILE *file = input_open(path);
	if (file == NULL)
		return fail_with(STATUS_INPUT, "%s: cannot be opened: %s; name a grey PNG or a GeoTIFF", path,
				 input_problem());
	size_t got = fread(header, 1, sizeof header, file);
	fclose(file);
	if (got < sizeof header || memcmp(header, "\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16) != 0)
		return fail_with(STATUS_INPUT, "%s: is not a PNG; give a grey PNG or a GeoTIFF", path);
	int bits = header[24], colour = header[25];
	if ((colour & 3) != 0)
		return fail_with(STATUS_INPUT, "%s: is in colour, and %s numbers; give a grey PNG or a GeoTIFF", path,
				 kind == DEM_PLACED_CLASSES ? "classes are" : "here it holds");
	if (bits != 8 && bits != 16)
		return fail_with(STATUS_INPUT, "%s: has %d bits a pixel; give one of 8 or 16", path, bits);
	int64_t width = big_endian(header + 16), height = big_endian(header + 20);
	if (height > 0 && width > PNG_PIXELS / height)
		return fail_with(STATUS_INPUT, "%s: %lld x %lld pixels are too many in a PNG; give a GeoTIFF", path,
				 (long long)width, (long long)height);
	return STATUS_OK;
}

enum status dem_placed_png_open(const struct dem_placed_params *params, enum dem_placed_kind kind,
				struct dem_placed **out)
{
	const struct dem_params plain = {.source_count = 1};
	TRY(png_check(params->path, kind));
	struct png_of_values *png = mem_calloc(1, sizeof *png);
	TRY_MEM(png, params->path);
	png->params = params;
	const enum status status = dem_png_open(&plain, params->path, &png->grid);
	if (status != STATUS_OK) {
		png_destroy(&png->raster);
		return status;
	}
	png->raster = (struct dem_placed){
		.locate = png_locate,
		.window = png_window,
		.destroy = png_destroy,
		.width = png->grid->width,
		.height = png->grid->height,
	};
	*out = &png->raster;
	return STATUS_OK;
}
