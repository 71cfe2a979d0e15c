#version 450 core
// One hop along the slope at each post of a block: how far the slope rises above the post and falls below it (slopes.c). A hop
// leads to a post that is higher, or lower, by more than the angle of friction gives. One fragment for each post.
// Defines:
// - FIRST: the first hop, which computes the heights too
// - SOILS: number of soil classes in the parameters

#include "lib/slide.glsl"

#ifdef FIRST
layout(binding = 0, r32i) readonly uniform iimage2DArray bases;
layout(binding = 1, r32i) readonly uniform iimage2DArray offsets;
#else
layout(binding = 0, r32i) readonly uniform iimage2DArray surfaces;
layout(binding = 1, r32i) readonly uniform iimage2DArray extents; // after the hops before
#endif
#if SOILS > 1
layout(binding = 2, r8ui) readonly uniform uimage2DArray classes;
#endif

layout(std140, binding = 0) uniform params {
	ivec4 region;       // as in regions.vert
	ivec4 place;        // the layer; posts of this hop
	ivec4 rises[SOILS]; // a hop rises or falls by more: axial, diagonal; fixed-point units
};

layout(location = 0) out int extent_out; // in 2^-9 m: low 16 bits above the post, high 16 bits below it
#ifdef FIRST
layout(location = 1) out int surface_out; // 4 base + offset
#endif

int surface_at(ivec3 at)
{
#ifdef FIRST
	int base = imageLoad(bases, at).r;
	return base == BASE_NODATA ? STILL : int(uint(base) * 4u + uint(imageLoad(offsets, at).r));
#else
	return imageLoad(surfaces, at).r;
#endif
}

ivec2 extent_at(ivec3 at)
{
#ifdef FIRST
	return ivec2(0);
#else
	uint extent = uint(imageLoad(extents, at).r);
	return ivec2(extent & 0xffffu, extent >> 16);
#endif
}

void main()
{
	ivec3 at = ivec3(ivec2(gl_FragCoord.xy), place.x);
#if SOILS > 1
	ivec2 rise = rises[min(int(imageLoad(classes, at).r), SOILS - 1)].xy;
#else
	ivec2 rise = rises[0].xy;
#endif
	int surface = surface_at(at);
	ivec2 most = extent_at(at);
	for (int k = 0; k < 8; k++) {
		ivec3 there = at + ivec3(SLIDE_NEAR[k] * place.y, 0);
		int other = surface_at(there), difference = other - surface, least = k < 4 ? rise.x : rise.y;
		ivec2 on = extent_at(there) + (abs(difference) >> 11);
		bool open = surface != STILL && other != STILL;
		most.x = open && difference > least ? max(most.x, on.x) : most.x;
		most.y = open && -difference > least ? max(most.y, on.y) : most.y;
	}
	most = min(most, ivec2(0xffff));
	extent_out = int(uint(most.x) | uint(most.y) << 16);
#ifdef FIRST
	surface_out = surface;
#endif
}
