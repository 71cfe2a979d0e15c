/* Packs blocks of residuals into bits, for the encoder of tiles. */
#include "store/codec_bits.h"

#include "store/codec_levels.h"

static inline void put(uint8_t *to, uint64_t bits, int bytes)
{
	for (int i = 0; i < bytes; i++)
		to[i] = (uint8_t)(bits >> (8 * i));
}

/* Packs so many numbers, of which each has its low `width` bits written. With a width known to the compiler nothing of this but masks,
 * shifts and stores is left. */
static inline __attribute__((always_inline)) void pack_block(const uint32_t *rest, int numbers, unsigned width, uint8_t *to)
{
	const uint32_t mask = (uint32_t)(((uint64_t)1 << width) - 1);
	uint64_t bits = 0;
	unsigned have = 0;
#pragma GCC unroll 16
	for (int i = 0; i < numbers; i++) {
		bits |= (uint64_t)(rest[i] & mask) << have;
		have += width;
		if (have >= 32) {
			put(to, bits, 4);
			to += 4;
			bits >>= 32;
			have -= 32;
		}
	}
	put(to, bits, (int)(have / 8)); /* eight widths are whole bytes */
}

#define WIDTH(w)                                                                                   \
	case w:                                                                                    \
		pack_block(rest, numbers, w, to);                                                  \
		break
#define WIDTHS(w) WIDTH(w); WIDTH(w + 1); WIDTH(w + 2); WIDTH(w + 3)

static inline __attribute__((always_inline)) uint8_t *pack(const uint32_t *rest, const uint8_t *widths, size_t count, int numbers, uint8_t *to)
{
	for (size_t block = 0; block < count; block++, rest += numbers) {
		switch (widths[block]) {
			WIDTHS(1);
			WIDTHS(5);
			WIDTHS(9);
			WIDTHS(13);
		default:
			pack_block(rest, numbers, widths[block], to);
		}
		to += (size_t)numbers / 8 * widths[block];
	}
	return to;
}

uint8_t *store_bits_pack(const uint32_t *rest, const uint8_t *widths, size_t count, uint8_t *to)
{
	return pack(rest, widths, count, CODEC_BLOCK, to);
}

uint8_t *store_bits_pack_levels(const int32_t *rest, const uint8_t *widths, size_t count, uint8_t *to)
{
	return pack((const uint32_t *)rest, widths, count, LEVELS_BLOCK, to);
}
