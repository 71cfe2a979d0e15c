/*
 * Reads the pixels around posts from a raster that lies over the terrain.
 *
 * 1. What a post gets depends on this post alone, not on other posts that are read with it.
 * 2. A tile is read as one window of pixels. If that is too large, the tile is halved until each window is small enough.
 */
#include "dem_placed.h"

#include <assert.h>
#include <math.h>

#define EDGE 1e-6 /* pixels: a post on the raster's edge is in it, also after rounding */

static const char *const opening[] = {
	[DEM_PLACED_CLASSES] = "opening a map of classes",
	[DEM_PLACED_NUMBERS] = "opening a raster of soil numbers",
};

static enum status open(struct dem_pixels *pixels, const struct dem_placed_params *params)
{
	bool classes = pixels->kind == DEM_PLACED_CLASSES;
	pixels->path = mem_strdup(params->path);
	pixels->srs = mem_strdup(params->srs);
	pixels->extent = *params->extent;
	pixels->params = (struct dem_placed_params){
		.path = pixels->path,
		.extent = &pixels->extent,
		.srs = pixels->srs,
		.origin = {params->origin[0], params->origin[1]},
	};
	/* A loader has one map of classes, but up to four rasters of numbers. */
	pixels->most_posts = classes ? 1 << 18 : 1 << 16;
	pixels->most_pixels = classes ? 1 << 19 : 1 << 18;
	pixels->beside = classes ? 0 : 1;
	pixels->x = mem_alloc((size_t)pixels->most_posts, sizeof *pixels->x);
	pixels->y = mem_alloc((size_t)pixels->most_posts, sizeof *pixels->y);
	pixels->values = mem_alloc((size_t)pixels->most_pixels, sizeof *pixels->values);
	TRY_MEM(pixels->path != NULL && pixels->srs != NULL && pixels->x != NULL && pixels->y != NULL && pixels->values != NULL, opening[pixels->kind]);
	if (dem_path_ends(pixels->path, ".png"))
		return dem_placed_png_open(&pixels->params, pixels->kind, &pixels->raster);
	return dem_placed_gdal_open(&pixels->params, pixels->kind, pixels->most_pixels, &pixels->raster);
}

enum status dem_pixels_open(const struct dem_placed_params *params, enum dem_placed_kind kind, struct dem_pixels **out)
{
	*out = NULL;
	struct dem_pixels *pixels = mem_calloc(1, sizeof *pixels);
	TRY_MEM(pixels, opening[kind]);
	pixels->kind = kind;
	enum status status = open(pixels, params);
	if (status != STATUS_OK) {
		dem_pixels_close(pixels);
		return status;
	}
	*out = pixels;
	return STATUS_OK;
}

void dem_pixels_close(struct dem_pixels *pixels)
{
	if (pixels == NULL)
		return;
	if (pixels->raster != NULL)
		pixels->raster->destroy(pixels->raster);
	mem_free_all(pixels->x, pixels->y, pixels->values, pixels->srs, pixels->path, pixels);
}

int64_t dem_pixel_of(double place, int64_t pixels)
{
	double pixel = floor(place);
	pixel = pixel < 0 ? 0 : pixel;
	return pixel < (double)pixels ? (int64_t)pixel : pixels - 1;
}

static bool is_in(double place, int64_t pixels)
{
	return place >= -EDGE && place <= (double)pixels + EDGE;
}

/* Finds the place of each post of a part on the raster. */
static void locate(struct dem_pixels *pixels, int level, struct post_rect part)
{
	struct dem_placed *raster = pixels->raster;
	size_t count = 0;
	for (int64_t y = part.y0; y < part.y1; y++)
		for (int64_t x = part.x0; x < part.x1; x++, count++) {
			pixels->x[count] = ldexp((double)x, level);
			pixels->y[count] = ldexp((double)y, level);
		}
	raster->locate(raster, count, pixels->x, pixels->y);
	for (size_t i = 0; i < count; i++)
		if (!is_in(pixels->x[i], raster->width) || !is_in(pixels->y[i], raster->height))
			pixels->x[i] = pixels->y[i] = (double)NAN;
}

static void widen(int64_t *low, int64_t *high, int64_t pixel, int beside, int64_t pixels)
{
	int64_t first = pixel - beside > 0 ? pixel - beside : 0, end = pixel + 1 + beside < pixels ? pixel + 1 + beside : pixels;
	*low = first < *low ? first : *low;
	*high = end > *high ? end : *high;
}

/* Returns the rectangle of pixels that the posts need. It is empty if all are outside of the raster. */
static struct post_rect window_of(const struct dem_pixels_part *part)
{
	const struct dem_pixels *pixels = part->pixels;
	const struct dem_placed *raster = pixels->raster;
	struct post_rect window = {INT64_MAX, INT64_MAX, -1, -1};
	for (int64_t y = part->posts.y0; y < part->posts.y1; y++)
		for (int64_t x = part->posts.x0; x < part->posts.x1; x++) {
			int64_t i = y * part->stride + x;
			if (isnan(pixels->x[i]))
				continue;
			widen(&window.x0, &window.x1, dem_pixel_of(pixels->x[i], raster->width), pixels->beside, raster->width);
			widen(&window.y0, &window.y1, dem_pixel_of(pixels->y[i], raster->height), pixels->beside, raster->height);
		}
	return window;
}

/* Fills the posts of a part. Halves the part while its posts need too many pixels; a single post needs few. */
static enum status fill_halved(struct dem_pixels *pixels, struct dem_pixels_part part, dem_pixels_fn fill, void *user)
{
	struct dem_pixels_part first = part, second = part;
	int64_t width = part.posts.x1 - part.posts.x0, height = part.posts.y1 - part.posts.y0;
	part.window = window_of(&part);
	bool empty = post_rect_empty(part.window);
	if (empty || part.window.x1 - part.window.x0 <= pixels->most_pixels / (part.window.y1 - part.window.y0)) {
		if (!empty)
			TRY(pixels->raster->window(pixels->raster, part.window, pixels->values));
		return fill(user, &part);
	}
	if (height >= width)
		first.posts.y1 = second.posts.y0 = part.posts.y0 + height / 2;
	else
		first.posts.x1 = second.posts.x0 = part.posts.x0 + width / 2;
	TRY(fill_halved(pixels, first, fill, user));
	return fill_halved(pixels, second, fill, user);
}

enum status dem_pixels_read(struct dem_pixels *pixels, enum dem_placed_kind kind, int level, struct post_rect rect, dem_pixels_fn fill,
			    void *user)
{
	assert(pixels->kind == kind);
	int64_t width = rect.x1 - rect.x0;
	assert(width <= pixels->most_posts);
	int64_t rows = width > 0 ? pixels->most_posts / width : 0;
	for (int64_t y = rect.y0; width > 0 && y < rect.y1; y += rows) {
		struct post_rect posts = {rect.x0, y, rect.x1, y + rows < rect.y1 ? y + rows : rect.y1};
		const struct dem_pixels_part part = {
			.pixels = pixels,
			.posts = {0, 0, width, posts.y1 - posts.y0},
			.stride = width,
			.first = (y - rect.y0) * width,
		};
		locate(pixels, level, posts);
		TRY(fill_halved(pixels, part, fill, user));
	}
	return STATUS_OK;
}
