#version 450 core
// Sumner's erosion, second pass: each post takes the soil that its neighbours shed. One fragment for each post.
// Defines:
// - LAST: the last iteration, which writes offsets
// - ROOFS: bodies at rest keep posts from rising
// - BLOCKS: as in slid.glsl

#include "lib/slide.glsl"

layout(binding = 0, r32i) readonly uniform iimage2DArray heights;
layout(binding = 1, r32i) readonly uniform iimage2DArray sheds;

#include "lib/slide_params.glsl"
#include "lib/slid.glsl"
#ifdef ROOFS
#include "lib/roofs.glsl"
#endif

const int SHARE = (1 << 23) - 1;

void main()
{
	ivec3 at = ivec3(ivec2(gl_FragCoord.xy), place.x);
	int shed = imageLoad(sheds, at).r, come = 0, nothing = shed;
#ifdef ROOFS
	// Each of two posts knows the room of the one that takes, so both compute the same amount.
	int change = 0, own_room = room_below_roof(at, imageLoad(heights, at).r);
#else
	int change = -bitCount(shed >> 23) * (shed & SHARE);
#endif
	for (int k = 0; k < 8; k++) {
		int other = imageLoad(sheds, at + ivec3(SLIDE_NEAR[k], 0)).r;
		int back = k < 4 ? 3 - k : 11 - k; // the way from there to here
		other = (other & (1 << (23 + back))) != 0 ? other : 0;
#ifdef ROOFS
		ivec3 there = at + ivec3(SLIDE_NEAR[k], 0);
		change -= (shed & (1 << (23 + k))) != 0 ? min(shed & SHARE, room_below_roof(there, imageLoad(heights, there).r)) : 0;
		come += min(other & SHARE, own_room);
#else
		come += other & SHARE;
#endif
		nothing |= other;
	}
	bool moves = change != 0 || come != 0;
#ifndef BLOCKS
	// A share that rounds to 0 counts as motion: beside another object fewer posts may share it, and then it is more than 0.
	moves = nothing != 0;
#endif
	slid(at, imageLoad(heights, at).r, change + come, moves, false);
}
