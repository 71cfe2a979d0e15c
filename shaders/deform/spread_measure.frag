#version 450 core
// The first pass that lays down carried soil. It measures how much soil there is, and how large and deep the patch is that the body touches. One invocation for each row of posts that the object can be above.

#include "lib/spread.glsl"

layout(binding = 0, r8ui) readonly restrict uniform uimage2DArray contacts;
layout(binding = 1, r32i) readonly restrict uniform iimage2DArray carries;
layout(binding = 2, r32i) readonly restrict uniform iimage2DArray offsets;
#if SOILS > 1
layout(binding = 4) uniform usampler2DArray classes;
#else
int the_share = given.soils[0].y;
#endif

#include "lib/ways.glsl"

void main()
{
	int y = row_of_pass(shadow.y);
	if (y >= shadow.w)
		return;
	uint lo = 0u, hi = 0u, count = 0u, of_classes = 0u;
	int deepest = 0, first = shadow.z, last = shadow.x;
	ivec2 reaches = shadow.zx;
	for (int x = shadow.x; x < shadow.z; x++) {
		ivec3 post = ivec3(x, y, place.x);
		uint contact = imageLoad(contacts, post).r;
		reaches = (contact & ~NO_GROUND) != 0u ? ivec2(min(reaches.x, x), x + 1) : reaches;
		if ((contact & TOUCHED_POST) == 0u)
			continue;
#if SOILS > 1
		int soil = min(int(texelFetch(classes, post, 0).r), SOILS - 1), share = given.soils[soil].y;
#else
		int soil = 0, share = the_share;
#endif
		int amount = imageLoad(carries, post).r;
		uint carry;
		lo = uaddCarry(lo, uint(amount), carry);
		hi += carry;
		count += uint(amount > 0);
		of_classes |= amount > 0 ? 1u << soil : 0u;
		deepest = max(deepest, depth_of(amount, imageLoad(offsets, post).r, share));
		first = min(first, x);
		last = max(last, x);
	}
	if (place.y != 0)
		store_ways(y, place.x, written.x, written.z);
	reach(y, reaches.x, reaches.y);
	if (first <= last)
		measured(uvec2(lo, hi), count, of_classes, deepest,
			 ivec2[2](frame_of(origin.xy, axis.xy, first, y), frame_of(origin.xy, axis.xy, last, y)));
}
