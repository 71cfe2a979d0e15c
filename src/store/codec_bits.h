/* Packs blocks of residuals into bits. For encoding only; codec_kernels.h unpacks. */
#ifndef FURROW_STORE_CODEC_BITS_H
#define FURROW_STORE_CODEC_BITS_H

#include <stddef.h>
#include <stdint.h>

/* Packs `count` blocks of CODEC_BLOCK residuals. No residual needs more bits than its block's width. A block takes 2 * width
 * bytes, least significant bit first. Returns the end of the written bytes. */
uint8_t *store_bits_pack(const uint32_t *rest, const uint8_t *widths, size_t count, uint8_t *to);
/* The same for blocks of eight residuals in two's complement (codec_levels.h). A block takes `width` bytes. */
uint8_t *store_bits_pack_levels(const int32_t *rest, const uint8_t *widths, size_t count, uint8_t *to);

#endif
