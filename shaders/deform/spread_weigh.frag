#version 450 core
// The second pass that lays down carried soil. It computes the weights of the posts that take soil, and the soil for each unit of
// weight.

#include "lib/spread.glsl"

layout(binding = 0, r8ui) readonly restrict uniform uimage2DArray contacts;
layout(binding = 1, r32i) readonly restrict uniform iimage2DArray ways;
layout(binding = 2, r32i) writeonly restrict uniform iimage2DArray weighed; // in the atlas of deposits: weight, face << 16
layout(binding = 3, r32i) readonly restrict uniform iimage2DArray bases;

const int AMOUNT_MOST = 1 << 29; // the most soil that a post gets, fixed-point units

// Returns the weight of a post around the patch. It follows from the distance to the nearest touched post, less half a post.
int from_patch(int x, int y)
{
	int least = 1 << 20, far = (band >> 6) + 1;
	for (int by = 0; by <= far && by * by < least; by++)
		for (int side = 0; side < 2; side++) {
			int row = side == 0 ? y + by : y - by;
			int way = row >= shadow.y && row < shadow.w ? imageLoad(ways, ivec3(x, row, place.x)).r : NO_WAY;
			least = min(least, way * way + by * by);
		}
	least = min(least, 1 << 18);
	int root = int(sqrt(float(least << 12)));
	root -= int(root * root > least << 12);
	root += int((root + 1) * (root + 1) <= least << 12);
	return least == 0 ? 0 : profile(root - 32);
}

// Returns the weight of a post beside a face of the rectangle. at: in the frame
int beside_face(ivec2 at, out int face)
{
	int along = max(at.x - rectangle.x, rectangle.y - at.x), aside = max(at.y - rectangle.z, rectangle.w - at.y);
	bool rolls = axis.w != 0, beside = rolls ? aside > 0 : along <= 0;
	face = beside ? (at.y > 0 ? 2 : 3) : (at.x > 0 ? 0 : 1);
	int from_end = axis.z + (axis.w > 0 ? at.x : -at.x);
	bool far = rolls ? from_end < 0 || from_end >= abs(axis.w) : abs(at.x) > axis.z;
	far = beside ? far : aside > 0;
	return far || shares[face] == 0 ? 0 : profile((beside ? aside : along) >> 10);
}

// Returns a / b rounded down; 0 <= a < 2^63, 0 < b < 2^31.
i64 quotient(i64 a, uint b)
{
	uint rest = 0u;
	i64 result = i64(0, 0u);
	for (int bit = 62; bit >= 0; bit--) {
		rest = 2u * rest + (i64_sar(a, bit).lo & 1u);
		bool fits = rest >= b;
		rest -= fits ? b : 0u;
		result = i64_add(i64_shl(result, 1), i64_from(int(fits)));
	}
	return result;
}

void find_rates()
{
	i64 all = words(handed.carried[0], handed.carried[1]), rest = all, part[FACES];
	int most = -1;
	for (int face = 0; face < FACES; face++) {
		bool takes = handed.weights[face] > 0u;
		part[face] = takes ? i64_sar(i64_mul_int(all, shares[face]), 16) : i64(0, 0u);
		rest = i64_sub(rest, part[face]);
		most = takes && (most < 0 || shares[face] > shares[most]) ? face : most;
	}
	if (most < 0) {
		tally_sum(COMPACTED, uvec2(all.lo, uint(all.hi)));
		tally_add(CONFINED, handed.givers);
		return;
	}
	part[most] = i64_add(part[most], rest);
	for (int face = 0; face < FACES; face++) {
		if (handed.weights[face] == 0u)
			continue;
		i64 rate = quotient(i64_shl(part[face], RATE_BITS), handed.weights[face]);
		i64 limit = quotient(i64_shl(i64_from(AMOUNT_MOST), RATE_BITS), handed.heaviest[face] >> 20);
		rate = i64_min(rate, limit);
		handed.parts[2 * face] = part[face].lo;
		handed.parts[2 * face + 1] = uint(part[face].hi);
		handed.rates[2 * face] = rate.lo;
		handed.rates[2 * face + 1] = uint(rate.hi);
	}
}

uvec4 sum = uvec4(0u), best = uvec4(0u); // of this row, by face

void weigh(int x, int y, int face, int weight)
{
	ivec3 post = ivec3(x, y, place.x);
	if (weight <= 0 || (imageLoad(contacts, post).r & (TOUCHED_POST | CRAMPED)) != 0u || imageLoad(bases, post).r == BASE_NODATA)
		return;
	imageStore(weighed, post, ivec4(face << 16 | weight));
	uvec4 here = uvec4(equal(ivec4(face), ivec4(0, 1, 2, 3)));
	sum += here * uint(weight);
	best = max(best, here * (uint(weight) << 20 | uint(y) << 10 | uint(x)));
}

void main()
{
	int y = row_of_pass(written.y);
	if (y >= written.w || (handed.carried[0] | handed.carried[1]) == 0u)
		return;
	// Two loops, not one loop with a branch: a driver may compute both sides of a branch for every post.
	find_band();
	ivec2 row = posts_of_row(y);
	for (int x = row.x; x < row.y && place.y != 0; x++)
		weigh(x, y, 0, from_patch(x, y));
	ivec2 at = frame_of(origin.xy, axis.xy, row.x, y), step = ivec2(axis.x, -axis.y);
	for (int x = row.x; x < row.y && place.y == 0; x++, at += step) {
		int face, weight = beside_face(at, face);
		weigh(x, y, face, weight);
	}
	for (int face = 0; face < FACES; face++)
		if (sum[face] > 0u) {
			atomicAdd(handed.weights[face], sum[face]);
			atomicMax(handed.heaviest[face], best[face]);
		}
	if (is_last(0))
		find_rates();
}
