#version 450 core
// Sumner's erosion: what was shed arrives. One fragment a post.
// Defines: LAST: back to offsets; FLAGS: over blocks.

#include "lib/slide.glsl"

layout(binding = 0, r32i) readonly uniform iimage2DArray heights;
layout(binding = 1, r32i) readonly uniform iimage2DArray sheds;

layout(std140, binding = 0) uniform params {
	ivec4 region; // regions.vert's; over a window: a post's place from its first block, blocks in a row, the first word
	ivec4 place;  // the layer; near a block's side is within so many posts of it
	ivec4 edge;   // over a window: posts across whose sides all was looked at: first, one behind the last
};

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
#ifndef FLAGS
	// Shares of nothing too: beside another object fewer posts may get one, and then it is something.
	moves = nothing != 0;
#endif
	slid(at, imageLoad(heights, at).r, change + come, moves);
}
