/*
 * The ground's textures. They are computed at the start; there are no files. Each is a square of RENDER_GROUND_SIZE texels a
 * side that repeats. Five show nearby grass, soil, rock, sand and snow, with blades, clods, cracks, ripples and drifts. One is
 * used for any ground seen from afar.
 *
 * The channels of a texel:
 * - red: brightness relative to the layer's mean, 0 to 2; stored as half of it, so the mean is 0.5
 * - green: share of the layer's second colour
 * - blue and alpha: tilt to the east and to the north, -1 to 1; 0.5 means level, and the mean is level
 *
 * All channels are linear, so filtering is correct. Colours are not stored here: they depend on the planet and the soil.
 */
#ifndef FURROW_RENDER_TEXTURES_H
#define FURROW_RENDER_TEXTURES_H

#include <stdint.h>

#include "base/base.h"

#define RENDER_GROUND_SIZE 512

enum render_ground { RENDER_GRASS, RENDER_SOIL, RENDER_ROCK, RENDER_SAND, RENDER_SNOW, RENDER_WIDE, RENDER_GROUNDS };

/* Fills level 0 of the textures, layer after layer: `layers` x RENDER_GROUND_SIZE^2 RGBA8 texels. kinds[i]: the kind of layer
 * i. The bits are always the same. */
enum status render_textures_fill(const enum render_ground *kinds, uint32_t layers, uint8_t *texels) FURROW_CHECKED;
/* Computes the next mip level in place: the mean of each 2 x 2 texels. There are `squares` squares of `size` texels a side;
 * `size` is even. */
void render_textures_halve(uint8_t *texels, uint32_t size, uint32_t squares);

#endif
