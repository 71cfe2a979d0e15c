/*
 * Tells the soil class of each post: the value of the nearest pixel of the class raster.
 *
 * 1. The class of a post depends on this post alone, not on other posts that are read with it.
 * 2. A tile is read as one window of pixels. If that is too large, the tile is halved until each window is small enough.
 */
#include "dem_classes.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PART_POSTS (1 << 18)
#define EDGE 1e-6 /* of a pixel: a post on the raster's rim is in it, whatever was rounded */

struct dem_classes {
	char *path, *srs;
	struct extent extent;
	struct dem_classes_params params; /* of the above */
	struct dem_raster_of_classes *raster;
	double *x, *y;   /* columns and rows of the posts being read, whole; NaN: beyond the raster */
	int32_t *values; /* of a window */
};

enum status dem_classes_open(const struct dem_classes_params *params, struct dem_classes **out)
{
	*out = NULL;
	struct dem_classes *classes = mem_calloc(1, sizeof *classes);
	if (classes == NULL)
		return fail_memory("opening a map of classes");
	classes->path = mem_strdup(params->path);
	classes->srs = mem_strdup(params->srs);
	classes->extent = *params->extent;
	classes->params = (struct dem_classes_params){
		.path = classes->path,
		.extent = &classes->extent,
		.srs = classes->srs,
		.origin = {params->origin[0], params->origin[1]},
	};
	classes->x = mem_alloc(PART_POSTS, sizeof *classes->x);
	classes->y = mem_alloc(PART_POSTS, sizeof *classes->y);
	classes->values = mem_alloc(DEM_CLASSES_WINDOW, sizeof *classes->values);
	enum status status;
	if (classes->path == NULL || classes->srs == NULL || classes->x == NULL || classes->y == NULL ||
	    classes->values == NULL)
		status = fail_memory("opening a map of classes");
	else if (dem_path_ends(classes->path, ".png"))
		status = dem_classes_png_open(&classes->params, &classes->raster);
	else
		status = dem_classes_gdal_open(&classes->params, &classes->raster);
	if (status != STATUS_OK) {
		dem_classes_close(classes);
		return status;
	}
	*out = classes;
	return STATUS_OK;
}

void dem_classes_close(struct dem_classes *classes)
{
	if (classes == NULL)
		return;
	if (classes->raster != NULL)
		classes->raster->destroy(classes->raster);
	mem_free(classes->x);
	mem_free(classes->y);
	mem_free(classes->values);
	mem_free(classes->srs);
	mem_free(classes->path);
	mem_free(classes);
}

/* Returns the pixel that contains a position, also on the raster's edges. NaN if the position is outside. */
static double pixel_of(double place, int64_t pixels)
{
	if (!(place >= -EDGE && place <= (double)pixels + EDGE))
		return (double)NAN;
	double pixel = floor(place);
	pixel = pixel < 0 ? 0 : pixel;
	return pixel < (double)pixels ? pixel : (double)(pixels - 1);
}

/* Finds the pixel of each post of a part. */
static void locate(struct dem_classes *classes, int level, struct post_rect part)
{
	struct dem_raster_of_classes *raster = classes->raster;
	size_t count = 0;
	for (int64_t y = part.y0; y < part.y1; y++)
		for (int64_t x = part.x0; x < part.x1; x++, count++) {
			classes->x[count] = ldexp((double)x, level);
			classes->y[count] = ldexp((double)y, level);
		}
	raster->locate(raster, count, classes->x, classes->y);
	for (size_t i = 0; i < count; i++) {
		classes->x[i] = pixel_of(classes->x[i], raster->width);
		classes->y[i] = pixel_of(classes->y[i], raster->height);
		if (isnan(classes->y[i]))
			classes->x[i] = (double)NAN;
	}
}

struct reading {
	struct dem_classes *classes;
	int64_t stride; /* posts of a row, of the part and of what is asked for */
	const uint8_t *table;
	uint8_t absent;
	uint8_t *out; /* of the part */
};

/* Returns the rectangle of pixels that the posts of the part need. It is empty if all are outside the raster. */
static struct post_rect window_of(const struct reading *reading, struct post_rect posts)
{
	struct post_rect window = {INT64_MAX, INT64_MAX, -1, -1};
	for (int64_t y = posts.y0; y < posts.y1; y++)
		for (int64_t x = posts.x0; x < posts.x1; x++) {
			int64_t i = y * reading->stride + x;
			if (isnan(reading->classes->x[i]))
				continue;
			int64_t column = (int64_t)reading->classes->x[i], row = (int64_t)reading->classes->y[i];
			window.x0 = column < window.x0 ? column : window.x0;
			window.y0 = row < window.y0 ? row : window.y0;
			window.x1 = column >= window.x1 ? column + 1 : window.x1;
			window.y1 = row >= window.y1 ? row + 1 : window.y1;
		}
	return window;
}

static enum status fill(const struct reading *reading, struct post_rect posts, struct post_rect window)
{
	struct dem_classes *classes = reading->classes;
	int64_t width = window.x1 - window.x0;
	enum status status = classes->raster->window(classes->raster, window, classes->values);
	if (status != STATUS_OK)
		return status;
	for (int64_t y = posts.y0; y < posts.y1; y++)
		for (int64_t x = posts.x0; x < posts.x1; x++) {
			int64_t i = y * reading->stride + x;
			reading->out[i] = reading->absent;
			if (isnan(classes->x[i]))
				continue;
			int64_t column = (int64_t)classes->x[i], row = (int64_t)classes->y[i];
			int32_t value = classes->values[(row - window.y0) * width + column - window.x0];
			if (value == DEM_CLASS_NONE)
				continue;
			if (value < 0 || value > 255)
				return fail_with(STATUS_INPUT, "%s: column %lld, row %lld: its value %d is no class; allowed: "
						 "0 to 255, and nodata", classes->path, (long long)column, (long long)row,
						 (int)value);
			reading->out[i] = reading->table[value];
		}
	return STATUS_OK;
}

/* Posts of the part, in halves while their pixels are too many: at last one post needs one pixel. */
static enum status fill_halved(const struct reading *reading, struct post_rect posts)
{
	struct post_rect window = window_of(reading, posts), first = posts, second = posts;
	int64_t width = posts.x1 - posts.x0, height = posts.y1 - posts.y0;
	if (post_rect_empty(window)) {
		for (int64_t y = posts.y0; y < posts.y1; y++)
			memset(reading->out + y * reading->stride + posts.x0, reading->absent, (size_t)width);
		return STATUS_OK;
	}
	if (window.x1 - window.x0 <= DEM_CLASSES_WINDOW / (window.y1 - window.y0))
		return fill(reading, posts, window);
	if (height >= width)
		first.y1 = second.y0 = posts.y0 + height / 2;
	else
		first.x1 = second.x0 = posts.x0 + width / 2;
	enum status status = fill_halved(reading, first);
	return status != STATUS_OK ? status : fill_halved(reading, second);
}

enum status dem_classes_read(struct dem_classes *classes, int level, struct post_rect rect,
			     const uint8_t table[256], uint8_t absent, uint8_t *out)
{
	int64_t width = rect.x1 - rect.x0;
	enum status status = STATUS_OK;
	assert(width <= PART_POSTS);
	int64_t rows = width > 0 ? PART_POSTS / width : 0;
	for (int64_t y = rect.y0; width > 0 && y < rect.y1 && status == STATUS_OK; y += rows) {
		struct post_rect part = {rect.x0, y, rect.x1, y + rows < rect.y1 ? y + rows : rect.y1};
		struct reading reading = {classes, width, table, absent, out + (y - rect.y0) * width};
		locate(classes, level, part);
		status = fill_halved(&reading, (struct post_rect){0, 0, width, part.y1 - part.y0});
	}
	return status;
}
