/*
 * The ground's textures, made at start: no files. Each is a square that repeats, of RENDER_GROUND_SIZE texels a side:
 * what grass, soil, rock, sand and snow look like from where blades, clods, cracks, ripples and drifts can be told, and
 * one of what is seen of any ground from afar.
 *
 * A texel: red, how bright beside the layer's mean (linear, 0 .. 2 of it: the mean is a half); green, how much of the
 * layer's second colour; blue and alpha, how it tilts east and north (-1 .. 1, a half is level, mean level). All of them
 * are linear, so that filtering is right; colours are not in it, they are the body's and the soil's.
 */
#ifndef FURROW_RENDER_TEXTURES_H
#define FURROW_RENDER_TEXTURES_H

#include <stdint.h>

#include "base/base.h"

#define RENDER_GROUND_SIZE 512

enum render_ground { RENDER_GRASS, RENDER_SOIL, RENDER_ROCK, RENDER_SAND, RENDER_SNOW, RENDER_WIDE, RENDER_GROUNDS };

/* Level 0, layer after layer, each of its kind: RGBA8 texels, `layers` x RENDER_GROUND_SIZE squared. Always the same. */
enum status render_textures_fill(const enum render_ground *kinds, uint32_t layers, uint8_t *texels) FURROW_CHECKED;
/* The next level of so many squares of `size` (even) texels a side: means of 2 x 2, in place. */
void render_textures_halve(uint8_t *texels, uint32_t size, uint32_t squares);

#endif
