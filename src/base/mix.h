/* What makes the random numbers of relief and of rocks. shaders/lib has the same. */
#ifndef FURROW_BASE_MIX_H
#define FURROW_BASE_MIX_H

#include <stdint.h>

/* Mixes the bits of a word: multiplications and shifts after C. Wellons' search for 32-bit functions of small bias. Pure. */
static inline uint32_t mix_bits(uint32_t v)
{
	v ^= v >> 16;
	v *= 0x7feb352du;
	v ^= v >> 15;
	v *= 0x846ca68bu;
	return v ^ v >> 16;
}

#endif
