/* Encodes posts into a blob: takes the residuals that pack better, then the packing that is shorter. */
#include <assert.h>
#include <lz4.h>
#include <string.h>
#include <zstd.h>

#include "base/wide.h"
#include "store/codec_bits.h"
#include "store/codec_parts.h"
#include "store/codec_residuals.h"

#define ZSTD_LEVEL 1 /* more gains 1 to 4 % on heights, and takes 50 times as long */

FURROW_WIDE static bool has_holes(const int32_t *posts, size_t count)
{
	unsigned any = 0;
	for (size_t i = 0; i < count; i++)
		any |= posts[i] == CODEC_NODATA;
	return any != 0;
}

static void take_mask(struct codec *codec, const int32_t *posts)
{
	size_t count = plane_posts(codec);
	memset(codec->mask, 0, mask_bytes(codec));
	for (size_t i = 0; i < count; i++)
		codec->mask[i / 8] |= (uint8_t)((posts[i] == CODEC_NODATA) << i % 8);
}

static uint32_t first_post(const int32_t *posts, size_t count)
{
	for (size_t i = 0; i < count; i++)
		if (posts[i] != CODEC_NODATA)
			return (uint32_t)posts[i];
	return 0;
}

/* Returns how many of the lowest bits are the same in all posts that are no holes, so that residuals have them all zero. */
FURROW_WIDE static unsigned same_bits(const int32_t *posts, size_t count, uint32_t first)
{
	uint32_t differ = 0;
	for (size_t i = 0; i < count; i++)
		differ |= posts[i] == CODEC_NODATA ? 0 : (uint32_t)posts[i] ^ first;
	return differ == 0 ? 0 : (unsigned)__builtin_ctz(differ);
}

/* Shifts zigzagged residuals right, by zero bits only. */
FURROW_WIDE static void scale_down(uint32_t *rest, size_t count, unsigned scale)
{
	for (size_t i = 0; i < count; i++) {
		const int32_t less = (int32_t)codec_unzigzag(rest[i]) >> scale;
		rest[i] = (uint32_t)less << 1 ^ (uint32_t)(less >> 31);
	}
}

/* Widths of the blocks; returns what they sum to. */
FURROW_WIDE static size_t take_widths(const uint32_t *rest, size_t blocks, uint8_t *widths)
{
	size_t sum = 0;
	for (size_t i = 0; i < blocks; i++, rest += CODEC_BLOCK) {
		uint32_t four[4] = {0}; /* one register of most machines */
		for (int j = 0; j < CODEC_BLOCK; j += 4)
			for (int lane = 0; lane < 4; lane++)
				four[lane] |= rest[j + lane];
		uint32_t all = four[0] | four[1] | four[2] | four[3];
		widths[i] = (uint8_t)(all == 0 ? 0 : 32 - __builtin_clz(all));
		sum += widths[i];
	}
	return sum;
}

/* Residuals of both orders and their widths, into the codec. True: those with slopes pack better. */
static bool choose_residuals(struct codec *codec, const int32_t *posts, uint32_t first, bool holes, unsigned scale)
{
	size_t count = plane_posts(codec), blocks = plane_blocks(codec), sum[2];
	for (int slope = 0; slope < 2; slope++) {
		uint32_t *rest = codec->orders[slope];
		store_residuals_take(posts, codec->side, first, slope != 0, holes, codec->filled, rest);
		if (scale > 0)
			scale_down(rest, count, scale);
		memset(rest + count, 0, (blocks * CODEC_BLOCK - count) * sizeof *rest);
		sum[slope] = take_widths(rest, blocks, codec->widths[slope]);
	}
	return sum[1] < sum[0];
}

uint8_t *store_codec_write_head(struct codec *codec, const struct head *head, unsigned more, uint8_t *to)
{
	const unsigned flags = head->flags | more;
	*to++ = (uint8_t)flags;
	put32(to, head->first);
	to += 4;
	if (flags & CODEC_SCALED)
		*to++ = (uint8_t)head->scale;
	if ((flags & CODEC_MASK) == 0)
		return to;
	int bytes = (int)mask_bytes(codec);
	int size = LZ4_compress_default((const char *)codec->mask, (char *)to + CODEC_LENGTH_BYTES, bytes,
					LZ4_compressBound(bytes));
	assert(size > 0);
	put32(to, (uint32_t)size);
	return to + CODEC_LENGTH_BYTES + size;
}

/* Returns the body's bytes; *flat: how many blocks of it are zero. */
static size_t write_body(struct codec *codec, const struct head *head, size_t *flat)
{
	bool slope = (head->flags & CODEC_SLOPE) != 0, wide = false;
	size_t blocks = plane_blocks(codec);
	const uint8_t *widths = codec->widths[slope];
	*flat = 0;
	for (size_t i = 0; i < blocks; i++) {
		wide |= widths[i] > CODEC_NARROW_MOST;
		*flat += widths[i] == 0;
	}
	uint8_t *to = store_codec_write_head(codec, head, wide ? CODEC_WIDE : 0, codec->body);
	if (wide) {
		memcpy(to, widths, blocks);
		to += blocks;
	} else {
		for (size_t i = 0; i < blocks; i += 2)
			*to++ = (uint8_t)(widths[i] | (i + 1 < blocks ? widths[i + 1] << 4 : 0));
	}
	to = store_bits_pack(codec->orders[slope], widths, blocks, to);
	assert((size_t)(to - codec->body) <= codec->room);
	return (size_t)(to - codec->body);
}

/* True if LZ4 made it smaller by a sixteenth at least: less is not worth decoding twice. */
static bool squeeze_lz4(struct codec *codec, size_t body, size_t *size)
{
	int squeezed = LZ4_compress_default((const char *)codec->body, (char *)codec->squeezed + CODEC_LENGTH_BYTES,
					    (int)body, (int)(codec->squeezed_room - CODEC_LENGTH_BYTES));
	if (squeezed <= 0 || (size_t)squeezed + CODEC_LENGTH_BYTES > body - body / 16)
		return false;
	put32(codec->squeezed, (uint32_t)body);
	*size = (size_t)squeezed + CODEC_LENGTH_BYTES;
	return true;
}

/* True if byte planes under zstd are smaller than `most`. */
static bool squeeze_zstd(struct codec *codec, const struct head *head, size_t most, size_t *size)
{
	bool slope = (head->flags & CODEC_SLOPE) != 0;
	size_t count = plane_posts(codec);
	const uint32_t *rest = codec->orders[slope];
	uint32_t all = 1;
	for (size_t i = 0; i < count; i++)
		all |= rest[i];
	unsigned planes = (32 - (unsigned)__builtin_clz(all) + 7) / 8;
	uint8_t *to = store_codec_write_head(codec, head, 0, codec->squeezed);
	*to++ = (uint8_t)planes;
	uint8_t *from = (uint8_t *)codec->orders[!slope]; /* of no use by now, and as large as four planes */
	for (unsigned plane = 0; plane < planes; plane++)
		for (size_t i = 0; i < count; i++)
			from[plane * count + i] = (uint8_t)(rest[i] >> (8 * plane));
	size_t before = (size_t)(to - codec->squeezed);
	size_t squeezed = ZSTD_compressCCtx(codec->zstd_out, to, codec->squeezed_room - before, from,
					    planes * count, ZSTD_LEVEL);
	/* It can fail for want of memory only; the plane is then packed the other way. */
	if (ZSTD_isError(squeezed) || before + squeezed >= most)
		return false;
	*size = before + squeezed;
	return true;
}

static bool is_constant(const int32_t *posts, size_t count)
{
	for (size_t i = 1; i < count; i++)
		if (posts[i] != posts[0])
			return false;
	return true;
}

static enum codec_id take_levels(const struct codec *codec, size_t levels, const void **bytes, size_t *size)
{
	*bytes = codec->squeezed;
	*size = levels;
	return CODEC_LEVELS;
}

enum codec_id store_codec_encode(struct codec *codec, const int32_t *posts, const void **bytes, size_t *size)
{
	*bytes = codec->body;
	if (is_constant(posts, plane_posts(codec))) {
		put32(codec->body, (uint32_t)posts[0]);
		*size = 4;
		return CODEC_CONSTANT;
	}
	bool holes = has_holes(posts, plane_posts(codec));
	if (holes)
		take_mask(codec, posts);
	struct head head = {.flags = holes ? CODEC_MASK : 0, .first = first_post(posts, plane_posts(codec))};
	head.scale = same_bits(posts, plane_posts(codec), head.first);
	if (head.scale > 0)
		head.flags |= CODEC_SCALED;
	size_t levels = SIZE_MAX;
	if (codec->effort == CODEC_GROUND) {
		const bool suit = store_levels_suit(codec, posts);
		store_levels_encode(codec, posts, &head, &levels);
		if (suit)
			return take_levels(codec, levels, bytes, size);
	}
	struct head same = head;
	if (choose_residuals(codec, posts, head.first, holes, head.scale))
		head.flags |= CODEC_SLOPE;
	size_t flat, body = write_body(codec, &head, &flat);
	*size = body;
	enum codec_id id = CODEC_PACKED;
	if (codec->effort == CODEC_SMALL ? squeeze_zstd(codec, &head, body, size)
					 : flat >= plane_blocks(codec) / 16 && squeeze_lz4(codec, body, size)) {
		*bytes = codec->squeezed;
		id = codec->effort == CODEC_SMALL ? CODEC_ZSTD : CODEC_LZ4;
	}
	if (levels > *size || codec->effort != CODEC_GROUND)
		return id;
	store_levels_encode(codec, posts, &same, &levels); /* again: the body is where they were */
	return take_levels(codec, levels, bytes, size);
}
