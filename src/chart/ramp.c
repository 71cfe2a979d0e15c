/*
 * Colours the values of a layer, over shaded ground. A colour ramp goes from the lowest value to the highest. 0 is fully
 * transparent, and small values let the ground's grey through. On flat ground a value has its ramp's own colour. Slopes darken and
 * lighten it as they do the grey, so that the shape of the ground can be seen.
 */
#include <math.h>

#include "chart/internal.h"

#define STOPS 4

/* Colours from 0 to the ramp's end. Below zero: blue to purple. Above zero: orange to red. */
static const uint8_t down[STOPS][3] = {{150, 205, 255}, {55, 130, 235}, {75, 50, 195}, {62, 0, 105}};
static const uint8_t up[STOPS][3] = {{255, 226, 140}, {253, 160, 50}, {222, 70, 25}, {125, 0, 32}};
static const uint8_t green[STOPS][3] = {{205, 235, 150}, {85, 185, 110}, {20, 120, 130}, {28, 38, 95}};
/* Heights: each stop is lighter than the one before, so that a copy in grey, and every eye, has them in order. */
static const uint8_t heights[][3] = {{84, 128, 134}, {116, 164, 140}, {172, 194, 142},
				      {218, 208, 160}, {238, 224, 194}, {252, 249, 242}};
static const uint8_t rose[STOPS][3] = {{252, 220, 180}, {240, 140, 120}, {185, 50, 120}, {65, 8, 90}};

static struct chart_colour between(const uint8_t (*stops)[3], int count, double t, double alpha)
{
	double at = t * (count - 1), rgb[3];
	int i = at < count - 2 ? (int)at : count - 2;
	for (int c = 0; c < 3; c++)
		rgb[c] = stops[i][c] + (at - i) * (stops[i + 1][c] - stops[i][c]) + 0.5;
	return (struct chart_colour){(uint8_t)rgb[0], (uint8_t)rgb[1], (uint8_t)rgb[2], (uint8_t)(255 * alpha + 0.5)};
}

struct chart_colour chart_ramp(enum chart_ramp ramp, double t)
{
	if (ramp == CHART_RAMP_HEIGHTS)
		return between(heights, (int)(sizeof heights / sizeof *heights), fmin(fmax(t, 0), 1), 0.92);
	const uint8_t(*stops)[3] = ramp == CHART_RAMP_GREEN  ? green
				   : ramp == CHART_RAMP_ROSE ? rose
				   : t < 0		      ? down
							      : up;
	double size = fmin(fabs(t), 1);
	return between(stops, STOPS, size, fmin(1.6 * sqrt(size), 0.94));
}

struct chart_colour chart_ground_colour(double shade, double flat, struct chart_colour over)
{
	static const double tint[3] = {1, 0.992, 0.972}; /* of paper */
	if (isnan(shade))
		return (struct chart_colour){214, 219, 226, 255};
	/* A map's ground is paler than a hillshade alone, so that the values over it are easy to see. */
	double alpha = over.a / 255.0, grey = 255 * (0.28 + 0.72 * shade);
	double lit = fmin(fmax(1 + 0.7 * (shade - flat), 0.5), 1.12);
	const uint8_t rgb[3] = {over.r, over.g, over.b};
	uint8_t mixed[3];
	for (int c = 0; c < 3; c++)
		mixed[c] = (uint8_t)fmin(grey * tint[c] * (1 - alpha) + rgb[c] * lit * alpha + 0.5, 255);
	return (struct chart_colour){mixed[0], mixed[1], mixed[2], 255};
}

double chart_ramp_place(enum chart_ramp ramp, const struct chart_range *range, double value)
{
	if (ramp == CHART_RAMP_HEIGHTS)
		return range->high > range->low ? (value - range->low) / (range->high - range->low) : 0.5;
	double end = value < 0 ? -range->low : range->high;
	return end > 0 ? value / end : 0;
}
