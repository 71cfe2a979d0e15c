/*
 * The codec's two inner loops, once in plain C and once for each kind of machine that is worth it.
 * All give the same bits; which one a machine runs is found out when a codec is made.
 */
#ifndef FURROW_STORE_CODEC_KERNELS_H
#define FURROW_STORE_CODEC_KERNELS_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

#define CODEC_BLOCK 16 /* residuals that share a width; 2 * width bytes */
#define CODEC_SLACK 48 /* bytes that unpack may read beyond a block */

static inline uint32_t codec_unzigzag(uint32_t value)
{
	return value >> 1 ^ (0u - (value & 1));
}

struct codec_kernels {
	const char *name;
	/* `count` blocks of `widths` (each at most 32) to residuals, zigzag undone; returns their end.
	 * `from` can be read for CODEC_SLACK bytes beyond it. */
	const uint8_t *(*unpack)(const uint8_t *from, const uint8_t *widths, size_t count, uint32_t *rest);
	/* Residuals of `rows` rows to posts. Sums the residuals along each row, and adds the row before; for the first row, that is
	 * `before`. With `slope` it adds sums of sums, from a row's second post on. */
	void (*sum)(const uint32_t *rest, uint32_t side, uint32_t rows, const int32_t *before, bool slope,
		    int32_t *posts);
};

extern const struct codec_kernels store_codec_plain;
/* The fastest that this machine has. */
const struct codec_kernels *store_codec_kernels_best(void);

#endif
