/* Shared by the encoder and the decoder of tiles: the flags of a blob, and the number of posts and blocks of a plane. */
#ifndef FURROW_STORE_CODEC_PARTS_H
#define FURROW_STORE_CODEC_PARTS_H

#include "store/codec.h"
#include "store/codec_kernels.h"

#define CODEC_MASK 1u  /* some posts are nodata */
#define CODEC_WIDE 2u  /* a width takes a byte instead of half a byte */
#define CODEC_SLOPE 4u /* residuals are of the second order along rows */
#define CODEC_SCALED 8u /* residuals are multiples of a power of two, and stored without their lowest bits */
#define CODEC_LENGTH_BYTES 4
#define CODEC_NARROW_MOST 15

/* How a body and a zstd blob begin. */
struct head {
	unsigned flags;
	uint32_t first; /* the first post that is no hole */
	unsigned scale; /* bits that residuals are shifted by, less than 32; 0 without CODEC_SCALED */
};

static inline size_t plane_posts(const struct codec *codec)
{
	return (size_t)codec->side * codec->side;
}

static inline size_t plane_blocks(const struct codec *codec)
{
	return (plane_posts(codec) + CODEC_BLOCK - 1) / CODEC_BLOCK;
}

static inline size_t mask_bytes(const struct codec *codec)
{
	return (plane_posts(codec) + 7) / 8;
}

static inline void put32(uint8_t *to, uint32_t value)
{
	for (int i = 0; i < 4; i++)
		to[i] = (uint8_t)(value >> (8 * i));
}

static inline uint32_t get32(const uint8_t *from)
{
	return (uint32_t)from[0] | (uint32_t)from[1] << 8 | (uint32_t)from[2] << 16 |
	       (uint32_t)from[3] << 24;
}

#endif
