/* Blocks of residuals to bits. Encoding only; codec_kernels.h has the way back. */
#ifndef FURROW_STORE_CODEC_BITS_H
#define FURROW_STORE_CODEC_BITS_H

#include <stddef.h>
#include <stdint.h>

/* `count` blocks of CODEC_BLOCK residuals, none wider than its block's width; 2 * width bytes each,
 * least significant bit first. Returns the end. */
uint8_t *store_bits_pack(const uint32_t *rest, const uint8_t *widths, size_t count, uint8_t *to);

#endif
