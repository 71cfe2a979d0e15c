/*
 * The ground of a map, as pixels: shaded, with the colours of values or classes over it.
 *
 * A frame has as many pixels as its page asks for, at least about one a post. Shades are interpolated between posts. So are values,
 * unless posts are so large that they are seen as squares. Holes, and classes, are those of the nearest post.
 */
#include <math.h>

#include "chart/internal.h"

#define SHARE 0.999 /* part of the values that are within the legend's range */
#define OUTLIERS 2  /* the range goes to the largest value, unless that is so many times as large */
#define SQUARES 3   /* pixels a post, from which on a post is a square of its value */
#define HATCH 5.0   /* points between the lines that mean no data */
#define HATCH_LINE 0.6

/* --- the range --- */

static void height_range(const struct chart_raster *raster, struct chart_range *range)
{
	bool any = false;
	for (size_t i = 0; i < (size_t)raster->width * raster->height; i++) {
		const double value = raster->values[i];
		if (isnan(value))
			continue;
		range->low = any ? fmin(range->low, value) : value;
		range->high = any ? fmax(range->high, value) : value;
		any = true;
	}
}

/* Finds the range of values of both signs, or of one, whose ends are 0 and the largest value. It is a rounder and smaller one if a few values are
 * much larger than all others. */
static void value_range(enum chart_ramp ramp, double size, double low, double high, struct chart_range *range)
{
	const double most = fmax(-low, high), end = most <= OUTLIERS * size ? most : chart_round_range(size);
	range->low = low < 0 && ramp == CHART_RAMP_SIGNED ? -end : 0;
	range->high = high > 0 || ramp != CHART_RAMP_SIGNED ? end : 0;
}

enum status chart_relief_range(const struct chart_map *map, struct chart_range *range, double beyond[2])
{
	double size, low, high;
	*range = map->range;
	beyond[0] = beyond[1] = (double)NAN;
	if (map->classes != NULL || map->colours != NULL)
		return STATUS_OK;
	if (map->ramp == CHART_RAMP_HEIGHTS) {
		struct chart_range found = {0, 0};
		height_range(map->raster, &found);
		if (range->low == 0 && range->high == 0)
			*range = found;
		beyond[0] = found.low < range->low ? found.low : (double)NAN;
		beyond[1] = found.high > range->high ? found.high : (double)NAN;
		return STATUS_OK;
	}
	TRY(chart_raster_spread(map->raster, SHARE, &size, &low, &high));
	if (range->low == 0 && range->high == 0 && size > 0)
		value_range(map->ramp, size, low, high, range);
	beyond[0] = low < range->low * (1 + 1e-9) ? low : (double)NAN;
	beyond[1] = high > range->high * (1 + 1e-9) ? high : (double)NAN;
	return STATUS_OK;
}

bool chart_relief_has_holes(const struct chart_map *map)
{
	const size_t pixels = (size_t)map->raster->width * map->raster->height;
	size_t i = 0;
	while (i < pixels && !isnan(map->raster->shade[i]))
		i++;
	return i < pixels;
}

/* --- pixels --- */

/* Where a pixel of the frame is on the raster: the post, and how far it is to the next one. */
struct spot {
	int64_t x, y, nearest_x, nearest_y;
	double u, v;
};

static void place(uint32_t pixel, uint32_t pixels, uint32_t posts, int64_t *first, int64_t *nearest, double *share)
{
	const double at = (pixel + 0.5) * posts / pixels;
	const int64_t last = (int64_t)posts - 1;
	*nearest = (int64_t)at < last ? (int64_t)at : last;
	*first = (int64_t)floor(at - 0.5);
	*share = at - 0.5 - (double)*first;
}

/* Interpolates between the four posts around the spot. Posts that are NaN, or not there, have the value of the nearest one. */
static double between(const float *plane, const struct chart_raster *raster, const struct spot *spot)
{
	const int64_t right = (int64_t)raster->width - 1, top = (int64_t)raster->height - 1;
	const double here = plane[spot->nearest_y * raster->width + spot->nearest_x];
	double sum = 0;
	for (int64_t i = 0; i < 4 && !isnan(here); i++) {
		int64_t x = spot->x + (i & 1), y = spot->y + (i >> 1);
		x = x < 0 ? 0 : x < right ? x : right;
		y = y < 0 ? 0 : y < top ? y : top;
		const double value = plane[y * raster->width + x];
		sum += (isnan(value) ? here : value) * (i & 1 ? spot->u : 1 - spot->u) * (i >> 1 ? spot->v : 1 - spot->v);
	}
	return isnan(here) ? here : sum;
}

/* The colour of a class, lit as its ground is. */
static struct chart_colour class_colour(const struct chart_map *map, double shade, size_t at)
{
	const struct chart_colour none = {0, 0, 0, 0};
	const uint8_t class = map->classes[at];
	if (class >= map->key_count)
		return chart_ground_colour(NAN, 0, none);
	const struct chart_colour colour = map->keys[class].colour;
	const double light = 0.55 + 0.6 * (isnan(shade) ? 0.7 : shade);
	return (struct chart_colour){(uint8_t)fmin(255, colour.r * light), (uint8_t)fmin(255, colour.g * light),
				     (uint8_t)fmin(255, colour.b * light), 255};
}

static struct chart_colour value_colour(const struct chart_map *map, const struct chart_range *range, double shade, double value)
{
	const struct chart_colour over = chart_ramp(map->ramp, isnan(value) ? 0 : chart_ramp_place(map->ramp, range, value));
	return chart_ground_colour(shade, map->raster->flat, over);
}

/* The colour of imagery, lit a little as its ground is: pictures have the light of their day. Nearest pixel. */
static struct chart_colour imagery_colour(const struct chart_map *map, double shade, size_t at)
{
	const uint8_t *pixel = map->colours + 4 * at;
	const double flat = map->raster->flat;
	const struct chart_colour over = {pixel[0], pixel[1], pixel[2], pixel[3]};
	return chart_ground_colour(isnan(shade) ? shade : flat + 0.5 * (shade - flat), flat, over);
}

void chart_relief_fill(const struct chart_map *map, const struct chart_range *range, const struct chart_frame *frame,
		       uint32_t *pixels, size_t stride)
{
	const struct chart_raster *raster = map->raster;
	const struct chart_colour hatched = {150, 160, 174, 255};
	const double dots = frame->width / (frame->rect.x1 - frame->rect.x0);
	const uint32_t apart = (uint32_t)fmax(4, lround(HATCH * dots)), line = (uint32_t)fmax(1, lround(HATCH_LINE * dots));
	const bool squares = frame->width >= SQUARES * raster->width;
	struct spot spot;
	for (uint32_t row = 0; row < frame->height; row++) {
		place(frame->height - 1 - row, frame->height, raster->height, &spot.y, &spot.nearest_y, &spot.v);
		for (uint32_t x = 0; x < frame->width; x++) {
			place(x, frame->width, raster->width, &spot.x, &spot.nearest_x, &spot.u);
			const size_t at = (size_t)spot.nearest_y * raster->width + (size_t)spot.nearest_x;
			const double shade = between(raster->shade, raster, &spot);
			struct chart_colour colour =
				map->classes != NULL
					? class_colour(map, shade, at)
				: map->colours != NULL
					? imagery_colour(map, shade, at)
					: value_colour(map, range, shade,
						       squares ? raster->values[at] : between(raster->values, raster, &spot));
			const bool hole = map->classes != NULL ? map->classes[at] >= map->key_count : isnan(shade);
			if (hole && (x + row) % apart < line)
				colour = hatched;
			pixels[row * stride + x] = 0xff000000u | (uint32_t)colour.r << 16 | (uint32_t)colour.g << 8 | colour.b;
		}
	}
}
