/* Decodes a blob into posts. The blob is untrusted. */
#include <lz4.h>
#include <string.h>
#include <zstd.h>

#include "base/wide.h"
#include "store/codec_levels.h"

bool store_codec_read_head(struct codec *codec, unsigned known, const uint8_t **from, size_t *left, struct head *head)
{
	const uint8_t *at = *from;
	if (*left < 5 || (at[0] & ~known) != 0)
		return false;
	*head = (struct head){.flags = at[0], .first = get32(at + 1)};
	at += 5;
	*left -= 5;
	if (head->flags & CODEC_SCALED) {
		if (*left < 1 || at[0] < 1 || at[0] > 31)
			return false;
		head->scale = *at++;
		--*left;
	}
	if (head->flags & CODEC_MASK) {
		if (*left < CODEC_LENGTH_BYTES)
			return false;
		uint32_t size = get32(at);
		at += CODEC_LENGTH_BYTES;
		*left -= CODEC_LENGTH_BYTES;
		int bytes = (int)mask_bytes(codec);
		if (size > *left || size > (uint32_t)LZ4_compressBound(bytes) ||
		    LZ4_decompress_safe((const char *)at, (char *)codec->mask, (int)size, bytes) != bytes)
			return false;
		at += size;
		*left -= size;
	}
	*from = at;
	return true;
}

/* Makes holes of some of 64 posts. */
FURROW_WIDE static void mask_posts(uint64_t bits, int32_t *posts)
{
	for (int byte = 0; byte < 8; byte++, bits >>= 8, posts += 8)
		for (int i = 0; i < 8; i++)
			posts[i] = (uint32_t)bits & 1u << i ? CODEC_NODATA : posts[i];
}

/* Holes come in runs: 64 posts at once where all of them are some. */
void store_codec_apply_mask(const uint8_t *mask, size_t count, int32_t *posts)
{
	size_t post = 0;
	for (; post + 64 <= count; post += 64) {
		uint64_t bits = load64(mask + post / 8);
		if (bits == UINT64_MAX)
			for (int i = 0; i < 64; i++)
				posts[post + (size_t)i] = CODEC_NODATA;
		else if (bits != 0)
			mask_posts(bits, posts + post);
	}
	for (; post < count; post++)
		if (mask[post / 8] >> post % 8 & 1)
			posts[post] = CODEC_NODATA;
}

/* Reads the widths into `widths`, a byte each. *payload: the number of bytes of their blocks. */
static bool read_widths(const struct codec *codec, bool wide, const uint8_t **from, size_t *left, uint8_t *widths,
			size_t *payload)
{
	size_t blocks = plane_blocks(codec), bytes = wide ? blocks : (blocks + 1) / 2;
	if (*left < bytes)
		return false;
	if (wide) {
		memcpy(widths, *from, blocks);
	} else {
		const uint8_t *pairs = *from;
		for (size_t i = 0; i < blocks / 2; i++) {
			widths[2 * i] = pairs[i] & CODEC_NARROW_MOST;
			widths[2 * i + 1] = pairs[i] >> 4;
		}
		if (blocks % 2 != 0)
			widths[blocks - 1] = pairs[blocks / 2] & CODEC_NARROW_MOST;
	}
	uint32_t sum = 0, beyond = 0;
	for (size_t i = 0; i < blocks; i++) {
		sum += widths[i];
		beyond |= widths[i] > 32;
	}
	*payload = (size_t)2 * sum;
	*from += bytes;
	*left -= bytes;
	return beyond == 0;
}

/* Blocks of a body, read some at a time. The last ones are copied, so that reading beyond them is safe. */
struct blocks {
	const uint8_t *from, *widths;
	size_t direct; /* blocks before the copy's */
	uint8_t copy[CODEC_SLACK + 4 * CODEC_BLOCK + CODEC_SLACK];
};

static void blocks_init(struct blocks *blocks, const uint8_t *from, size_t payload, const uint8_t *widths, size_t count)
{
	size_t tail = 0;
	while (count > 0 && tail < CODEC_SLACK)
		tail += (size_t)2 * widths[--count];
	blocks->from = count > 0 ? from : blocks->copy;
	blocks->widths = widths;
	blocks->direct = count;
	memcpy(blocks->copy, from + (payload - tail), tail);
	memset(blocks->copy + tail, 0, sizeof blocks->copy - tail);
}

static void blocks_next(struct blocks *blocks, const struct codec_kernels *kernels, size_t count, uint32_t *rest)
{
	size_t some = count < blocks->direct ? count : blocks->direct;
	if (some > 0) {
		blocks->from = kernels->unpack(blocks->from, blocks->widths, some, rest);
		blocks->direct -= some;
		if (blocks->direct == 0)
			blocks->from = blocks->copy;
	}
	blocks->from = kernels->unpack(blocks->from, blocks->widths + some, count - some, rest + some * CODEC_BLOCK);
	blocks->widths += count;
}

static void scale_up(uint32_t *rest, size_t count, unsigned scale)
{
	for (size_t i = 0; i < count; i++)
		rest[i] <<= scale;
}

/* Computes the posts of `rows` whole rows from row `y` on. `before`, in: the row before them, or a constant row for row 0; out:
 * the last of these rows. */
static void finish_rows(struct codec *codec, const struct head *head, uint32_t *rest, uint32_t y, uint32_t rows,
			int32_t *before, int32_t *posts)
{
	size_t side = codec->side, at = y * side;
	if (head->scale > 0)
		scale_up(rest, rows * side, head->scale);
	codec->kernels->sum(rest, codec->side, rows, before, (head->flags & CODEC_SLOPE) != 0, posts + at);
	memcpy(before, posts + at + (rows - 1) * side, side * sizeof *before); /* as it was without its holes */
	if (head->flags & CODEC_MASK)
		store_codec_apply_mask(codec->mask + at / 8, rows * side, posts + at);
}

static int32_t *row_of_first(struct codec *codec, uint32_t first)
{
	for (uint32_t x = 0; x < codec->side; x++)
		codec->filled[x] = (int32_t)first;
	return codec->filled;
}

/* As many rows as a block has residuals are whole blocks, and few enough for the nearest cache. */
static bool read_body(struct codec *codec, const uint8_t *from, size_t left, int32_t *posts)
{
	struct head head;
	size_t payload, done = 0, count = plane_blocks(codec);
	uint8_t *widths = codec->widths[0];
	if (!store_codec_read_head(codec, CODEC_MASK | CODEC_WIDE | CODEC_SLOPE | CODEC_SCALED, &from, &left, &head) ||
	    !read_widths(codec, (head.flags & CODEC_WIDE) != 0, &from, &left, widths, &payload) || payload != left)
		return false;
	struct blocks blocks;
	int32_t *before = row_of_first(codec, head.first);
	blocks_init(&blocks, from, payload, widths, count);
	for (uint32_t y = 0; y < codec->side; y += CODEC_BLOCK) {
		uint32_t rows = codec->side - y < CODEC_BLOCK ? codec->side - y : CODEC_BLOCK;
		size_t some = count - done < codec->side ? count - done : codec->side;
		blocks_next(&blocks, codec->kernels, some, codec->orders[0]);
		finish_rows(codec, &head, codec->orders[0], y, rows, before, posts);
		done += some;
	}
	return true;
}

static bool read_lz4(struct codec *codec, const uint8_t *from, size_t size, int32_t *posts)
{
	if (size < CODEC_LENGTH_BYTES || size > codec->squeezed_room)
		return false;
	uint32_t body = get32(from);
	return body <= codec->room &&
	       LZ4_decompress_safe((const char *)from + CODEC_LENGTH_BYTES, (char *)codec->body,
				   (int)(size - CODEC_LENGTH_BYTES), (int)codec->room) == (int)body &&
	       read_body(codec, codec->body, body, posts);
}

static bool read_zstd(struct codec *codec, const uint8_t *from, size_t left, int32_t *posts)
{
	struct head head;
	size_t count = plane_posts(codec);
	if (left > codec->squeezed_room || !store_codec_read_head(codec, CODEC_MASK | CODEC_SLOPE | CODEC_SCALED, &from, &left, &head) || left < 1)
		return false;
	unsigned planes = from[0];
	if (planes < 1 || planes > 4 ||
	    ZSTD_decompressDCtx(codec->zstd_in, codec->body, codec->room, from + 1, left - 1) != planes * count)
		return false;
	const uint8_t *plane = codec->body;
	uint32_t *rest = codec->orders[0];
	for (size_t i = 0; i < count; i++)
		rest[i] = plane[i];
	for (unsigned p = 1; p < planes; p++)
		for (size_t i = 0; i < count; i++)
			rest[i] |= (uint32_t)plane[p * count + i] << (8 * p);
	for (size_t i = 0; i < count; i++)
		rest[i] = codec_unzigzag(rest[i]);
	finish_rows(codec, &head, rest, 0, codec->side, row_of_first(codec, head.first), posts);
	return true;
}

bool store_codec_decode_half(struct codec *codec, int64_t id, const void *bytes, size_t size, int32_t *posts, size_t stride,
			     int32_t *whole)
{
	const size_t side = codec->side, half = (side - 1) / 2;
	if (id == CODEC_LEVELS && side - 1 > LEVELS_TOP)
		return store_levels_decode_half(codec, bytes, size, posts, stride);
	if (!store_codec_decode(codec, id, bytes, size, whole))
		return false;
	for (size_t y = 0; y <= half; y++)
		for (size_t x = 0; x <= half; x++)
			posts[y * stride + x] = whole[2 * y * side + 2 * x];
	return true;
}

bool store_codec_decode(struct codec *codec, int64_t id, const void *bytes, size_t size, int32_t *posts)
{
	const uint8_t *from = bytes;
	switch (id) {
	case CODEC_CONSTANT:
		if (size != 4)
			return false;
		for (size_t i = 0, count = plane_posts(codec); i < count; i++)
			posts[i] = (int32_t)get32(from);
		return true;
	case CODEC_PACKED:
		return size <= codec->room && read_body(codec, from, size, posts);
	case CODEC_LZ4:
		return read_lz4(codec, from, size, posts);
	case CODEC_ZSTD:
		return read_zstd(codec, from, size, posts);
	case CODEC_LEVELS:
		return store_levels_decode(codec, from, size, posts);
	default:
		return false;
	}
}
