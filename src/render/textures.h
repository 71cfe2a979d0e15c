/*
 * The ground's textures. They are computed at the start; there are no files. Each is a square that repeats, RENDER_GROUND_SIZE
 * texels a side. Five show grass, soil, rock, sand and snow from near by, with blades, clods, cracks, ripples and drifts. One is for
 * any ground from afar.
 *
 * The channels of a texel:
 * - red: brightness beside the layer's mean, from 0 to 2 times it; the mean is a half
 * - green: how much of the layer's second colour
 * - blue and alpha: tilt to the east and to the north, from -1 to 1; a half is level, and the mean is level
 *
 * All are linear, so that filtering is right. Colours are not in the texture: they come from the planet and the soil.
 */
#ifndef FURROW_RENDER_TEXTURES_H
#define FURROW_RENDER_TEXTURES_H

#include <stdint.h>

#include "base/base.h"

#define RENDER_GROUND_SIZE 512

enum render_ground { RENDER_GRASS, RENDER_SOIL, RENDER_ROCK, RENDER_SAND, RENDER_SNOW, RENDER_WIDE, RENDER_GROUNDS };

/* Fills level 0, layer after layer, each of its kind: `layers` x RENDER_GROUND_SIZE squared RGBA8 texels. Always the same bits. */
enum status render_textures_fill(const enum render_ground *kinds, uint32_t layers, uint8_t *texels) FURROW_CHECKED;
/* Makes the next level of `squares` squares, `size` texels a side, which is even: means of 2 x 2, in place. */
void render_textures_halve(uint8_t *texels, uint32_t size, uint32_t squares);

#endif
