#version 450 core
// Sumner's erosion, first pass: how much each post sheds to each lower neighbour, and to which. One fragment for each post.
// Defines: SOILS: number of soil classes in the parameters; STOOD: undisturbed ground is stable, however steep; ROOFS: bodies at rest keep posts from
// rising.

#include "lib/slide.glsl"
#include "lib/squares.glsl"

layout(binding = 0, r32i) readonly uniform iimage2DArray heights;
layout(binding = 1, r8ui) readonly uniform uimage2DArray contacts;
#if SOILS > 1
layout(binding = 2, r8ui) readonly uniform uimage2DArray classes;
#endif

struct sumner {
	ivec4 out_in;     // difference of heights above which soil moves: axial, diagonal; the same beside a held post
	ivec4 stop;       // a post sheds only if a difference exceeds this: axial, diagonal; the tolerance, which all of these include
	uvec4 few, many;  // in 2^-32: share of the sum of differences that each of 1 .. 8 neighbours gets
};

#include "lib/slide_params.glsl"

layout(std140, binding = 0) uniform soils_of_posts {
	SQUARES_FIRST
	ivec4 others[PASSED];
	sumner soils[SOILS];
};

#ifdef ROOFS
#include "lib/roofs.glsl"
#endif

layout(location = 0) out int shed_out; // bits 0 .. 22: the share; from bit 23 on a bit for each neighbour that gets it

const int DIFFERENCE_MOST = 1 << 26; // the sum of eight fits 32 bits

void main()
{
	ivec3 at = ivec3(ivec2(gl_FragCoord.xy), place.x);
#if SOILS > 1
	sumner soil = soils[min(int(imageLoad(classes, at).r), SOILS - 1)];
#else
	sumner soil = soils[0];
#endif
	int height = imageLoad(heights, at).r;
	bool held = (imageLoad(contacts, at).r & HELD) != 0u, starts = false;
	int to = 0, count = 0, sum = 0;
#ifdef STOOD
	int base = imageLoad(grounds, at).r;
#endif
	for (int k = 0; k < 8; k++) {
		ivec3 there = at + ivec3(SLIDE_NEAR[k], 0);
		int other = imageLoad(heights, there).r, difference = height - other;
		bool pair_held = held || (imageLoad(contacts, there).r & HELD) != 0u;
		ivec2 goes = pair_held ? soil.out_in.zw : soil.out_in.xy;
		bool open = other != STILL;
#ifdef STOOD
		open = open && risen(difference, base, there) > soils[0].stop.z;
#endif
#ifdef ROOFS
		open = open && room_below_roof(there, other) > 0;
#endif
		starts = starts || (open && difference > (k < 4 ? soil.stop.x : soil.stop.y));
		bool steep = open && difference > (k < 4 ? goes.x : goes.y);
		to |= steep ? 1 << (23 + k) : 0;
		count += int(steep);
		sum += steep ? min(difference, DIFFERENCE_MOST) : 0;
	}
	uint part = count == 1 ? soil.few.x : count == 2 ? soil.few.y : count == 3 ? soil.few.z : count == 4 ? soil.few.w
		  : count == 5 ? soil.many.x : count == 6 ? soil.many.y : count == 7 ? soil.many.z : soil.many.w;
	uint share, low;
	umulExtended(uint(sum), part, share, low);
	shed_out = starts && count > 0 && height != STILL ? to | min(int(share), SLIDE_MOST) : 0;
}
