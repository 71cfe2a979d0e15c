#version 450 core
// Computes for each post of a block how far its slope rises above it and falls below it (slopes.c). Each pass follows slopes by one
// hop: to a post that is higher, or lower, by more than the angle of friction gives. One fragment for each post.
// Defines:
// - FIRST: the first hop, which computes the heights too
// - LAST: the last hop, which writes critical differences
// - STOOD: with LAST: undisturbed ground is stable, however steep
// - SOILS: number of soil classes in the parameters

#include "lib/slide.glsl"
#include "lib/squares.glsl"

#ifdef FIRST
layout(binding = 0, r32i) readonly uniform iimage2DArray bases;
layout(binding = 1, r32i) readonly uniform iimage2DArray offsets;
layout(binding = 3, r32i) readonly uniform iimage2DArray kept; // extents, as the interval before left them
#else
layout(binding = 0, r32i) readonly uniform iimage2DArray surfaces;
layout(binding = 1, r32i) readonly uniform iimage2DArray extents; // after the hops before
#endif
#if SOILS > 1
layout(binding = 2, r8ui) readonly uniform uimage2DArray classes;
#endif
#ifdef LAST
layout(binding = 3, r32i) restrict uniform iimage2DArray kept;
#ifdef STOOD
layout(binding = 4, r32i) readonly uniform iimage2DArray bases;
#endif
#endif

flat in ivec4 passed[PASSED]; // the parameters, from the vertex shader: passed.vert says why
ivec4 place = passed[0]; // the layer; posts of this hop; LAST: the spacing, 2^-20 m, with as many binary digits as the cotangents

#if SOILS > 1 || defined LAST
layout(std140, binding = 0) uniform params {
	SQUARES_FIRST
	ivec4 others;
	// A hop must rise or fall by more than this: axial, diagonal; fixed-point units. The first: also the least differences that slide in any slope.
	ivec4 rises[SOILS];
#ifdef LAST
	ivec4 cotangents[27 * SOILS]; // of the steepest stable angle of each soil, for SLOPE_HEIGHTS rising heights of slopes (slopes.c)
#endif
};
#endif

// Extents in 2^-9 m: how far the slope rises above the post (low 16 bits) and falls below it (high 16 bits). The last hop
// writes instead how much two axial neighbours in this slope may differ in height, fixed-point units. Its sign bit: extents that are kept changed.
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
	uint extent = uint(imageLoad(kept, at).r);
#else
	uint extent = uint(imageLoad(extents, at).r);
#endif
	return ivec2(extent & 0xffffu, extent >> 16);
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

#ifdef LAST
// Returns the size of a difference of two posts; 0: one has no data.
uint apart(int a, int b)
{
	return a == STILL || b == STILL ? 0u : uint(abs(a - b));
}

// Returns the share of a slope's steepness that its steepest pair of posts has, 2^-10 (src/soil/sliding/slopes.c).
int share_of_steepest(ivec3 at)
{
	uint east = apart(surface_at(at + ivec3(1, 0, 0)), surface_at(at - ivec3(1, 0, 0)));
	uint north = apart(surface_at(at + ivec3(0, 1, 0)), surface_at(at - ivec3(0, 1, 0)));
	uint high = max(east, north), low = min(east, north);
	if (high == 0u)
		return 1 << 10;
	int drop = max(findMSB(high) - 20, 0);
	high >>= drop;
	low >>= drop;
	uint axial = (low << 10) / high, diagonal = ((1024u - axial) << 10) / (1024u + axial), least = min(axial, diagonal), square = least * least >> 10;
	return int(1024u - (square >> 1) + (3u * square * square >> 13));
}

// Returns the axial critical difference at a post, fixed-point units.
int limit_at(ivec3 at, int soil, int height)
{
	int limit = in_slope(soil, height), share = share_of_steepest(at);
	return (limit >> 10) * share + ((limit & 1023) * share >> 10);
}

// Returns whether soil could slide between a post and one beside it, if their slope was high enough.
bool could_slide(ivec3 at, int surface)
{
	bool could = false;
	for (int k = 0; k < 8 && surface != STILL; k++) {
		ivec3 there = at + ivec3(SLIDE_NEAR[k], 0);
		int other = surface_at(there), difference = surface - other;
		bool slides = other != STILL && abs(difference) > (k < 4 ? passed[1].z : passed[1].w);
#ifdef STOOD
		int more = int(uint(difference) - uint(imageLoad(bases, at).r - imageLoad(bases, there).r) * 4u);
		slides = slides && (difference > 0 ? more : -more) > 0;
#endif
		could = could || slides;
	}
	return could;
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
#ifdef FIRST
	ivec2 most = ivec2(0); // what was kept counts at the hop's end alone
#else
	ivec2 most = extent_at(at);
#endif
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
	int extent = could_slide(at, surface) ? most.x | most.y << 16 : 0;
	bool changed = extent != imageLoad(kept, at).r;
	if (changed)
		imageStore(kept, at, ivec4(extent));
	extent_out = limit_at(at, soil, most.x + most.y) | (changed ? 0x80000000 : 0);
#else
	extent_out = int(uint(most.x) | uint(most.y) << 16);
#endif
#ifdef FIRST
	surface_out = surface;
#endif
}
