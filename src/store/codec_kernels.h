/*
 * The codec's inner loops, in plain C and in versions for some CPUs. All versions give the same bits. The version is chosen
 * when a codec is made, by the CPU that it runs on.
 */
#ifndef FURROW_STORE_CODEC_KERNELS_H
#define FURROW_STORE_CODEC_KERNELS_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

#define CODEC_BLOCK 16 /* residuals that share a bit width; a block takes 2 * width bytes */
#define CODEC_SLACK 48 /* bytes that unpack may read after the end of a block */

static inline uint32_t codec_unzigzag(uint32_t value)
{
	return value >> 1 ^ (0u - (value & 1));
}

struct codec_kernels {
	const char *name;
	/* Unpacks `count` blocks with these `widths` (each at most 32) into residuals and undoes their zigzag coding. Returns
	 * the end of the bytes read. CODEC_SLACK bytes after the end must be readable. */
	const uint8_t *(*unpack)(const uint8_t *from, const uint8_t *widths, size_t count, uint32_t *rest);
	/* Turns the residuals of `rows` rows into posts. Sums the residuals along each row, and adds the row before it.
	 * `before` is the row before the first. With `slope`, sums twice from a row's second post on. */
	void (*sum)(const uint32_t *rest, uint32_t side, uint32_t rows, const int32_t *before, bool slope,
		    int32_t *posts);
	/*
	 * Levels (codec_levels.h). All unpack blocks of eight residuals with these widths (each at most 32), and return the end of
	 * the bytes read. CODEC_SLACK bytes after the end must be readable.
	 *
	 * spread() makes an even row from a row of the coarser grid: its posts, and one between each two of them. The coarse row
	 * has 8 * blocks + 1 posts, and with `cubic` one more before and after these.
	 *
	 * between() makes two odd rows in place, without their last posts, from five even rows. These are `before`, `first`, the two
	 * that follow it two rows apart, and `after`. Only with `cubic` are `before` and `after` used. The second odd row's widths
	 * and bytes follow the first's.
	 *
	 * level() makes the residuals themselves. total() sums widths; *most: the greatest.
	 */
	const uint8_t *(*spread)(const int32_t *coarse, const uint8_t *from, const uint8_t *widths, size_t blocks, bool cubic,
				 int32_t *row);
	const uint8_t *(*between)(int32_t *first, size_t stride, const int32_t *before, const int32_t *after, const uint8_t *from,
				  const uint8_t *widths, size_t blocks, bool cubic);
	const uint8_t *(*level)(const uint8_t *from, const uint8_t *widths, size_t blocks, int32_t *rest);
	size_t (*total)(const uint8_t *widths, size_t count, uint8_t *most);
};

extern const struct codec_kernels store_codec_plain;
/* Returns the fastest version that this CPU can run. */
const struct codec_kernels *store_codec_kernels_best(void);

#endif
