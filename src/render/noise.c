/*
 * The ground's noise: seamless value noise of several octaves, made once. Each texel carries its
 * 2 x 2 neighbours, so that the shader's bilinear sample is one fetch.
 */
#include <math.h>

#include "render/internal.h"

#define SIZE RENDER_NOISE_SIZE

static uint32_t hash(uint32_t x, uint32_t y, uint32_t seed)
{
	uint32_t h = x * 0x8da6b343u ^ y * 0xd8163841u ^ seed * 0xcb1ab31fu;
	h = (h ^ h >> 15) * 0x2c1b3c6du;
	h = (h ^ h >> 12) * 0x297a2d39u;
	return h ^ h >> 15;
}

static double corner(uint32_t x, uint32_t y, uint32_t cells, uint32_t seed)
{
	return hash(x % cells, y % cells, seed) / 4294967295.0;
}

/* One octave, `cells` lattice cells across the tile, 0 .. 1. */
static double octave(uint32_t x, uint32_t y, uint32_t cells, uint32_t seed)
{
	double u = (double)x * cells / SIZE, v = (double)y * cells / SIZE;
	uint32_t i = (uint32_t)u, j = (uint32_t)v;
	double fx = u - i, fy = v - j;
	fx = fx * fx * fx * (fx * (6 * fx - 15) + 10);
	fy = fy * fy * fy * (fy * (6 * fy - 15) + 10);
	double low = corner(i, j, cells, seed) * (1 - fx) + corner(i + 1, j, cells, seed) * fx;
	double high = corner(i, j + 1, cells, seed) * (1 - fx) + corner(i + 1, j + 1, cells, seed) * fx;
	return low * (1 - fy) + high * fy;
}

static double clouds(uint32_t x, uint32_t y)
{
	double sum = 0, weight = 1, total = 0;
	for (uint32_t cells = 6, seed = 1; cells <= 96; cells *= 2, seed++) {
		sum += weight * octave(x, y, cells, seed);
		total += weight;
		weight *= 0.72;
	}
	return sum / total;
}

/* Stretched so that the values use the whole of 0 .. 255. */
void render_noise_fill(uint8_t *texels)
{
	double low = 1, high = 0;
	for (uint32_t y = 0; y < SIZE; y++)
		for (uint32_t x = 0; x < SIZE; x++) {
			double v = clouds(x, y);
			low = fmin(low, v);
			high = fmax(high, v);
		}
	for (uint32_t y = 0; y < SIZE; y++)
		for (uint32_t x = 0; x < SIZE; x++)
			texels[4 * (y * SIZE + x)] = (uint8_t)lround((clouds(x, y) - low) / (high - low) * 255);
	for (uint32_t y = 0; y < SIZE; y++)
		for (uint32_t x = 0; x < SIZE; x++) {
			uint32_t east = (x + 1) % SIZE, north = (y + 1) % SIZE;
			texels[4 * (y * SIZE + x) + 1] = texels[4 * (y * SIZE + east)];
			texels[4 * (y * SIZE + x) + 2] = texels[4 * (north * SIZE + x)];
			texels[4 * (y * SIZE + x) + 3] = texels[4 * (north * SIZE + east)];
		}
}
