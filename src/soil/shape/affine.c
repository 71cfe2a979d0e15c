/* Converts affine functions of a post's position to whole numbers that the shaders evaluate. See affine.h. */
#include "soil/shape/affine.h"

#include <math.h>

static void put(uint32_t words[2], int64_t whole)
{
	words[0] = (uint32_t)whole;
	words[1] = (uint32_t)((uint64_t)whole >> 32);
}

struct functional soil_functional_of(struct affine value, int scale, int shift, int64_t x0, int64_t y0)
{
	value.at = by_power(value.at, scale + shift);
	value.dx = by_power(value.dx, scale + shift);
	value.dy = by_power(value.dy, scale + shift);
	for (; fabsl(value.at) + FUNCTIONAL_POSTS * (fabsl(value.dx) + fabsl(value.dy)) > 0x1p62L; shift -= shift > 0) {
		value.at /= 2;
		value.dx /= 2;
		value.dy /= 2;
	}
	/* The half makes the shift round to nearest. */
	int64_t at = llrintl(value.at + by_power(1, shift - 1)), di = llrintl(value.dx), dj = llrintl(value.dy);
	struct functional functional = {.dj_shift = {0, 0, (uint32_t)shift, 0}};
	put(functional.at_di, at + x0 * di + y0 * dj);
	put(functional.at_di + 2, di);
	put(functional.dj_shift, dj);
	return functional;
}
