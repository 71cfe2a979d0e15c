#include "deform/affine.h"

#include <math.h>

static void put(uint32_t words[2], long double value)
{
	int64_t whole = (int64_t)llrintl(value);
	words[0] = (uint32_t)whole;
	words[1] = (uint32_t)((uint64_t)whole >> 32);
}

struct functional functional_of(long double at, long double di, long double dj, int scale, int shift)
{
	at = ldexpl(at, scale + shift);
	di = ldexpl(di, scale + shift);
	dj = ldexpl(dj, scale + shift);
	while (fabsl(at) + 256 * (fabsl(di) + fabsl(dj)) > 0x1p62L) {
		at /= 2;
		di /= 2;
		dj /= 2;
	}
	struct functional functional = {.dj_shift = {0, 0, (uint32_t)shift, 0}};
	put(functional.at_di, at);
	put(functional.at_di + 2, di);
	put(functional.dj_shift, dj);
	return functional;
}
