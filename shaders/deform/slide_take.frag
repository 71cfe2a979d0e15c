#version 450 core
// Sumner's erosion, second pass: each post takes the soil that its neighbours shed. One fragment for each post.
// Defines:
// - LAST: the last iteration, which writes offsets
// - BLOCKS: as in slid.glsl

#include "lib/slide.glsl"

layout(binding = 0, r32i) readonly uniform iimage2DArray heights;
layout(binding = 1, r32i) readonly uniform iimage2DArray sheds;

#include "lib/slide_params.glsl"
#include "lib/slid.glsl"

const int SHARE = (1 << 23) - 1;

void main()
{
	ivec3 at = ivec3(ivec2(gl_FragCoord.xy), place.x);
	int shed = imageLoad(sheds, at).r, change = -bitCount(shed >> 23) * (shed & SHARE), come = 0, nothing = shed;
	for (int k = 0; k < 8; k++) {
		int other = imageLoad(sheds, at + ivec3(SLIDE_NEAR[k], 0)).r;
		int back = k < 4 ? 3 - k : 11 - k; // the way from there to here
		other = (other & (1 << (23 + back))) != 0 ? other : 0;
		come += other & SHARE;
		nothing |= other;
	}
	bool moves = change != 0 || come != 0;
#ifndef BLOCKS
	// A share that rounds to 0 counts as motion: beside another object fewer posts may share it, and then it is more than 0.
	moves = nothing != 0;
#endif
	slid(at, imageLoad(heights, at).r, change + come, moves, false);
}
