#include "base/noise.h"

/* The finaliser of splitmix64 (Steele, Lea, Flood 2014): each bit of the input changes half of the output's. */
static uint64_t mix(uint64_t x)
{
	x += 0x9e3779b97f4a7c15u;
	x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
	x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
	return x ^ (x >> 31);
}

uint64_t noise_stream(uint64_t above, const char *name)
{
	uint64_t stream = mix(above);
	for (; *name != '\0'; name++)
		stream = mix(stream ^ (unsigned char)*name);
	return mix(stream);
}

double noise_even(uint64_t stream, uint64_t number)
{
	return (double)(mix(stream ^ mix(number)) >> 11) * 0x1p-53;
}

/* Whole numbers are summed: no rounding, so no order of additions. */
double noise_normal(uint64_t stream, uint64_t number)
{
	const uint64_t base = mix(stream ^ mix(number));
	uint64_t sum = 0;
	for (uint64_t i = 0; i < 12; i++)
		sum += mix(base + i) >> 16;
	return (double)sum * 0x1p-48 - 6;
}
