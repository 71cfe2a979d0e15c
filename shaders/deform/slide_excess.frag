#version 450 core
// One iteration of sliding between each post and its eight neighbours. The amount depends on how much their difference of
// height exceeds the critical one. One fragment for each post.
// Defines:
// - BOUNDED: relaxing soil has a bottom
// - STOOD: undisturbed ground is stable, however steep
// - SOILS: number of soil classes in the parameters
// - LAST: the last iteration, which writes offsets
// - SLOPES: the critical difference depends on the height of the slope, over blocks
// - ROOFS: bodies at rest keep posts from rising
// - BLOCKS, WAKES: as in slid.glsl

#include "lib/slide.glsl"
#include "lib/squares.glsl"

layout(binding = 0, r32i) readonly uniform iimage2DArray heights;
#ifdef BOUNDED
layout(binding = 1, r32i) readonly uniform iimage2DArray floors;
#endif
#if SOILS > 1
layout(binding = 2, r8ui) readonly uniform uimage2DArray classes;
#endif
#ifdef SLOPES
layout(binding = 6, r32i) readonly uniform iimage2DArray slopes; // by slope.frag: the axial critical difference in each post's slope; sign bit: its height changed
#endif

#include "lib/slide_params.glsl"

// Of a soil: critical difference of heights, axial, diagonal; tolerance; difference that is steeper than the friction angle.
#if SOILS > 1
layout(std140, binding = 0) uniform slopes_of_soils {
	SQUARES_FIRST
	ivec4 others[5];
	ivec4 limits[SOILS];
};

ivec4 limits_of(int soil)
{
	return limits[soil];
}
#else
ivec4 limits_of(int soil)
{
	return passed[5];
}
#endif

#include "lib/slid.glsl"
#ifdef ROOFS
#include "lib/roofs.glsl"
#endif

// Returns the place of a post's soil in the limits.
int soil_at(ivec3 at)
{
#if SOILS > 1
	return min(int(imageLoad(classes, at).r), SOILS - 1);
#else
	return 0;
#endif
}

void main()
{
	ivec3 at = ivec3(ivec2(gl_FragCoord.xy), place.x);
	int height = imageLoad(heights, at).r;
	int own = soil_at(at);
#ifdef BOUNDED
	int loose = max(0, height - imageLoad(floors, at).r) >> 3;
#endif
#ifdef STOOD
	int base = imageLoad(grounds, at).r;
#endif
#ifdef ROOFS
	int own_room = room_below_roof(at, height);
#endif
#ifdef SLOPES
	int slope = imageLoad(slopes, at).r;
#endif
	int change = 0, moves = 0;
	bool steep = false;
	for (int k = 0; k < 8; k++) {
		ivec3 there = at + ivec3(SLIDE_NEAR[k], 0);
		int other = imageLoad(heights, there).r;
		int difference = height - other, high = abs(difference);
		bool gives = difference > 0;
#if SOILS > 1
		int soil = gives ? own : soil_at(there);
#else
		int soil = own;
#endif
		int critical = k < 4 ? limits_of(soil).x : limits_of(soil).y;
#ifdef SLOPES
		// The slope is that of the post that gives. The sum for diagonal neighbours multiplies by sqrt(2), to a ten thousandth.
		int most = max((gives ? slope : imageLoad(slopes, there).r) & 0x7fffffff, region.z);
		critical = min(critical, k < 4 ? most : most + (most >> 2) + (most >> 3) + (most >> 5) + (most >> 7));
#endif
		int over = high - critical;
		int amount = min(min((over + 7) >> 3, high >> 3), SLIDE_MOST);
#ifdef BOUNDED
		amount = min(amount, gives ? loose : max(0, other - imageLoad(floors, there).r) >> 3);
#endif
#ifdef ROOFS
		amount = min(amount, gives ? room_below_roof(there, other) : own_room);
#endif
#ifdef STOOD
		int more = gives ? risen(difference, base, there) : -risen(difference, base, there);
		amount = min(amount, more);
		over = min(over, more);
#endif
		amount = other == STILL || over <= limits_of(0).z ? 0 : max(amount, 0);
#if defined WAKES && !defined SLOPES
		int beyond = high - limits_of(soil).w;
#ifdef STOOD
		beyond = min(beyond, more);
#endif
		steep = steep || (other != STILL && beyond > 0);
#endif
		change += gives ? -amount : amount;
		moves |= amount;
	}
#ifdef SLOPES
	steep = slope < 0;
#endif
	slid(at, height, change, moves != 0, steep);
}
