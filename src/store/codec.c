/*
 * The codec of tiles (FORMAT.md describes the bytes).
 *
 *   posts -> holes filled -> minus (left + up - corner) -> zigzag -> widths by 32 -> bits [-> LZ4]
 *
 * Invariants: (1) all arithmetic on posts is modulo 2^32, so that every int32 comes back; (2) a
 * hole is filled with what is predicted there, so its residual is 0 and decoding needs no mask
 * until the end; (3) nothing read from a blob is used as a length or a width before it was checked
 * against what is left of the blob and against the plane's own size.
 */
#include "store/codec.h"

#include <assert.h>
#include <lz4.h>
#include <lz4hc.h>
#include <string.h>

#define BLOCK 32
#define FLAG_MASK 1u
#define LENGTH_BYTES 4

static size_t plane_posts(const struct codec *codec)
{
	return (size_t)codec->side * codec->side;
}

static size_t plane_blocks(const struct codec *codec)
{
	return (plane_posts(codec) + BLOCK - 1) / BLOCK;
}

static size_t mask_bytes(const struct codec *codec)
{
	return (plane_posts(codec) + 7) / 8;
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

enum status codec_init(struct codec *codec, uint32_t side)
{
	*codec = (struct codec){.side = side};
	size_t mask_room = (size_t)LZ4_compressBound((int)mask_bytes(codec));
	codec->room = 1 + LENGTH_BYTES + mask_room + plane_blocks(codec) * (1 + 4 * BLOCK);
	codec->squeezed_room = LENGTH_BYTES + (size_t)LZ4_compressBound((int)codec->room);
	codec->rest = mem_alloc(plane_blocks(codec) * BLOCK, sizeof *codec->rest);
	codec->filled = mem_alloc(plane_posts(codec), sizeof *codec->filled);
	codec->mask = mem_alloc(mask_bytes(codec), 1);
	codec->body = mem_alloc(codec->room, 1);
	codec->squeezed = mem_alloc(codec->squeezed_room, 1);
	if (codec->rest != NULL && codec->filled != NULL && codec->mask != NULL &&
	    codec->body != NULL && codec->squeezed != NULL)
		return STATUS_OK;
	codec_finish(codec);
	return fail_memory("the tile codec");
}

void codec_finish(struct codec *codec)
{
	mem_free(codec->rest);
	mem_free(codec->filled);
	mem_free(codec->mask);
	mem_free(codec->body);
	mem_free(codec->squeezed);
	*codec = (struct codec){0};
}

size_t codec_bound(const struct codec *codec)
{
	return codec->room;
}

/* --- encoding --- */

static uint32_t predict(const int32_t *posts, uint32_t side, uint32_t x, uint32_t y)
{
	const int32_t *p = posts + (size_t)y * side + x;
	if (y == 0)
		return x == 0 ? 0 : (uint32_t)p[-1];
	uint32_t up = (uint32_t)p[-(ptrdiff_t)side];
	return x == 0 ? up : (uint32_t)p[-1] + up - (uint32_t)p[-(ptrdiff_t)side - 1];
}

static uint32_t zigzag(uint32_t value)
{
	return value << 1 ^ (0u - (value >> 31));
}

static uint32_t unzigzag(uint32_t value)
{
	return value >> 1 ^ (0u - (value & 1));
}

/* Residuals of all posts, holes filled; true if there was a hole, which codec->mask then names. */
static bool take_residuals(struct codec *codec, const int32_t *posts)
{
	uint32_t side = codec->side;
	size_t count = plane_posts(codec);
	bool holes = false;
	memset(codec->mask, 0, mask_bytes(codec));
	for (uint32_t y = 0; y < side; y++)
		for (uint32_t x = 0; x < side; x++) {
			size_t i = (size_t)y * side + x;
			uint32_t guess = predict(codec->filled, side, x, y);
			codec->rest[i] = 0;
			codec->filled[i] = (int32_t)guess;
			if (posts[i] == CODEC_NODATA) {
				codec->mask[i / 8] |= (uint8_t)(1u << i % 8);
				holes = true;
				continue;
			}
			codec->filled[i] = posts[i];
			codec->rest[i] = zigzag((uint32_t)posts[i] - guess);
		}
	memset(codec->rest + count, 0, (plane_blocks(codec) * BLOCK - count) * sizeof *codec->rest);
	return holes;
}

static unsigned width_of(const uint32_t *rest)
{
	uint32_t all = 0;
	for (int i = 0; i < BLOCK; i++)
		all |= rest[i];
	return all == 0 ? 0 : 32 - (unsigned)__builtin_clz(all);
}

/* 4 * width bytes. */
static void pack_block(const uint32_t *rest, unsigned width, uint8_t *to)
{
	uint64_t bits = 0;
	unsigned have = 0;
	for (int i = 0; i < BLOCK; i++) {
		bits |= (uint64_t)rest[i] << have;
		have += width;
		if (have >= 32) {
			put32(to, (uint32_t)bits);
			to += 4;
			bits >>= 32;
			have -= 32;
		}
	}
}

static size_t write_body(struct codec *codec, bool holes)
{
	uint8_t *to = codec->body;
	*to++ = holes ? FLAG_MASK : 0;
	if (holes) {
		int bytes = (int)mask_bytes(codec);
		int size = LZ4_compress_default((const char *)codec->mask, (char *)to + LENGTH_BYTES, bytes,
						LZ4_compressBound(bytes));
		assert(size > 0);
		put32(to, (uint32_t)size);
		to += LENGTH_BYTES + size;
	}
	size_t blocks = plane_blocks(codec);
	uint8_t *widths = to;
	to += blocks;
	for (size_t i = 0; i < blocks; i++) {
		widths[i] = (uint8_t)width_of(codec->rest + i * BLOCK);
		if (widths[i] != 0)
			pack_block(codec->rest + i * BLOCK, widths[i], to);
		to += (size_t)4 * widths[i];
	}
	assert((size_t)(to - codec->body) <= codec->room);
	return (size_t)(to - codec->body);
}

static bool is_constant(const int32_t *posts, size_t count)
{
	for (size_t i = 1; i < count; i++)
		if (posts[i] != posts[0])
			return false;
	return true;
}

enum codec_id codec_encode(struct codec *codec, const int32_t *posts, bool hard,
			   const void **bytes, size_t *size)
{
	*bytes = codec->body;
	if (is_constant(posts, plane_posts(codec))) {
		put32(codec->body, (uint32_t)posts[0]);
		*size = 4;
		return CODEC_CONSTANT;
	}
	*size = write_body(codec, take_residuals(codec, posts));
	const char *body = (const char *)codec->body;
	char *to = (char *)codec->squeezed + LENGTH_BYTES;
	int room = (int)(codec->squeezed_room - LENGTH_BYTES);
	int squeezed = hard ? LZ4_compress_HC(body, to, (int)*size, room, LZ4HC_CLEVEL_DEFAULT)
			    : LZ4_compress_default(body, to, (int)*size, room);
	/* A sixteenth less, or decoding it twice is not worth it. */
	if (squeezed <= 0 || (size_t)squeezed + LENGTH_BYTES > *size - *size / 16)
		return CODEC_PACKED;
	put32(codec->squeezed, (uint32_t)*size);
	*bytes = codec->squeezed;
	*size = (size_t)squeezed + LENGTH_BYTES;
	return CODEC_LZ4;
}

/* --- decoding --- */

static bool little_endian(void)
{
	const uint16_t one = 1;
	return *(const uint8_t *)&one == 1;
}

static uint64_t load64(const uint8_t *from)
{
	uint64_t value;
	memcpy(&value, from, sizeof value);
	return little_endian() ? value : __builtin_bswap64(value);
}

/* 4 * width bytes are the block's; `left` of the blob follow `from` in all. */
static void unpack_block(const uint8_t *from, size_t left, unsigned width, uint32_t *rest)
{
	uint8_t tail[4 * BLOCK + 8];
	if (width == 0) {
		memset(rest, 0, BLOCK * sizeof *rest);
		return;
	}
	if (left < (size_t)4 * width + 8) { /* loads are 8 bytes wide */
		memcpy(tail, from, (size_t)4 * width);
		memset(tail + (size_t)4 * width, 0, 8);
		from = tail;
	}
	uint64_t mask = ((uint64_t)1 << width) - 1;
	for (unsigned i = 0; i < BLOCK; i++)
		rest[i] = unzigzag((uint32_t)(load64(from + i * width / 8) >> i * width % 8 & mask));
}

/* left + up - corner undone: a row is the one before it plus the running sum of its residuals. */
static void undo_prediction(const uint32_t *rest, uint32_t side, int32_t *posts)
{
	for (uint32_t y = 0; y < side; y++) {
		const uint32_t *r = rest + (size_t)y * side;
		int32_t *row = posts + (size_t)y * side;
		uint32_t sum = 0;
		if (y == 0)
			for (uint32_t x = 0; x < side; x++)
				row[x] = (int32_t)(sum += r[x]);
		else
			for (uint32_t x = 0; x < side; x++)
				row[x] = (int32_t)((uint32_t)row[(ptrdiff_t)x - side] + (sum += r[x]));
	}
}

static void apply_mask(const struct codec *codec, int32_t *posts)
{
	size_t count = plane_posts(codec);
	for (size_t i = 0; i < count; i++)
		if (codec->mask[i / 8] >> i % 8 & 1)
			posts[i] = CODEC_NODATA;
}

static bool read_body(struct codec *codec, const uint8_t *from, size_t left, int32_t *posts)
{
	if (left < 1 || (from[0] & ~FLAG_MASK) != 0)
		return false;
	bool holes = from[0] & FLAG_MASK;
	from++;
	left--;
	if (holes) {
		if (left < LENGTH_BYTES)
			return false;
		uint32_t size = get32(from);
		from += LENGTH_BYTES;
		left -= LENGTH_BYTES;
		int bytes = (int)mask_bytes(codec);
		if (size > left || size > (uint32_t)LZ4_compressBound(bytes) ||
		    LZ4_decompress_safe((const char *)from, (char *)codec->mask, (int)size, bytes) != bytes)
			return false;
		from += size;
		left -= size;
	}
	size_t blocks = plane_blocks(codec);
	if (left < blocks)
		return false;
	const uint8_t *widths = from;
	from += blocks;
	left -= blocks;
	for (size_t i = 0; i < blocks; i++) {
		if (widths[i] > 32 || (size_t)4 * widths[i] > left)
			return false;
		unpack_block(from, left, widths[i], codec->rest + i * BLOCK);
		from += (size_t)4 * widths[i];
		left -= (size_t)4 * widths[i];
	}
	if (left != 0)
		return false;
	undo_prediction(codec->rest, codec->side, posts);
	if (holes)
		apply_mask(codec, posts);
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
		if (size < LENGTH_BYTES || size > codec->squeezed_room)
			return false;
		uint32_t body = get32(from);
		if (body > codec->room ||
		    LZ4_decompress_safe((const char *)from + LENGTH_BYTES, (char *)codec->body,
					(int)(size - LENGTH_BYTES), (int)codec->room) != (int)body)
			return false;
		return read_body(codec, codec->body, body, posts);
	default:
		return false;
	}
}
