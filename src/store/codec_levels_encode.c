/* Encodes a plane in levels, with the prediction that packs better: from two posts or from four. */
#include <assert.h>
#include <lz4.h>
#include <string.h>

#include "base/wide.h"
#include "store/codec_bits.h"
#include "store/codec_levels.h"
#include "store/codec_widths.h"

#define SAMPLE_ROWS 4           /* even: all of them are odd rows */
#define ABSOLUTE_MOST (1 << 26) /* of posts: then no sum of level_between() leaves int32 */

/* --- what is coded: posts, or posts minus `first` and without their common zero bits --- */

FURROW_WIDE static bool all_small(const int32_t *posts, size_t count)
{
	unsigned large = 0;
	for (size_t i = 0; i < count; i++)
		large |= posts[i] != CODEC_NODATA &&
		         (posts[i] > ABSOLUTE_MOST || posts[i] < -ABSOLUTE_MOST);
	return large == 0;
}

/* Returns false if a post that is no hole would look like one. */
FURROW_WIDE static bool take_relative(const int32_t *posts, size_t count, uint32_t first,
                                      unsigned scale, int32_t *to)
{
	unsigned bad = 0;
	for (size_t i = 0; i < count; i++) {
		int32_t value = (int32_t)((uint32_t)posts[i] - first) >> scale;
		bool hole = posts[i] == CODEC_NODATA;
		bad |= !hole & (value == CODEC_NODATA);
		to[i] = hole ? CODEC_NODATA : value;
	}
	return bad == 0;
}

/* --- residuals --- */

/* Every second post of a grid. */
static void decimate(struct level_grid fine, struct level_grid coarse, uint32_t half)
{
	for (uint32_t y = 0; y <= half; y++)
		for (uint32_t x = 0; x <= half; x++)
			coarse.posts[y * coarse.stride + x] =
			        fine.posts[2 * y * fine.stride + 2 * x];
}

/* The coarsest grid. A hole becomes its prediction. */
static void take_top(struct level_grid grid, uint32_t first, int32_t *rest)
{
	memset(rest, 0, level_blocks(LEVELS_TOP, LEVELS_TOP) * LEVELS_BLOCK * sizeof *rest);
	for (uint32_t y = 0; y <= LEVELS_TOP; y++) {
		int32_t *row = grid.posts + y * grid.stride;
		const int32_t *before = row - (y > 0 ? grid.stride : 0);
		uint32_t rise = 0;
		for (uint32_t x = 0; x <= LEVELS_TOP; x++, rest++) {
			uint32_t under = y > 0 ? (uint32_t)before[x] : first, guess = under + rise;
			if (row[x] == CODEC_NODATA)
				row[x] = (int32_t)guess;
			*rest = (int32_t)((uint32_t)row[x] - guess);
			rise = (uint32_t)row[x] - under;
		}
	}
}

/* The odd posts of an even row. */
static inline __attribute__((always_inline)) void
take_odd(int32_t *row, const int32_t *coarse, uint32_t half, bool cubic, bool holes, int32_t *rest)
{
	for (uint32_t i = 0; i < half; i++) {
		int32_t guess = level_between(coarse[(ptrdiff_t)i - 1], coarse[i], coarse[i + 1],
		                              coarse[i + 2], cubic);
		int32_t post = row[2 * i + 1];
		if (holes) {
			post = post == CODEC_NODATA ? guess : post;
			row[2 * i] = coarse[i];
			row[2 * i + 1] = post;
		}
		rest[i] = (int32_t)((uint32_t)post - (uint32_t)guess);
	}
	if (holes)
		row[2 * half] = coarse[half];
}

static inline __attribute__((always_inline)) void take_row(int32_t *row,
                                                           const int32_t *const rows[4],
                                                           uint32_t count, bool cubic, bool holes,
                                                           int32_t *rest)
{
	const int32_t *l = rows[0], *a = rows[1], *b = rows[2], *r = rows[3];
	for (uint32_t x = 0; x < count; x++) {
		int32_t guess = level_between(l[x], a[x], b[x], r[x], cubic), post = row[x];
		if (holes)
			row[x] = post = post == CODEC_NODATA ? guess : post;
		rest[x] = (int32_t)((uint32_t)post - (uint32_t)guess);
	}
}

/* Residuals of the grid of n cells, in the order of its bands. With `holes`, fills these with their
 * predictions. */
static inline __attribute__((always_inline)) void take_bands(struct level_grid coarse,
                                                             struct level_grid grid, uint32_t n,
                                                             bool cubic, bool holes, int32_t *edges,
                                                             int32_t *rest)
{
	const uint32_t half = n / 2;
	int32_t *lasts = rest + (size_t)(half + 1) * half + (size_t)half * n;
	for (uint32_t y = 0; y <= half; y++, rest += half)
		take_odd(grid.posts + 2 * y * grid.stride, coarse.posts + y * coarse.stride, half,
		         cubic, holes, rest);
	store_level_edge(grid.posts, 2 * (ptrdiff_t)grid.stride, n, edges);
	store_level_edge(grid.posts + n * grid.stride, -2 * (ptrdiff_t)grid.stride, n,
	                 edges + n + 1);
	for (uint32_t y = 0; y < half; y++, rest += n) {
		const int32_t *rows[4], *ends[4];
		int32_t *row = grid.posts + (2 * y + 1) * grid.stride;
		store_level_around(grid, n, y, edges, rows);
		for (int i = 0; i < 4; i++)
			ends[i] = rows[i] + n;
		take_row(row, rows, n, cubic, holes, rest);
		take_row(row + n, ends, 1, cubic, holes, lasts + y);
	}
}

#define BANDS(name, cubic, holes)                                                                  \
	FURROW_WIDE static void name(struct level_grid coarse, struct level_grid grid, uint32_t n, \
	                             int32_t *edges, int32_t *rest)                                \
	{                                                                                          \
		take_bands(coarse, grid, n, cubic, holes, edges, rest);                            \
	}
BANDS(take_linear, false, false)
BANDS(take_linear_filling, false, true)
BANDS(take_cubic, true, false)
BANDS(take_cubic_filling, true, true)

/* Residuals of all grids. `finest` is changed only if there are holes. */
static void take_residuals(struct codec *codec, struct level_grid finest, uint32_t first,
                           bool cubic, bool holes, int32_t *rest)
{
	const uint32_t cells = codec->side - 1;
	struct level_grid grid = finest;
	for (uint32_t n = cells; n > LEVELS_TOP; n /= 2) {
		decimate(grid, level_scratch(codec, n / 2), n / 2);
		grid = level_scratch(codec, n / 2);
	}
	take_top(grid, first, rest);
	rest += level_blocks(LEVELS_TOP, LEVELS_TOP) * LEVELS_BLOCK;
	for (uint32_t n = 2 * LEVELS_TOP; n <= cells; n *= 2) {
		struct level_grid coarse = grid;
		grid = n < cells ? level_scratch(codec, n) : finest;
		store_level_pad(coarse, n / 2);
		if (cubic)
			(holes ? take_cubic_filling : take_cubic)(coarse, grid, n, codec->edges,
			                                          rest);
		else
			(holes ? take_linear_filling : take_linear)(coarse, grid, n, codec->edges,
			                                            rest);
		rest += level_blocks(n, n) * LEVELS_BLOCK;
	}
}

/* Widths of the blocks. Returns what they sum to. */
FURROW_WIDE static size_t take_widths(const int32_t *rest, size_t blocks, uint8_t *widths)
{
	size_t sum = 0;
	for (size_t i = 0; i < blocks; i++, rest += LEVELS_BLOCK) {
		uint32_t any = 0;
		for (int j = 0; j < LEVELS_BLOCK; j++)
			any |= (uint32_t)rest[j] << 1 ^ (uint32_t)(rest[j] >> 31);
		widths[i] = (uint8_t)(any == 0 ? 0 : 32 - __builtin_clz(any));
		sum += widths[i];
	}
	return sum;
}

/* Residuals of every SAMPLE_ROWS-th row of the finest grid, predicted along its columns; 0 where a
 * hole takes part. Returns what the widths of their blocks sum to. */
static inline __attribute__((always_inline)) size_t
sample_rows(const int32_t *values, uint32_t side, bool cubic, int32_t *rest, uint8_t *widths)
{
	size_t sum = 0;
	const size_t two = 2 * (size_t)side;
	for (uint32_t y = 3; y + 3 < side; y += SAMPLE_ROWS) {
		const int32_t *row = values + (size_t)y * side, *a = row - side, *b = row + side,
		              *l = a - two, *r = b + two;
		for (uint32_t x = 0; x + 1 < side; x++) {
			bool hole = (row[x] == CODEC_NODATA) | (a[x] == CODEC_NODATA) |
			            (b[x] == CODEC_NODATA) | (l[x] == CODEC_NODATA) |
			            (r[x] == CODEC_NODATA);
			int32_t less =
			        (int32_t)((uint32_t)row[x] -
			                  (uint32_t)level_between(l[x], a[x], b[x], r[x], cubic));
			rest[x] = hole ? 0 : less;
		}
		sum += take_widths(rest, (side - 1) / LEVELS_BLOCK, widths);
	}
	return sum;
}

#define SAMPLE(name, cubic)                                                                        \
	FURROW_WIDE static size_t name(const int32_t *values, uint32_t side, int32_t *rest,        \
	                               uint8_t *widths)                                            \
	{                                                                                          \
		return sample_rows(values, side, cubic, rest, widths);                             \
	}
SAMPLE(sample_linear, false)
SAMPLE(sample_cubic, true)

bool store_levels_suit(struct codec *codec, const int32_t *posts)
{
	const size_t blocks = (codec->side - 1) / LEVELS_BLOCK;
	uint8_t *widths = codec->widths[0];
	int32_t *rest = (int32_t *)codec->orders[0];
	size_t rows = 0, flat = 0;
	for (uint32_t y = 3; y + 3 < codec->side; y += SAMPLE_ROWS, rows++) {
		const int32_t *row = posts + (size_t)y * codec->side, *up = row - codec->side;
		for (uint32_t x = 0; x + 1 < codec->side; x++)
			rest[x] = (int32_t)((uint32_t)row[x + 1] - (uint32_t)row[x] - ((uint32_t)up[x + 1] - (uint32_t)up[x]));
		take_widths(rest, blocks, widths);
		for (size_t i = 0; i < blocks; i++)
			flat += widths[i] == 0;
	}
	return flat < rows * blocks / 8;
}

/* Residuals and widths, by the prediction that packs a sample of rows better. Returns whether that
 * is the one from four posts. */
static bool choose(struct codec *codec, const int32_t *values, uint32_t first, bool holes)
{
	const size_t count = plane_posts(codec), blocks = level_blocks(LEVELS_TOP, codec->side - 1);
	int32_t *rest = (int32_t *)codec->orders[0];
	uint8_t *widths = codec->widths[0];
	const bool cubic = sample_cubic(values, codec->side, rest, widths) <
	                   sample_linear(values, codec->side, rest, widths);
	struct level_grid finest = {(int32_t *)(holes ? codec->filled : values), codec->side};
	if (holes)
		memcpy(codec->filled, values, count * sizeof *values);
	take_residuals(codec, finest, first, cubic, holes, rest);
	take_widths(rest, blocks, widths);
	return cubic;
}

/* --- bytes --- */

/* Each width minus the one above it in its band, as a symbol; and how often each occurs. */
static void take_symbols(const uint8_t *widths, uint32_t cells, uint8_t *symbols,
                         uint32_t counts[WIDTHS_SYMBOLS])
{
	memset(counts, 0, WIDTHS_SYMBOLS * sizeof *counts);
	for (uint32_t n = LEVELS_TOP; n <= cells; n *= 2) {
		struct level_band bands[3];
		for (int i = 0, count = level_bands(n, bands); i < count; i++)
			for (uint32_t row = 0; row < bands[i].rows; row++)
				for (uint32_t block = 0; block < bands[i].blocks;
				     block++, widths++, symbols++) {
					int less = *widths -
					           (row > 0 ? *(widths - bands[i].blocks) : 0);
					*symbols = (uint8_t)(less >= 0 ? 2 * less : -2 * less - 1);
					counts[*symbols]++;
				}
	}
}

struct part {
	uint32_t first, last; /* cells of its grids */
	const uint8_t *coded; /* its widths, coded */
	size_t size;
};

/* Codes the widths of all parts into codec->body. Returns true if they are under LZ4 too, where
 * that is worth its time. */
static bool code_widths(struct codec *codec, const struct widths_code *code, const uint8_t *symbols,
                        struct part *parts, int count)
{
	uint8_t *to = codec->body;
	size_t plain = 0, squeezed = 0;
	for (int i = 0; i < count; i++) {
		size_t some = level_blocks(parts[i].first, parts[i].last);
		parts[i].coded = to;
		to = store_widths_put(code, symbols, some, to);
		symbols += some;
		parts[i].size = (size_t)(to - parts[i].coded);
		plain += parts[i].size;
	}
	struct part shorter[2];
	for (int i = 0; i < count; i++) {
		int most = LZ4_compressBound((int)parts[i].size);
		int size = LZ4_compress_default((const char *)parts[i].coded, (char *)to,
		                                (int)parts[i].size, most);
		assert(size > 0);
		shorter[i] = (struct part){parts[i].first, parts[i].last, to, (size_t)size};
		squeezed += (size_t)size;
		to += size;
	}
	assert((size_t)(to - codec->body) <= codec->room);
	if (squeezed > plain - plain / 8)
		return false;
	memcpy(parts, shorter, (size_t)count * sizeof *parts);
	return true;
}

void store_levels_encode(struct codec *codec, const int32_t *posts, const struct head *from,
                         size_t *size)
{
	const uint32_t cells = codec->side - 1;
	const size_t count = plane_posts(codec);
	const bool holes = (from->flags & CODEC_MASK) != 0;
	const int32_t *values = posts;
	struct head head = *from;
	if ((head.scale > 0 || !all_small(posts, count)) &&
	    take_relative(posts, count, head.first, head.scale, (int32_t *)(void *)codec->body)) {
		values = (const int32_t *)(const void *)codec->body;
		head.flags |= head.scale > 0 ? 0 : CODEC_RELATIVE;
	}
	const bool cubic = choose(codec, values, values == posts ? head.first : 0, holes);
	const int32_t *rest = (const int32_t *)codec->orders[0];
	const uint8_t *widths = codec->widths[0];
	uint8_t *symbols = codec->widths[1];
	uint32_t counts[WIDTHS_SYMBOLS];
	struct widths_code code;
	struct part parts[2] = {{.first = LEVELS_TOP, .last = level_half(cells)},
	                        {.first = cells, .last = cells}};
	const int part_count = cells > LEVELS_TOP ? 2 : 1;
	take_symbols(widths, cells, symbols, counts);
	store_widths_plan(counts, &code);
	bool shorter = code_widths(codec, &code, symbols, parts, part_count);
	head.flags |= (cubic ? CODEC_CUBIC : 0) | (shorter ? CODEC_SHORT : 0);
	uint8_t *to = store_codec_write_head(codec, &head, 0, codec->squeezed);
	to = store_widths_put_table(&code, to);
	for (int i = 0; i < part_count; i++) {
		const size_t blocks = level_blocks(parts[i].first, parts[i].last);
		put32(to, (uint32_t)parts[i].size);
		memcpy(to + CODEC_LENGTH_BYTES, parts[i].coded, parts[i].size);
		to = store_bits_pack_levels(rest, widths, blocks,
		                            to + CODEC_LENGTH_BYTES + parts[i].size);
		rest += blocks * LEVELS_BLOCK;
		widths += blocks;
	}
	*size = (size_t)(to - codec->squeezed);
	assert(*size <= codec->squeezed_room);
}
