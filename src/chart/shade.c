/*
 * Hillshade: slopes by Horn's 3 x 3 posts, and how light ground of a slope is.
 *
 * Slopes are metres a metre, whatever the level. Where one neighbour is nodata, the slope of the post's other side is used. So
 * evenly inclined ground has the same slope up to its edge. Where both neighbours are nodata, the ground is taken to be level. If a
 * corner of the 3 x 3 posts is nodata, its height is extrapolated from the two posts beside it.
 *
 * The light is that of a sun. Two more suns, lower and at its sides, and the sky soften it. So slopes that are parallel to the sun's
 * direction get different brightness, too. Flat ground is well below white, and slopes that face away are not black.
 */
#include <math.h>

#include "chart/internal.h"

/* Replaces NaN in two opposite neighbours of `here`, which is a number. */
static void go_on(double *a, double *b, double here)
{
	double was = *a;
	if (isnan(*a))
		*a = isnan(*b) ? here : 2 * here - *b;
	if (isnan(*b))
		*b = isnan(was) ? here : 2 * here - was;
}

void chart_slopes(const double *heights, int64_t width, int64_t rows, double spacing, double *east, double *north)
{
	int64_t stride = width + 2;
	for (int64_t y = 0; y < rows; y++)
		for (int64_t x = 0; x < width; x++) {
			const double *p = heights + (y + 1) * stride + x + 1;
			double sw = p[-stride - 1], s = p[-stride], se = p[-stride + 1], w = p[-1], e = p[1];
			double nw = p[stride - 1], n = p[stride], ne = p[stride + 1];
			go_on(&w, &e, p[0]);
			go_on(&s, &n, p[0]);
			sw = isnan(sw) ? s + w - p[0] : sw;
			se = isnan(se) ? s + e - p[0] : se;
			nw = isnan(nw) ? n + w - p[0] : nw;
			ne = isnan(ne) ? n + e - p[0] : ne;
			bool known = !isnan(p[0]);
			*east++ = known ? (ne + 2 * e + se - nw - 2 * w - sw) / (8 * spacing) : (double)NAN;
			*north++ = known ? (nw + 2 * n + ne - sw - 2 * s - se) / (8 * spacing) : (double)NAN;
		}
}

/* Directions of light: the sun, two lower ones at its sides, and the sky straight above. */
static const struct {
	double turn, lower, weight;
} suns[CHART_SUNS] = {{0, 0, 0.52}, {-M_PI * 65 / 180, M_PI / 12, 0.17}, {M_PI * 65 / 180, M_PI / 12, 0.17}, {0, -M_PI, 0.14}};

void chart_sun_of(double azimuth, double altitude, struct chart_sun *sun)
{
	for (size_t i = 0; i < CHART_SUNS; i++) {
		double turned = azimuth + suns[i].turn, up = fmin(fmax(altitude - suns[i].lower, M_PI / 18), M_PI / 2);
		sun->toward[i][0] = suns[i].weight * cos(up) * sin(turned);
		sun->toward[i][1] = suns[i].weight * cos(up) * cos(turned);
		sun->toward[i][2] = suns[i].weight * sin(up);
	}
}

double chart_shade(const struct chart_sun *sun, double east, double north)
{
	double light = 0, length = sqrt(1 + east * east + north * north);
	for (size_t i = 0; i < CHART_SUNS; i++)
		light += fmax(sun->toward[i][2] - sun->toward[i][0] * east - sun->toward[i][1] * north, 0);
	light = fmin(light / length / 0.84, 1); /* that much comes from no slope */
	return isnan(length) ? length : 0.04 + 0.96 * light * (0.5 + 0.5 * light);
}
