/* Computes the colours of a layer's values on the CPU, for a legend. shaders/lib/layer.glsl computes the same colours. */
#include <math.h>

#include "render/internal.h"

#define STOPS 5
static const uint8_t rising[STOPS][3] = {{69, 0, 84}, {59, 82, 140}, {33, 145, 140}, {94, 201, 97}, {252, 232, 36}};
static const uint8_t paper[3] = {232, 230, 224}; /* under an offset of nothing */

struct chart_colour render_layer_colour(enum render_layer_kind kind, double t)
{
	uint8_t rgb[3];
	double place = fmin(fmax(t, 0), 1) * (STOPS - 1);
	int below = place < STOPS - 2 ? (int)place : STOPS - 2;
	if (kind == RENDER_OFFSETS) {
		struct chart_colour over = chart_ramp(CHART_RAMP_SIGNED, 2 * fmin(fmax(t, 0), 1) - 1);
		const uint8_t above[3] = {over.r, over.g, over.b};
		for (int c = 0; c < 3; c++)
			rgb[c] = (uint8_t)((above[c] * over.a + paper[c] * (255 - over.a) + 127) / 255);
	} else {
		for (int c = 0; c < 3; c++)
			rgb[c] = (uint8_t)(rising[below][c] + (place - below) * (rising[below + 1][c] - rising[below][c]) + 0.5);
	}
	return (struct chart_colour){rgb[0], rgb[1], rgb[2], 255};
}
