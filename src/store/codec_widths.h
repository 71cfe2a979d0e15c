/* Codes the bit widths of blocks with a canonical Huffman code, in four streams that are decoded
 * side by side. */
#ifndef FURROW_STORE_CODEC_WIDTHS_H
#define FURROW_STORE_CODEC_WIDTHS_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

/* A symbol is the zigzag of a width (0 to 32) minus another. */
#define WIDTHS_SYMBOLS 65
#define WIDTHS_BITS_MOST 8 /* of a symbol's code */
#define WIDTHS_STREAMS 4
#define WIDTHS_LEAST 8 /* symbols of a coded run */

struct widths_code {
	uint8_t lengths[WIDTHS_SYMBOLS]; /* bits; 0: the symbol has no code */
	uint16_t codes[WIDTHS_SYMBOLS];  /* as written: first bit lowest */
};

/* For each byte, the codes that are whole in it: how many, their symbols, and how many bits they
 * have. */
struct widths_table {
	uint16_t first[1 << WIDTHS_BITS_MOST]; /* the first symbol and, times 256, its bits */
	uint64_t all[1 << WIDTHS_BITS_MOST];   /* six symbols at most, a byte each; their number;
	                                          their bits */
};

/* Makes the code for symbols that occur so often. At least one must occur. */
void store_widths_plan(const uint32_t counts[WIDTHS_SYMBOLS], struct widths_code *code);

/* Returns the most bytes of a table and of `count` symbols. */
size_t store_widths_bound(size_t count);
/* Write the code's table, and `count` symbols (at least WIDTHS_LEAST). They return the end of the
 * written bytes. */
uint8_t *store_widths_put_table(const struct widths_code *code, uint8_t *to);
uint8_t *store_widths_put(const struct widths_code *code, const uint8_t *symbols, size_t count,
                          uint8_t *to);

/* Read what these wrote, from untrusted bytes. They return false if the bytes are not a table, or
 * not `count` symbols. store_widths_get_table() moves *from behind the table. */
bool store_widths_get_table(const uint8_t **from, size_t *left,
                            struct widths_table *table) FURROW_CHECKED;
bool store_widths_get(const struct widths_table *table, const uint8_t *from, size_t size,
                      uint8_t *symbols, size_t count) FURROW_CHECKED;

#endif
