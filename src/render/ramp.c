/*
 * Colours the values of a layer, over shaded ground. A colour ramp goes from the lowest value to the highest. 0 is fully
 * transparent, and small values let the ground's grey through. On flat ground a value has its ramp's own colour. Slopes darken and
 * lighten it as they do the grey, so that the shape of the ground can be seen.
 */
#include <math.h>

#include "render/internal.h"

#define STOPS 4

/* Colours from 0 to the ramp's end. Below zero: blue to purple. Above zero: orange to red. */
static const uint8_t down[STOPS][3] = {{150, 205, 255}, {55, 130, 235}, {75, 50, 195}, {62, 0, 105}};
static const uint8_t up[STOPS][3] = {{255, 226, 140}, {253, 160, 50}, {222, 70, 25}, {125, 0, 32}};
static const uint8_t green[STOPS][3] = {{205, 235, 150}, {85, 185, 110}, {20, 120, 130}, {28, 38, 95}};
static const uint8_t rose[STOPS][3] = {{252, 220, 180}, {240, 140, 120}, {185, 50, 120}, {65, 8, 90}};

struct render_colour render_ramp(enum render_ramp ramp, double t)
{
	const uint8_t(*stops)[3] = ramp == RENDER_RAMP_GREEN  ? green
				   : ramp == RENDER_RAMP_ROSE ? rose
				   : t < 0		      ? down
							      : up;
	double size = fmin(fabs(t), 1), at = size * (STOPS - 1);
	int i = at < STOPS - 2 ? (int)at : STOPS - 2;
	double share = at - i, rgb[3];
	for (int c = 0; c < 3; c++)
		rgb[c] = stops[i][c] + share * (stops[i + 1][c] - stops[i][c]) + 0.5;
	double alpha = fmin(1.6 * sqrt(size), 0.94);
	return (struct render_colour){(uint8_t)rgb[0], (uint8_t)rgb[1], (uint8_t)rgb[2], (uint8_t)(255 * alpha + 0.5)};
}

struct render_colour render_ground_colour(double shade, double flat, struct render_colour over)
{
	static const double tint[3] = {1, 0.992, 0.972}; /* of paper */
	if (isnan(shade))
		return (struct render_colour){214, 219, 226, 255};
	/* A map's ground is paler than a hillshade alone, so that the values over it are easy to see. */
	double alpha = over.a / 255.0, grey = 255 * (0.28 + 0.72 * shade);
	double lit = fmin(fmax(1 + 0.7 * (shade - flat), 0.5), 1.12);
	const uint8_t rgb[3] = {over.r, over.g, over.b};
	uint8_t mixed[3];
	for (int c = 0; c < 3; c++)
		mixed[c] = (uint8_t)fmin(grey * tint[c] * (1 - alpha) + rgb[c] * lit * alpha + 0.5, 255);
	return (struct render_colour){mixed[0], mixed[1], mixed[2], 255};
}

double render_ramp_place(const struct render_range *range, double value)
{
	double end = value < 0 ? -range->low : range->high;
	return end > 0 ? value / end : 0;
}
