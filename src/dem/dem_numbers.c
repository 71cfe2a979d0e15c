/*
 * Reads a number of the soil at each post, from a raster.
 *
 * A post has a number if its nearest pixel has a value. The number is the bilinear mean of the four pixels around the post. Pixels
 * without a value are left out of the mean. Beyond the raster's edge its outermost pixels are used.
 */
#include <math.h>

#include "dem_placed.h"

static int64_t within(double pixel, int64_t pixels)
{
	return pixel < 0 ? 0 : pixel < (double)pixels ? (int64_t)pixel : pixels - 1;
}

/* Returns the number at a place of the raster; NaN: its nearest pixel has no value. */
static double number_at(const struct dem_pixels_part *part, double x, double y)
{
	const struct dem_placed *raster = part->pixels->raster;
	if (isnan(dem_pixels_value(part, dem_pixel_of(x, raster->width), dem_pixel_of(y, raster->height))))
		return (double)NAN;
	double west = floor(x - 0.5), north = floor(y - 0.5), east = x - 0.5 - west, south = y - 0.5 - north, sum = 0, weights = 0;
	for (int k = 0; k < 4; k++) {
		double weight = (k & 1 ? east : 1 - east) * (k & 2 ? south : 1 - south);
		if (!(weight > 0))
			continue;
		double value = dem_pixels_value(part, within(west + (k & 1), raster->width), within(north + (k >> 1), raster->height));
		if (isnan(value))
			continue;
		sum += weight * value;
		weights += weight;
	}
	return sum / weights;
}

static enum status fill(void *user, const struct dem_pixels_part *part)
{
	double *out = user;
	const struct dem_pixels *pixels = part->pixels;
	for (int64_t y = part->posts.y0; y < part->posts.y1; y++)
		for (int64_t x = part->posts.x0; x < part->posts.x1; x++) {
			int64_t i = y * part->stride + x;
			out[part->first + i] = isnan(pixels->x[i]) ? (double)NAN : number_at(part, pixels->x[i], pixels->y[i]);
		}
	return STATUS_OK;
}

enum status dem_numbers_read(struct dem_pixels *pixels, int level, struct post_rect rect, double *out)
{
	return dem_pixels_read(pixels, DEM_PLACED_NUMBERS, level, rect, fill, out);
}

static enum status refuse(const struct dem_pixels *pixels, const struct dem_numbers_range *range, int64_t column, int64_t row,
			  double value)
{
	return fail_with(STATUS_INPUT, "%s: column %lld, row %lld: %s %g%s%s is out of range; allowed: %s%.10g to %.10g, and nodata",
			 pixels->path, (long long)column, (long long)row, range->name, value, range->unit != NULL ? " " : "",
			 range->unit != NULL ? range->unit : "", range->above ? "above " : "", range->low, range->high);
}

enum status dem_numbers_extremes(struct dem_pixels *pixels, const struct dem_numbers_range *range, double *low, double *high)
{
	struct dem_placed *raster = pixels->raster;
	int64_t most = pixels->most_pixels;
	int64_t columns = raster->width < most ? raster->width : most, rows = most / columns;
	*low = INFINITY;
	*high = -INFINITY;
	for (int64_t y = 0; y < raster->height; y += rows)
		for (int64_t x = 0; x < raster->width; x += columns) {
			struct post_rect window = {x, y, x + columns < raster->width ? x + columns : raster->width,
						   y + rows < raster->height ? y + rows : raster->height};
			int64_t width = window.x1 - window.x0;
			TRY(raster->window(raster, window, pixels->values));
			for (int64_t i = 0; i < width * (window.y1 - window.y0); i++) {
				double value = pixels->values[i];
				if (value < range->low || value > range->high || (range->above && value == range->low))
					return refuse(pixels, range, x + i % width, y + i / width, value);
				*low = value < *low ? value : *low;
				*high = value > *high ? value : *high;
			}
		}
	if (*low > *high)
		return fail_with(STATUS_INPUT, "%s: has no value, all is nodata; give numbers, or take it away", pixels->path);
	return STATUS_OK;
}
