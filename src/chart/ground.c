/* The ground of a map alone, for a page that draws its own frame, ways and words. Without Pango. */
#include <math.h>
#include <stdio.h>

#include "chart/internal.h"

struct picture {
	const uint32_t *pixels; /* 0xffRRGGBB, the top row first */
	uint32_t width, height;
};

static void put(const void *user, uint32_t y, uint8_t *row)
{
	const struct picture *picture = user;
	const uint32_t *from = picture->pixels + (size_t)(picture->height - 1 - y) * picture->width;
	for (uint32_t x = 0; x < picture->width; x++)
		for (int c = 0; c < 3; c++)
			row[3 * x + (uint32_t)c] = (uint8_t)(from[x] >> (16 - 8 * c));
}

enum status chart_ground_write(const struct chart_map *map, const char *name, FILE *file, struct chart_ground *out)
{
	const struct chart_raster *raster = map->raster;
	const double longest = raster->width > raster->height ? raster->width : raster->height;
	struct chart_frame frame = {
		.width = (uint32_t)fmax(1, lround(map->pixels * raster->width / longest)),
		.height = (uint32_t)fmax(1, lround(map->pixels * raster->height / longest)),
	};
	frame.rect = (struct chart_rect){0, 0, frame.width / 2.0, frame.height / 2.0}; /* two pixels a point, as on a screen */
	*out = (struct chart_ground){.holes = chart_relief_has_holes(map)};
	TRY(chart_relief_range(map, &out->range, out->beyond));
	uint32_t *pixels = mem_alloc((size_t)frame.width * frame.height, sizeof *pixels);
	TRY_MEM(pixels, "a map");
	const struct picture picture = {pixels, frame.width, frame.height};
	const struct chart_png png = {frame.width, frame.height, 8, 3, put, &picture, .srgb = true, .small = true};
	chart_relief_fill(map, &out->range, &frame, pixels, frame.width);
	const enum status status = chart_png_file(file, name, &png);
	mem_free(pixels);
	return status;
}
