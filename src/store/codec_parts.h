/* Shared by the encoder and the decoder of tiles: the flags of a blob, and the number of posts and blocks of a plane. */
#ifndef FURROW_STORE_CODEC_PARTS_H
#define FURROW_STORE_CODEC_PARTS_H

#include <string.h>

#include "store/codec.h"
#include "store/codec_kernels.h"

#define CODEC_MASK 1u  /* some posts are nodata */
#define CODEC_WIDE 2u  /* a width takes a byte instead of half a byte */
#define CODEC_SLOPE 4u /* residuals are of the second order along rows */
#define CODEC_SCALED 8u /* residuals are multiples of a power of two, and stored without their lowest bits */
#define CODEC_CUBIC 16u /* levels: posts are predicted from four others, not from two */
#define CODEC_RELATIVE 32u /* levels: what is coded are posts minus `first` */
#define CODEC_SHORT 64u /* levels: widths are compressed with LZ4 */
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

static inline uint64_t load64(const uint8_t *from)
{
	uint64_t value;
	memcpy(&value, from, sizeof value);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
	value = __builtin_bswap64(value);
#endif
	return value;
}

/* The head of a body, a zstd blob and a blob in levels: flags, first post, scale, and the mask in codec->mask. The first returns
 * the end of the written bytes. The second moves *from behind the head, and returns false if it is none or has flags that are not
 * in `known`. */
uint8_t *store_codec_write_head(struct codec *codec, const struct head *head, unsigned more, uint8_t *to);
bool store_codec_read_head(struct codec *codec, unsigned known, const uint8_t **from, size_t *left, struct head *head);
/* Makes holes of the posts that `mask` has. */
void store_codec_apply_mask(const uint8_t *mask, size_t count, int32_t *posts);

/* Planes in levels (codec_levels.h). store_levels_suit() looks at some rows. It returns false if many blocks
 * are flat, as between the edges of buildings. Then levels may take more bytes than a body. store_levels_encode() writes into codec->squeezed. The decoders return false if the bytes are
 * none. store_levels_decode_half() makes every second post only, in rows of `stride`. */
bool store_levels_suit(struct codec *codec, const int32_t *posts);
void store_levels_encode(struct codec *codec, const int32_t *posts, const struct head *head, size_t *size);
bool store_levels_decode(struct codec *codec, const uint8_t *from, size_t size, int32_t *posts);
bool store_levels_decode_half(struct codec *codec, const uint8_t *from, size_t size, int32_t *posts, size_t stride);

#endif
