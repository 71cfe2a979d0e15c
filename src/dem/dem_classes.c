/* Reads the soil class of each post: the value of the nearest pixel of the class raster. */
#include <math.h>

#include "dem_placed.h"

struct reading {
	const uint8_t *table;
	uint8_t absent;
	uint8_t *out;
};

static enum status fill(void *user, const struct dem_pixels_part *part)
{
	const struct reading *reading = user;
	const struct dem_pixels *pixels = part->pixels;
	for (int64_t y = part->posts.y0; y < part->posts.y1; y++)
		for (int64_t x = part->posts.x0; x < part->posts.x1; x++) {
			int64_t i = y * part->stride + x;
			uint8_t *out = &reading->out[part->first + i];
			*out = reading->absent;
			if (isnan(pixels->x[i]))
				continue;
			int64_t column = dem_pixel_of(pixels->x[i], pixels->raster->width),
				row = dem_pixel_of(pixels->y[i], pixels->raster->height);
			double value = dem_pixels_value(part, column, row);
			if (isnan(value))
				continue;
			if (value < 0 || value > 255)
				return fail_with(STATUS_INPUT, "%s: column %lld, row %lld: its value %.0f is no class; allowed: "
						 "0 to 255, and nodata", pixels->path, (long long)column, (long long)row, value);
			*out = reading->table[(int)value];
		}
	return STATUS_OK;
}

enum status dem_classes_read(struct dem_pixels *pixels, int level, struct post_rect rect,
			     const uint8_t table[256], uint8_t absent, uint8_t *out)
{
	struct reading reading = {table, absent, out};
	return dem_pixels_read(pixels, DEM_PLACED_CLASSES, level, rect, fill, &reading);
}
