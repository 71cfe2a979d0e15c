#version 450 core
// Computes for each post of a block how far its slope rises above it and falls below it (slopes.c). Each pass follows slopes by one
// hop: to a post that is higher, or lower, by more than the angle of friction gives. One fragment for each post.
// Defines:
// - FIRST: the first hop, which computes the heights too
// - LAST: the last hop, which writes critical differences
// - SOILS: number of soil classes in the parameters

#include "lib/slide.glsl"
#include "lib/squares.glsl"

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

flat in ivec4 passed[PASSED]; // the parameters, from the vertex shader: passed.vert says why
ivec4 place = passed[0]; // the layer; posts of this hop; LAST: the spacing, 2^-20 m, with as many binary digits as the cotangents

#if SOILS > 1 || defined LAST
layout(std140, binding = 0) uniform params {
	SQUARES_FIRST
	ivec4 others;
	ivec4 rises[SOILS]; // a hop must rise or fall by more than this: axial, diagonal; fixed-point units
#ifdef LAST
	ivec4 cotangents[27 * SOILS]; // of the steepest stable angle of each soil, for SLOPE_HEIGHTS rising heights of slopes (slopes.c)
#endif
};
#endif

// Extents in 2^-9 m: how far the slope rises above the post (low 16 bits) and falls below it (high 16 bits). The last hop
// writes instead how much two axial neighbours in this slope may differ in height, fixed-point units.
layout(location = 0) out int extent_out;
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

#ifdef LAST
int known(int soil, int i)
{
	return cotangents[27 * soil + (i >> 2)][i & 3];
}

// Returns the axial critical difference in a slope, fixed-point units. height: of the slope, 2^-9 m. The cotangent is interpolated
// between the two nearest known heights.
int in_slope(int soil, int height)
{
	height = clamp(height, 16, 0x1ffff);
	int octave = findMSB(height), digits = height << (17 - octave);
	int i = (octave - 4) * 8 + ((digits >> 14) & 7), low = known(soil, i);
	int cotangent = low + ((known(soil, i + 1) - low) * ((digits >> 6) & 255) >> 8);
	return cotangent > 0 ? min(place.z / cotangent, 1 << 30) : 1 << 30;
}
#endif

void main()
{
	ivec3 at = ivec3(ivec2(gl_FragCoord.xy), place.x);
#if SOILS > 1
	int soil = min(int(imageLoad(classes, at).r), SOILS - 1);
	ivec2 rise = rises[soil].xy;
#else
	const int soil = 0;
	ivec2 rise = passed[1].xy;
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
#ifdef LAST
	extent_out = in_slope(soil, most.x + most.y);
#else
	extent_out = int(uint(most.x) | uint(most.y) << 16);
#endif
#ifdef FIRST
	surface_out = surface;
#endif
}
