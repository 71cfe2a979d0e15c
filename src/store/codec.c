/*
 * The codec of tiles (FORMAT.md describes the bytes).
 *
 *   posts -> holes foretold -> minus what is foretold -> zigzag -> widths by 16 -> bits [-> LZ4]
 *                                                               -> byte planes -> zstd
 *
 * Invariants: (1) all arithmetic on posts is modulo 2^32, so that every int32 comes back; (2) a
 * hole's residual is 0, so decoding needs no mask until the end; (3) nothing read from a blob is
 * used as a length or a width before it was checked against what is left of the blob and against
 * the plane's own size.
 */
#include "store/codec.h"

#include <assert.h>
#include <lz4.h>
#include <string.h>
#include <zstd.h>

#include "base/wide.h"
#include "store/codec_bits.h"
#include "store/codec_kernels.h"
#include "store/codec_residuals.h"

#define FLAG_MASK 1u  /* there are holes */
#define FLAG_WIDE 2u  /* a width is a byte, not half of one */
#define FLAG_SLOPE 4u /* residuals are of the second order along rows */
#define LENGTH_BYTES 4
#define NARROW_MOST 15
#define ZSTD_LEVEL 1 /* more gains 1 to 4 % on heights, and takes 50 times as long */

static size_t plane_posts(const struct codec *codec)
{
	return (size_t)codec->side * codec->side;
}

static size_t plane_blocks(const struct codec *codec)
{
	return (plane_posts(codec) + CODEC_BLOCK - 1) / CODEC_BLOCK;
}

static size_t mask_bytes(const struct codec *codec)
{
	return (plane_posts(codec) + 7) / 8;
}

static size_t larger(size_t a, size_t b)
{
	return a > b ? a : b;
}

static void put32(uint8_t *to, uint32_t value)
{
	for (int i = 0; i < 4; i++)
		to[i] = (uint8_t)(value >> (8 * i));
}

static uint32_t get32(const uint8_t *from)
{
	return (uint32_t)from[0] | (uint32_t)from[1] << 8 | (uint32_t)from[2] << 16 |
	       (uint32_t)from[3] << 24;
}

enum status codec_init(struct codec *codec, uint32_t side, enum codec_effort effort)
{
	assert(side > 8 && side % 8 == 1); /* the kernels take eight posts at once */
	*codec = (struct codec){.side = side, .effort = effort, .kernels = codec_kernels_best()};
	size_t posts = plane_posts(codec), blocks = plane_blocks(codec);
	size_t head = 1 + 4 + LENGTH_BYTES + (size_t)LZ4_compressBound((int)mask_bytes(codec));
	codec->room = head + blocks * (1 + 4 * CODEC_BLOCK);
	codec->squeezed_room = larger(LENGTH_BYTES + (size_t)LZ4_compressBound((int)codec->room),
				      head + 1 + ZSTD_compressBound(4 * posts));
	for (int slope = 0; slope < 2; slope++) {
		codec->orders[slope] = mem_alloc(blocks * CODEC_BLOCK, sizeof *codec->orders[slope]);
		codec->widths[slope] = mem_alloc(blocks, 1);
	}
	codec->filled = mem_alloc(posts, sizeof *codec->filled);
	codec->mask = mem_alloc(mask_bytes(codec), 1);
	codec->body = mem_alloc(codec->room, 1);
	codec->squeezed = mem_alloc(codec->squeezed_room, 1);
	codec->zstd_in = ZSTD_createDCtx();
	if (effort == CODEC_SMALL)
		codec->zstd_out = ZSTD_createCCtx();
	if (codec->orders[0] != NULL && codec->orders[1] != NULL && codec->widths[0] != NULL &&
	    codec->widths[1] != NULL && codec->filled != NULL && codec->mask != NULL &&
	    codec->body != NULL && codec->squeezed != NULL && codec->zstd_in != NULL &&
	    (effort == CODEC_FAST || codec->zstd_out != NULL))
		return STATUS_OK;
	codec_finish(codec);
	return fail_memory("the tile codec");
}

void codec_finish(struct codec *codec)
{
	for (int slope = 0; slope < 2; slope++) {
		mem_free(codec->orders[slope]);
		mem_free(codec->widths[slope]);
	}
	mem_free(codec->filled);
	mem_free(codec->mask);
	mem_free(codec->body);
	mem_free(codec->squeezed);
	ZSTD_freeDCtx(codec->zstd_in);
	ZSTD_freeCCtx(codec->zstd_out);
	*codec = (struct codec){0};
}

size_t codec_bound(const struct codec *codec)
{
	return codec->squeezed_room;
}

/* --- encoding --- */

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
static bool choose_residuals(struct codec *codec, const int32_t *posts, uint32_t first, bool holes)
{
	size_t count = plane_posts(codec), blocks = plane_blocks(codec), sum[2];
	for (int slope = 0; slope < 2; slope++) {
		uint32_t *rest = codec->orders[slope];
		residuals_take(posts, codec->side, first, slope != 0, holes, codec->filled, rest);
		memset(rest + count, 0, (blocks * CODEC_BLOCK - count) * sizeof *rest);
		sum[slope] = take_widths(rest, blocks, codec->widths[slope]);
	}
	return sum[1] < sum[0];
}

/* Flags, first post and mask: how a body and a zstd blob begin. */
static uint8_t *write_head(struct codec *codec, uint8_t flags, uint32_t first, uint8_t *to)
{
	*to++ = flags;
	put32(to, first);
	to += 4;
	if ((flags & FLAG_MASK) == 0)
		return to;
	int bytes = (int)mask_bytes(codec);
	int size = LZ4_compress_default((const char *)codec->mask, (char *)to + LENGTH_BYTES, bytes,
					LZ4_compressBound(bytes));
	assert(size > 0);
	put32(to, (uint32_t)size);
	return to + LENGTH_BYTES + size;
}

/* Returns the body's bytes; *flat: how many blocks of it are zero. */
static size_t write_body(struct codec *codec, uint8_t flags, uint32_t first, size_t *flat)
{
	bool slope = (flags & FLAG_SLOPE) != 0, wide = false;
	size_t blocks = plane_blocks(codec);
	const uint8_t *widths = codec->widths[slope];
	*flat = 0;
	for (size_t i = 0; i < blocks; i++) {
		wide |= widths[i] > NARROW_MOST;
		*flat += widths[i] == 0;
	}
	uint8_t *to = write_head(codec, (uint8_t)(flags | (wide ? FLAG_WIDE : 0)), first, codec->body);
	if (wide) {
		memcpy(to, widths, blocks);
		to += blocks;
	} else {
		for (size_t i = 0; i < blocks; i += 2)
			*to++ = (uint8_t)(widths[i] | (i + 1 < blocks ? widths[i + 1] << 4 : 0));
	}
	to = bits_pack(codec->orders[slope], widths, blocks, to);
	assert((size_t)(to - codec->body) <= codec->room);
	return (size_t)(to - codec->body);
}

/* True if LZ4 made it smaller by a sixteenth at least: less is not worth decoding twice. */
static bool squeeze_lz4(struct codec *codec, size_t body, size_t *size)
{
	int squeezed = LZ4_compress_default((const char *)codec->body, (char *)codec->squeezed + LENGTH_BYTES,
					    (int)body, (int)(codec->squeezed_room - LENGTH_BYTES));
	if (squeezed <= 0 || (size_t)squeezed + LENGTH_BYTES > body - body / 16)
		return false;
	put32(codec->squeezed, (uint32_t)body);
	*size = (size_t)squeezed + LENGTH_BYTES;
	return true;
}

/* True if byte planes under zstd are smaller than `most`. */
static bool squeeze_zstd(struct codec *codec, uint8_t flags, uint32_t first, size_t most, size_t *size)
{
	bool slope = (flags & FLAG_SLOPE) != 0;
	size_t count = plane_posts(codec);
	const uint32_t *rest = codec->orders[slope];
	uint32_t all = 1;
	for (size_t i = 0; i < count; i++)
		all |= rest[i];
	unsigned planes = (32 - (unsigned)__builtin_clz(all) + 7) / 8;
	uint8_t *to = write_head(codec, flags, first, codec->squeezed);
	*to++ = (uint8_t)planes;
	uint8_t *from = (uint8_t *)codec->orders[!slope]; /* of no use by now, and as large as four planes */
	for (unsigned plane = 0; plane < planes; plane++)
		for (size_t i = 0; i < count; i++)
			from[plane * count + i] = (uint8_t)(rest[i] >> (8 * plane));
	size_t head = (size_t)(to - codec->squeezed);
	size_t squeezed = ZSTD_compressCCtx(codec->zstd_out, to, codec->squeezed_room - head, from,
					    planes * count, ZSTD_LEVEL);
	/* It can fail for want of memory only; the plane is then packed the other way. */
	if (ZSTD_isError(squeezed) || head + squeezed >= most)
		return false;
	*size = head + squeezed;
	return true;
}

static bool is_constant(const int32_t *posts, size_t count)
{
	for (size_t i = 1; i < count; i++)
		if (posts[i] != posts[0])
			return false;
	return true;
}

enum codec_id codec_encode(struct codec *codec, const int32_t *posts, const void **bytes, size_t *size)
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
	uint32_t first = first_post(posts, plane_posts(codec));
	uint8_t flags = holes ? FLAG_MASK : 0;
	if (choose_residuals(codec, posts, first, holes))
		flags |= FLAG_SLOPE;
	size_t flat, body = write_body(codec, flags, first, &flat);
	*size = body;
	if (codec->effort == CODEC_SMALL ? squeeze_zstd(codec, flags, first, body, size)
					 : flat >= plane_blocks(codec) / 16 && squeeze_lz4(codec, body, size)) {
		*bytes = codec->squeezed;
		return codec->effort == CODEC_SMALL ? CODEC_ZSTD : CODEC_LZ4;
	}
	return CODEC_PACKED;
}

/* --- decoding --- */

struct head {
	uint8_t flags;
	uint32_t first;
};

/* What write_head() wrote, the mask into codec->mask; moves `from` on. */
static bool read_head(struct codec *codec, unsigned known, const uint8_t **from, size_t *left, struct head *head)
{
	const uint8_t *at = *from;
	if (*left < 5 || (at[0] & ~known) != 0)
		return false;
	*head = (struct head){at[0], get32(at + 1)};
	at += 5;
	*left -= 5;
	if (head->flags & FLAG_MASK) {
		if (*left < LENGTH_BYTES)
			return false;
		uint32_t size = get32(at);
		at += LENGTH_BYTES;
		*left -= LENGTH_BYTES;
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

static uint64_t mask_word(const uint8_t *mask, size_t bytes)
{
	uint64_t word = 0;
	memcpy(&word, mask, bytes);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
	word = __builtin_bswap64(word);
#endif
	return word;
}

/* Holes come in runs: 64 posts at once where all of them are some. */
static void apply_mask(const uint8_t *mask, size_t count, int32_t *posts)
{
	for (size_t post = 0; post < count; post += 64) {
		size_t room = count - post < 64 ? count - post : 64;
		uint64_t bits = mask_word(mask + post / 8, (room + 7) / 8);
		bits &= room < 64 ? ((uint64_t)1 << room) - 1 : UINT64_MAX;
		if (bits == UINT64_MAX)
			for (int i = 0; i < 64; i++)
				posts[post + (size_t)i] = CODEC_NODATA;
		else
			for (; bits != 0; bits &= bits - 1)
				posts[post + (size_t)__builtin_ctzll(bits)] = CODEC_NODATA;
	}
}

/* The widths, a byte each, into `widths`; *payload: what their blocks take. */
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
			widths[2 * i] = pairs[i] & NARROW_MOST;
			widths[2 * i + 1] = pairs[i] >> 4;
		}
		if (blocks % 2 != 0)
			widths[blocks - 1] = pairs[blocks / 2] & NARROW_MOST;
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

/* The blocks of a body, some at a time. The last ones are a copy, with room to read beyond them. */
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

/* Posts of whole rows from `y` on; `before` is the row before them, or stands for it, and then is the last
 * of these. */
static void finish_rows(struct codec *codec, const struct head *head, const uint32_t *rest, uint32_t y, uint32_t rows,
			int32_t *before, int32_t *posts)
{
	size_t side = codec->side, at = y * side;
	codec->kernels->sum(rest, codec->side, rows, before, (head->flags & FLAG_SLOPE) != 0, posts + at);
	memcpy(before, posts + at + (rows - 1) * side, side * sizeof *before); /* as it was without its holes */
	if (head->flags & FLAG_MASK)
		apply_mask(codec->mask + at / 8, rows * side, posts + at);
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
	if (!read_head(codec, FLAG_MASK | FLAG_WIDE | FLAG_SLOPE, &from, &left, &head) ||
	    !read_widths(codec, (head.flags & FLAG_WIDE) != 0, &from, &left, widths, &payload) || payload != left)
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
	if (size < LENGTH_BYTES || size > codec->squeezed_room)
		return false;
	uint32_t body = get32(from);
	return body <= codec->room &&
	       LZ4_decompress_safe((const char *)from + LENGTH_BYTES, (char *)codec->body,
				   (int)(size - LENGTH_BYTES), (int)codec->room) == (int)body &&
	       read_body(codec, codec->body, body, posts);
}

static uint32_t unzigzag(uint32_t value)
{
	return value >> 1 ^ (0u - (value & 1));
}

static bool read_zstd(struct codec *codec, const uint8_t *from, size_t left, int32_t *posts)
{
	struct head head;
	size_t count = plane_posts(codec);
	if (left > codec->squeezed_room || !read_head(codec, FLAG_MASK | FLAG_SLOPE, &from, &left, &head) || left < 1)
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
		rest[i] = unzigzag(rest[i]);
	finish_rows(codec, &head, rest, 0, codec->side, row_of_first(codec, head.first), posts);
	return true;
}

bool codec_decode(struct codec *codec, int64_t id, const void *bytes, size_t size, int32_t *posts)
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
	default:
		return false;
	}
}
