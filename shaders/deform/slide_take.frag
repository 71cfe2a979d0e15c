#version 450 core
// Sumner's erosion: what was shed arrives. One fragment a post.
// Defines: LAST: back to offsets; FLAGS: and where something changed, over blocks.

#include "lib/slide.glsl"
#include "lib/slid.glsl"

layout(binding = 0, r32i) readonly uniform iimage2DArray heights;
layout(binding = 1, r32i) readonly uniform iimage2DArray sheds;

layout(std140, binding = 0) uniform params {
	ivec4 region; // regions.vert's
	ivec4 place;  // the layer; near a block's side is within so many posts of it
};

const int SHARE = (1 << 23) - 1;

void main()
{
	ivec3 at = ivec3(ivec2(gl_FragCoord.xy), place.x);
	int shed = imageLoad(sheds, at).r, change = -bitCount(shed >> 23) * (shed & SHARE);
	for (int k = 0; k < 8; k++) {
		int other = imageLoad(sheds, at + ivec3(SLIDE_NEAR[k], 0)).r;
		int back = k < 4 ? 3 - k : 11 - k; // the way from there to here
		change += (other & (1 << (23 + back))) != 0 ? other & SHARE : 0;
	}
	slid(at, imageLoad(heights, at).r, change, place.y);
}
