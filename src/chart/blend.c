/* Colours over pixels that somebody else drew. */
#include "chart/internal.h"

void chart_blend(uint8_t *to, struct chart_colour colour, unsigned cover)
{
	const unsigned alpha = (colour.a * cover + 127) / 255, under = (to[3] * (255 - alpha) + 127) / 255, all = alpha + under;
	if (alpha == 0)
		return;
	to[0] = (uint8_t)((colour.r * alpha + to[0] * under + all / 2) / all);
	to[1] = (uint8_t)((colour.g * alpha + to[1] * under + all / 2) / all);
	to[2] = (uint8_t)((colour.b * alpha + to[2] * under + all / 2) / all);
	to[3] = (uint8_t)all;
}

static uint32_t clip(int at, uint32_t size)
{
	return at < 0 ? 0 : (uint32_t)at < size ? (uint32_t)at : size;
}

void chart_box(const struct chart_pixels *pixels, int x0, int y0, int x1, int y1, struct chart_colour colour)
{
	const uint32_t left = clip(x0, pixels->width), right = clip(x1, pixels->width);
	for (uint32_t y = clip(y0, pixels->height); y < clip(y1, pixels->height); y++)
		for (uint32_t x = left; x < right; x++)
			chart_blend(pixels->pixels + 4 * ((size_t)y * pixels->width + x), colour, 255);
}
