#version 450 core
// The first pass that lays down carried soil. It measures how much soil there is, and how large and deep the patch is that the body
// touches. If the soil goes around the patch, it also measures each post's distance to the patch along its row.

#include "lib/spread.glsl"
#include "lib/root.glsl"

layout(binding = 0, r8ui) readonly restrict uniform uimage2DArray contacts;
layout(binding = 1, r32i) readonly restrict uniform iimage2DArray carries;
layout(binding = 2, r32i) readonly restrict uniform iimage2DArray offsets;
layout(binding = 3, r32i) restrict uniform iimage2DArray ways;

const int DEEPEST = 1 << 23;
const int NO_WAY = 1023;
const int HALF_POST = 1 << 15;
const int NARROWEST = 128; // two posts, so that there is a post in it

bool is_touched(ivec3 post)
{
	return (imageLoad(contacts, post).r & (LOWERED | HELD)) != 0u;
}

void store_ways(int y)
{
	int way = NO_WAY;
	for (int x = written.x; x < written.z; x++) {
		way = is_touched(ivec3(x, y, place.x)) ? 0 : min(way + 1, NO_WAY);
		imageStore(ways, ivec3(x, y, place.x), ivec4(way));
	}
	way = NO_WAY;
	for (int x = written.z - 1; x >= written.x; x--) {
		int before = imageLoad(ways, ivec3(x, y, place.x)).r;
		way = before == 0 ? 0 : min(way + 1, NO_WAY);
		if (way < before)
			imageStore(ways, ivec3(x, y, place.x), ivec4(way));
	}
}

void find_width()
{
	bool wheel = origin.z > 0;
	sides[0] = int(ends[0]) - BIAS + HALF_POST;
	sides[1] = BIAS - int(ends[1]) - HALF_POST;
	sides[2] = wheel ? origin.z : int(ends[2]) - BIAS + HALF_POST;
	sides[3] = wheel ? -origin.z : BIAS - int(ends[3]) - HALF_POST;
	uint along = uint(sides[0] - sides[1]) >> 10, across = uint(sides[2] - sides[3]) >> 10;
	// The cross-section of the soil beside a metre of the patch's contour is this length times the depth.
	uint half_width = ((across * uint(65536 - origin.w)) >> 17) + ((along * uint(origin.w)) >> 17);
	int reaches = int(place.y != 0 ? (along >> 1) * across / (along + across) : half_width);
	i64 square = i64_mul_int(i64_mul(min(int(deep), DEEPEST), reaches), axis.z);
	width = min(max(square_root(i64_sar(square, 24)), max(reaches / 4, NARROWEST)), place.w);
}

void main()
{
	int y = row_of_pass();
	if (y >= written.w)
		return;
	uint lo = 0u, hi = 0u, count = 0u;
	int deepest = 0;
	ivec4 reach = ivec4(-BIAS);
	for (int x = shadow.x; x < shadow.z && y >= shadow.y && y < shadow.w; x++) {
		ivec3 post = ivec3(x, y, place.x);
		if (!is_touched(post))
			continue;
		int amount = imageLoad(carries, post).r, depth = clamp(-imageLoad(offsets, post).r, 0, DEEPEST);
		uint carry;
		lo = uaddCarry(lo, uint(amount), carry);
		hi += carry;
		count += uint(amount > 0);
		deepest = max(deepest, max(amount, int((uint(depth >> 8) * uint(place.z)) >> 8)));
		ivec2 at = frame_of(x, y);
		reach = max(reach, ivec4(at.x, -at.x, at.y, -at.y));
	}
	if (place.y != 0)
		store_ways(y);
	if (reach.x > -BIAS) {
		uint before = atomicAdd(carried[0], lo);
		atomicAdd(carried[1], hi + uint(before + lo < before));
		atomicAdd(givers, count);
		atomicMax(deep, uint(deepest));
		for (int face = 0; face < FACES; face++)
			atomicMax(ends[face], uint(BIAS + reach[face]));
	}
	if (is_last(0) && (carried[0] | carried[1]) != 0u)
		find_width();
}
