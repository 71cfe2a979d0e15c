/*
 * Noise of sensors: pure functions of a stream and a number in it. Nothing is kept, so neither the order of calls nor other calls matter. The same seed
 * gives the same bits on every machine. Any thread.
 */
#ifndef FURROW_BASE_NOISE_H
#define FURROW_BASE_NOISE_H

#include <stdint.h>

/* Returns a stream of its own for a name, below another stream or a seed. */
uint64_t noise_stream(uint64_t above, const char *name);
/* Returns a number that is at least 0 and below 1: a whole multiple of 2^-53. */
double noise_even(uint64_t stream, uint64_t number);
/* Returns a number whose mean is 0 and whose standard deviation is 1. It is the sum of twelve uniform random numbers between 0 and 1, minus 6. So it is within 6,
 * and nearly normal. */
double noise_normal(uint64_t stream, uint64_t number);

#endif
