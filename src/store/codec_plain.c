/* The inner loops of the codec in plain C. They run on every machine. The versions for some CPUs must give the same bits. */
#include <string.h>

#include "store/codec_kernels.h"

static uint64_t load64(const uint8_t *from)
{
	uint64_t value;
	memcpy(&value, from, sizeof value);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
	value = __builtin_bswap64(value);
#endif
	return value;
}

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

const struct codec_kernels store_codec_plain = {"plain", plain_unpack, plain_sum};
