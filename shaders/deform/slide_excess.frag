#version 450 core
// Sliding by what a difference of heights exceeds one that stands: once, between each post and its
// eight neighbours. One fragment a post.
// Defines: BOUNDED: only loose soil slides; SOILS: classes of soil that the parameters hold; LAST: back to
// offsets; HEAPED: and the heaped soil has moved along.

#include "lib/slide.glsl"

layout(binding = 0, r32i) readonly uniform iimage2DArray heights;
#ifdef BOUNDED
layout(binding = 1, r32i) readonly uniform iimage2DArray floors;
#endif
#if SOILS > 1
layout(binding = 2, r8ui) readonly uniform uimage2DArray classes;
#endif
#ifdef LAST
layout(binding = 3, r32i) readonly uniform iimage2DArray bases;
layout(binding = 4, r32i) readonly uniform iimage2DArray offsets; // before
layout(binding = 5, r8ui) readonly uniform uimage2DArray stills;
#ifdef HEAPED
layout(binding = 6, r32i) readonly uniform iimage2DArray heaps; // before
#endif
#endif

layout(std140, binding = 0) uniform params {
	ivec4 place;         // the layer
	ivec4 stands[SOILS]; // difference of heights that stands: axial, diagonal
};

#ifdef LAST
layout(location = 0) out int offset_out;
#ifdef HEAPED
layout(location = 1) out int heap_out;
#endif
#else
layout(location = 0) out int height_out;
#endif

ivec2 stands_at(ivec3 at)
{
#if SOILS > 1
	return stands[min(int(imageLoad(classes, at).r), SOILS - 1)].xy;
#else
	return stands[0].xy;
#endif
}

void main()
{
	ivec3 at = ivec3(ivec2(gl_FragCoord.xy), place.x);
	int height = imageLoad(heights, at).r;
	ivec2 stand = stands_at(at);
#ifdef BOUNDED
	int loose = max(0, height - imageLoad(floors, at).r) >> 3;
#endif
	int change = 0;
	for (int k = 0; k < 8; k++) {
		ivec3 there = at + ivec3(SLIDE_NEAR[k], 0);
		int other = imageLoad(heights, there).r;
		int difference = height - other, high = abs(difference);
		bool gives = difference > 0;
#if SOILS > 1
		ivec2 both = gives ? stand : stands_at(there);
#else
		ivec2 both = stand;
#endif
		int amount = min(min((high - (k < 4 ? both.x : both.y) + 7) >> 3, high >> 3), SLIDE_MOST);
#ifdef BOUNDED
		amount = min(amount, gives ? loose : max(0, other - imageLoad(floors, there).r) >> 3);
#endif
		amount = other == STILL ? 0 : max(amount, 0);
		change += gives ? -amount : amount;
	}
	if (height != STILL)
		height += change;
#ifdef LAST
	int before = imageLoad(offsets, at).r;
	bool still = imageLoad(stills, at).r != 0u;
	int offset = still ? before : int(uint(height) - uint(imageLoad(bases, at).r) * 4u);
	offset_out = offset;
#ifdef HEAPED
	heap_out = imageLoad(heaps, at).r + (offset - before);
#endif
#else
	height_out = height;
#endif
}
