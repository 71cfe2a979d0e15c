/* The inner loops of the codec in plain C. They run on every machine. The versions for some CPUs must give the same bits. */
#include "store/codec_levels.h"

static const uint8_t *plain_unpack(const uint8_t *from, const uint8_t *widths, size_t count, uint32_t *rest)
{
	for (size_t block = 0; block < count; block++, rest += CODEC_BLOCK) {
		unsigned width = widths[block];
		uint64_t mask = ((uint64_t)1 << width) - 1;
		for (unsigned i = 0; i < CODEC_BLOCK; i++)
			rest[i] = codec_unzigzag((uint32_t)(load64(from + i * width / 8) >> i * width % 8 & mask));
		from += (size_t)2 * width;
	}
	return from;
}

static void plain_sum(const uint32_t *rest, uint32_t side, uint32_t rows, const int32_t *before, bool slope,
		      int32_t *posts)
{
	const uint32_t keep = slope ? 1 : 0; /* of the step before */
	for (uint32_t y = 0; y < rows; y++, rest += side, before = posts, posts += side) {
		uint32_t rise = rest[0], step = 0;
		posts[0] = (int32_t)(rise + (uint32_t)before[0]);
		for (uint32_t x = 1; x < side; x++) {
			step = step * keep + rest[x];
			rise += step;
			posts[x] = (int32_t)(rise + (uint32_t)before[x]);
		}
	}
}

/* Residuals in two's complement. */
static const uint8_t *unpack_level(const uint8_t *from, unsigned width, int32_t rest[LEVELS_BLOCK])
{
	for (unsigned i = 0; i < LEVELS_BLOCK; i++) {
		uint64_t bits = load64(from + i * width / 8) >> i * width % 8;
		rest[i] = width == 0 ? 0 : (int32_t)((uint32_t)bits << (32 - width)) >> (32 - width);
	}
	return from + width;
}

static const uint8_t *plain_spread(const int32_t *coarse, const uint8_t *from, const uint8_t *widths, size_t blocks, bool cubic,
				   int32_t *row)
{
	int32_t rest[LEVELS_BLOCK];
	for (size_t block = 0; block < blocks; block++, coarse += LEVELS_BLOCK, row += 2 * LEVELS_BLOCK) {
		from = unpack_level(from, widths[block], rest);
		for (int i = 0; i < LEVELS_BLOCK; i++) {
			int32_t l = cubic ? coarse[i - 1] : 0, r = cubic ? coarse[i + 2] : 0;
			row[2 * i] = coarse[i];
			row[2 * i + 1] = (int32_t)((uint32_t)level_between(l, coarse[i], coarse[i + 1], r, cubic) + (uint32_t)rest[i]);
		}
	}
	row[0] = coarse[0];
	return from;
}

static const uint8_t *plain_between(int32_t *first, size_t stride, const int32_t *before, const int32_t *after, const uint8_t *from,
				    const uint8_t *widths, size_t blocks, bool cubic)
{
	const int32_t *rows[5] = {before, first, first + 2 * stride, first + 4 * stride, after};
	int32_t rest[LEVELS_BLOCK];
	for (int odd = 0; odd < 2; odd++)
		for (size_t block = 0; block < blocks; block++) {
			const int32_t *const *around = rows + odd;
			int32_t *made = first + (odd ? 3 * stride : stride);
			from = unpack_level(from, *widths++, rest);
			for (size_t i = 0, x = block * LEVELS_BLOCK; i < LEVELS_BLOCK; i++, x++) {
				int32_t guess = level_between(cubic ? around[0][x] : 0, around[1][x], around[2][x], cubic ? around[3][x] : 0, cubic);
				made[x] = (int32_t)((uint32_t)guess + (uint32_t)rest[i]);
			}
		}
	return from;
}

static const uint8_t *plain_level(const uint8_t *from, const uint8_t *widths, size_t blocks, int32_t *rest)
{
	for (size_t block = 0; block < blocks; block++)
		from = unpack_level(from, widths[block], rest + block * LEVELS_BLOCK);
	return from;
}

static size_t plain_total(const uint8_t *widths, size_t count, uint8_t *most)
{
	size_t sum = 0;
	*most = 0;
	for (size_t i = 0; i < count; i++) {
		sum += widths[i];
		*most = widths[i] > *most ? widths[i] : *most;
	}
	return sum;
}

const struct codec_kernels store_codec_plain = {
	"plain", plain_unpack, plain_sum, plain_spread, plain_between, plain_level, plain_total,
};
