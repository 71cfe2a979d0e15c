/*
 * Decodes a plane in levels. The bytes are untrusted.
 *
 * All widths of a part are decoded and checked before its residuals are read. So the sum of the
 * widths is known to be the bytes that there are.
 */
#include <lz4.h>
#include <string.h>

#include "base/wide.h"
#include "store/codec_levels.h"
#include "store/codec_widths.h"

#define KNOWN_FLAGS (CODEC_MASK | CODEC_SCALED | CODEC_CUBIC | CODEC_RELATIVE | CODEC_SHORT)

typedef uint8_t bytes16 __attribute__((vector_size(16), aligned(1)));
typedef uint8_t bytes8 __attribute__((vector_size(8), aligned(1)));

/* Adds the symbols of a band, as differences, to the widths of the row before. */
static void finish_band(uint8_t *widths, uint32_t rows, size_t count)
{
	for (size_t i = 0; i < rows * count; i++)
		widths[i] = (uint8_t)(widths[i] >> 1 ^ (0u - (widths[i] & 1u)));
	if (count % sizeof(bytes16) == 0)
		for (size_t i = count; i < rows * count; i += sizeof(bytes16))
			*(bytes16 *)(widths + i) += *(const bytes16 *)(widths + i - count);
	else if (count == sizeof(bytes8))
		for (size_t i = count; i < rows * count; i += sizeof(bytes8))
			*(bytes8 *)(widths + i) += *(const bytes8 *)(widths + i - count);
	else
		for (size_t i = count; i < rows * count; i++)
			widths[i] = (uint8_t)(widths[i] + widths[i - count]);
}

/* Turns the symbols of the grids of `first` to `last` cells into widths. *payload: the bytes of
 * their blocks. */
static bool finish_widths(const struct codec_kernels *kernels, uint8_t *widths, uint32_t first,
                          uint32_t last, size_t *payload)
{
	uint8_t *at = widths;
	for (uint32_t n = first; n <= last; n *= 2) {
		struct level_band bands[3];
		for (int i = 0, count = level_bands(n, bands); i < count; i++) {
			finish_band(at, bands[i].rows, bands[i].blocks);
			at += (size_t)bands[i].rows * bands[i].blocks;
		}
	}
	uint8_t most;
	*payload = kernels->total(widths, (size_t)(at - widths), &most);
	return most <= 32;
}

/* Reads the widths of a part: their length in bytes, then they themselves. */
static bool read_widths(struct codec *codec, unsigned flags, const struct widths_table *table,
                        uint32_t first, uint32_t last, const uint8_t **from, size_t *left,
                        uint8_t *widths, size_t *payload)
{
	if (*left < CODEC_LENGTH_BYTES)
		return false;
	const uint8_t *bytes = *from + CODEC_LENGTH_BYTES;
	size_t size = get32(*from), count = level_blocks(first, last);
	*left -= CODEC_LENGTH_BYTES;
	if (size > *left)
		return false;
	*from = bytes + size;
	*left -= size;
	if (flags & CODEC_SHORT) {
		int some = LZ4_decompress_safe((const char *)bytes, (char *)codec->squeezed,
		                               (int)size, (int)codec->squeezed_room);
		if (some < 0)
			return false;
		bytes = codec->squeezed;
		size = (size_t)some;
	}
	return store_widths_get(table, bytes, size, widths, count) &&
	       finish_widths(codec->kernels, widths, first, last, payload) && *payload <= *left;
}

/* --- grids --- */

/* Blocks that are read one row after another. */
struct blocks {
	const uint8_t *from, *end, *widths; /* `end`: of all bytes of the blob */
	uint8_t *copy;                      /* room for those that a kernel reads at once */
};

/* Returns where the next `count` blocks lie with CODEC_SLACK readable bytes after them. The last
 * ones of a blob are copied. */
static const uint8_t *blocks_here(const struct codec *codec, const struct blocks *blocks,
                                  size_t count)
{
	size_t left = (size_t)(blocks->end - blocks->from);
	if (left >= count * LEVELS_BLOCK * sizeof(int32_t) + CODEC_SLACK)
		return blocks->from;
	uint8_t most;
	size_t size = codec->kernels->total(blocks->widths, count, &most);
	if (left >= size + CODEC_SLACK)
		return blocks->from;
	memcpy(blocks->copy, blocks->from, size);
	memset(blocks->copy + size, 0, CODEC_SLACK);
	return blocks->copy;
}

static void blocks_step(struct blocks *blocks, const uint8_t *from, const uint8_t *end,
                        size_t count)
{
	blocks->from += end - from;
	blocks->widths += count;
}

static void read_residuals(const struct codec *codec, struct blocks *blocks, size_t count,
                           int32_t *rest)
{
	const uint8_t *from = blocks_here(codec, blocks, count);
	blocks_step(blocks, from, codec->kernels->level(from, blocks->widths, count, rest), count);
}

/* The coarsest grid: a post is left + up - corner + residual, and `first` is around. */
static void make_top(const struct codec *codec, struct level_grid grid, struct blocks *blocks,
                     uint32_t first)
{
	int32_t rest[LEVELS_TOP_POSTS + LEVELS_BLOCK];
	read_residuals(codec, blocks, level_blocks(LEVELS_TOP, LEVELS_TOP), rest);
	for (uint32_t y = 0; y <= LEVELS_TOP; y++) {
		const int32_t *before = grid.posts + (y > 0 ? y - 1 : 0) * grid.stride;
		int32_t *row = grid.posts + y * grid.stride;
		uint32_t rise = 0;
		for (uint32_t x = 0; x <= LEVELS_TOP; x++) {
			rise += (uint32_t)rest[y * (LEVELS_TOP + 1) + x];
			row[x] = (int32_t)(rise + (y > 0 ? (uint32_t)before[x] : first));
		}
	}
}

static void make_even(const struct codec *codec, const int32_t *coarse, uint32_t n, bool cubic,
                      struct blocks *blocks, int32_t *row)
{
	const size_t count = n / 2 / LEVELS_BLOCK;
	const uint8_t *from = blocks_here(codec, blocks, count);
	blocks_step(blocks, from,
	            codec->kernels->spread(coarse, from, blocks->widths, count, cubic, row), count);
}

/* Two odd rows, of the n / 2, from the even rows around them. `lasts`: the residuals of their last
 * posts. */
static void make_odd(const struct codec *codec, struct level_grid grid, uint32_t n, uint32_t y,
                     bool cubic, struct blocks *blocks, const int32_t *lasts)
{
	const size_t stride = grid.stride, count = n / LEVELS_BLOCK;
	int32_t *first = grid.posts + 2 * y * stride;
	const int32_t *before = y > 0 ? first - 2 * stride : codec->edges;
	const int32_t *after = y + 2 < n / 2 ? first + 6 * stride : codec->edges + n + 1;
	const int32_t last[5] = {before[n], first[n], first[2 * stride + n], first[4 * stride + n],
	                         after[n]};
	const uint8_t *from = blocks_here(codec, blocks, 2 * count);
	blocks_step(blocks, from,
	            codec->kernels->between(first, stride, before, after, from, blocks->widths,
	                                    count, cubic),
	            2 * count);
	for (size_t i = 0; i < 2; i++) {
		int32_t guess =
		        level_between(last[i], last[i + 1], last[i + 2], last[i + 3], cubic);
		first[(2 * i + 1) * stride + n] = (int32_t)((uint32_t)guess + (uint32_t)lasts[i]);
	}
}

/* The grid of n cells from that of n / 2. Odd rows follow the even ones that they need, while these
 * are near. */
static void make_grid(const struct codec *codec, struct level_grid coarse, struct level_grid grid,
                      uint32_t n, bool cubic, struct blocks *blocks)
{
	const uint32_t half = n / 2;
	struct level_band bands[3];
	struct blocks evens = *blocks, odds = *blocks;
	int32_t *lasts = codec->edges + 2 * (n + 1);
	uint8_t most;
	level_bands(n, bands);
	const size_t even_count = (size_t)bands[0].rows * bands[0].blocks,
	             odd_count = (size_t)bands[1].rows * bands[1].blocks;
	odds.from += codec->kernels->total(blocks->widths, even_count, &most);
	odds.widths += even_count;
	blocks->from = odds.from + codec->kernels->total(odds.widths, odd_count, &most);
	blocks->widths = odds.widths + odd_count;
	read_residuals(codec, blocks, bands[2].blocks, lasts);
	for (uint32_t y = 0, done = 0; y < half; y += 2) {
		for (; done <= half && done <= y + 3; done++) {
			int32_t *row = grid.posts + 2 * done * grid.stride;
			make_even(codec, coarse.posts + done * coarse.stride, n, cubic, &evens,
			          row);
			row[n] = coarse.posts[done * coarse.stride + half];
		}
		if (y == 0)
			store_level_edge(grid.posts, 2 * (ptrdiff_t)grid.stride, n, codec->edges);
		if (y + 2 == half)
			store_level_edge(grid.posts + n * grid.stride, -2 * (ptrdiff_t)grid.stride,
			                 n, codec->edges + n + 1);
		make_odd(codec, grid, n, y, cubic, &odds, lasts + y);
	}
}

FURROW_WIDE static void add_first(int32_t *row, size_t count, uint32_t first, unsigned scale)
{
	for (size_t i = 0; i < count; i++)
		row[i] = (int32_t)(((uint32_t)row[i] << scale) + first);
}

/* --- the whole --- */

/* What is known before residuals are unpacked: of the two parts of a blob. */
struct levels {
	struct head head;
	struct blocks parts[2];
};

/* Reads all but the residuals themselves. `count`: 1 for all grids but the finest. */
static bool read_parts(struct codec *codec, const uint8_t *from, size_t left, int count,
                       struct levels *levels)
{
	struct widths_table table;
	const uint8_t *end = from + left;
	const uint32_t cells = codec->side - 1, first[2] = {LEVELS_TOP, cells},
	               last[2] = {level_half(cells), cells};
	const int all = cells > LEVELS_TOP ? 2 : 1;
	uint8_t *widths = codec->widths[0];
	if (left > codec->squeezed_room ||
	    !store_codec_read_head(codec, KNOWN_FLAGS, &from, &left, &levels->head) ||
	    !store_widths_get_table(&from, &left, &table))
		return false;
	for (int part = 0; part < count && part < all; part++) {
		size_t payload;
		if (!read_widths(codec, levels->head.flags, &table, first[part], last[part], &from,
		                 &left, widths, &payload))
			return false;
		levels->parts[part] = (struct blocks){from, end, widths, codec->body};
		widths += level_blocks(first[part], last[part]);
		from += payload;
		left -= payload;
	}
	return left == 0 || count < all;
}

/* Makes the grids up to `n` cells; the last one into `into`. */
static void make_grids(const struct codec *codec, struct levels *levels, uint32_t n,
                       struct level_grid into)
{
	const struct head *head = &levels->head;
	const bool relative = (head->flags & (CODEC_RELATIVE | CODEC_SCALED)) != 0,
	           cubic = (head->flags & CODEC_CUBIC) != 0;
	struct blocks *blocks = &levels->parts[0];
	struct level_grid coarse = n > LEVELS_TOP ? level_scratch(codec, LEVELS_TOP) : into;
	make_top(codec, coarse, blocks, relative ? 0 : head->first);
	for (uint32_t m = 2 * LEVELS_TOP; m <= n; m *= 2) {
		struct level_grid grid = m < n ? level_scratch(codec, m) : into;
		store_level_pad(coarse, m / 2);
		make_grid(codec, coarse, grid, m, cubic,
		          m == codec->side - 1 ? &levels->parts[1] : blocks);
		coarse = grid;
	}
	for (uint32_t y = 0; y <= n && relative; y++)
		add_first(into.posts + y * into.stride, n + 1, head->first, head->scale);
}

bool store_levels_decode(struct codec *codec, const uint8_t *from, size_t size, int32_t *posts)
{
	struct levels levels;
	if (!read_parts(codec, from, size, 2, &levels))
		return false;
	make_grids(codec, &levels, codec->side - 1, (struct level_grid){posts, codec->side});
	if (levels.head.flags & CODEC_MASK)
		store_codec_apply_mask(codec->mask, plane_posts(codec), posts);
	return true;
}

bool store_levels_decode_half(struct codec *codec, const uint8_t *from, size_t size, int32_t *posts,
                              size_t stride)
{
	struct levels levels;
	const uint32_t side = codec->side, half = (side - 1) / 2;
	if (half < LEVELS_TOP || !read_parts(codec, from, size, 1, &levels))
		return false;
	make_grids(codec, &levels, half, (struct level_grid){posts, stride});
	for (uint32_t y = 0; y <= half && levels.head.flags & CODEC_MASK; y++)
		for (uint32_t x = 0; x <= half; x++) {
			size_t post = (size_t)2 * y * side + 2 * x;
			if (codec->mask[post / 8] >> post % 8 & 1)
				posts[y * stride + x] = CODEC_NODATA;
		}
	return true;
}
