#version 450 core
// The third pass that lays down carried soil: each post of a band gets soil by its weight. The remainder of rounding goes to the
// post of the face with the largest weight, so the sum is exact.

#include "lib/spread.glsl"

layout(binding = 0, r32i) coherent restrict uniform iimage2DArray deposits; // in: weight, face << 16; out: fixed-point units

const int REST_MOST = 1 << 20;

i64 amount(i64 rate, uint weight)
{
	return i64_sar(i64_mul_int(rate, int(weight)), RATE_BITS);
}

void lay_rest(int face)
{
	i64 rest = i64_sub(words(handed.parts[2 * face], handed.parts[2 * face + 1]), words(handed.laid[2 * face], handed.laid[2 * face + 1]));
	if (i64_less(rest, i64_from(REST_MOST))) {
		uint at = handed.heaviest[face];
		imageAtomicAdd(deposits, ivec3(int(at & 1023u), int(at >> 10 & 1023u), place.x), i64_to_int(rest));
	} else {
		tally_sum(COMPACTED, uvec2(rest.lo, uint(rest.hi)));
		tally_add(REFUSED, 1u);
	}
}

void main()
{
	int y = row_of_pass(written.y);
	if (y >= written.w || (handed.carried[0] | handed.carried[1]) == 0u)
		return;
	i64 rate[FACES];
	for (int face = 0; face < FACES; face++)
		rate[face] = words(handed.rates[2 * face], handed.rates[2 * face + 1]);
	uvec4 sum = uvec4(0u); // of the row's weights so far, by face
	ivec4 sent = ivec4(0); // the soil that these weights get; differences fit 32 bits
	find_band();
	ivec2 posts = posts_of_row(y), takes = written.zx;
	for (int x = posts.x; x < posts.y; x++) {
		ivec3 post = ivec3(x, y, place.x);
		int weighed = imageLoad(deposits, post).r, face = weighed >> 16;
		if (weighed == 0)
			continue;
		takes = ivec2(min(takes.x, x), x + 1);
		bvec4 here = equal(ivec4(face), ivec4(0, 1, 2, 3));
		sum += uvec4(here) * uint(weighed & 0xffff);
		uint weight = here.x ? sum.x : here.y ? sum.y : here.z ? sum.z : sum.w;
		i64 own = here.x ? rate[0] : here.y ? rate[1] : here.z ? rate[2] : rate[3];
		int sends = i64_to_int(amount(own, weight)), before = here.x ? sent.x : here.y ? sent.y : here.z ? sent.z : sent.w;
		imageStore(deposits, post, ivec4(sends - before));
		sent = mix(sent, ivec4(sends), here);
	}
	reach(y, takes.x, takes.y);
	for (int face = 0; face < FACES; face++)
		if (sum[face] > 0u) {
			i64 all = amount(rate[face], sum[face]);
			uint before = atomicAdd(handed.laid[2 * face], all.lo);
			atomicAdd(handed.laid[2 * face + 1], uint(all.hi) + uint(before + all.lo < before));
		}
	if (is_last(1))
		for (int face = 0; face < FACES; face++)
			if (handed.weights[face] > 0u)
				lay_rest(face);
}
