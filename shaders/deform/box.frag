#version 450 core
// Redistribution `box`: a post takes the mean offset of its neighbourhood if the object has left a post in it. The object has
// left a post that the contact lowered and that its end pose does not hold. One fragment for each post of the window.
// Defines:
// - RADIUS
// - BATCH: parts of the windows of a batch. Posts are counted from the first of the layer
// - STORE: with BATCH: writes the tiles, not the layer
// - REGION: writes the tile of a fixed region, not the layer

#include "lib/window.glsl"

layout(binding = 0, r32i) readonly restrict uniform iimage2DArray offsets;
layout(binding = 1, r8ui) readonly restrict uniform uimage2DArray contacts;

#ifdef BATCH
#include "lib/part.glsl"

ivec4 window = passed[2]; // the window's posts: first, one behind the last
const int layer = 0;
#else
layout(std140, binding = 0) uniform params {
	ivec4 given; // posts in x and y; the layer
#ifdef REGION
	ivec4 region;  // x, y: from a post in the window to that in the tile
	ivec4 reached; // posts that the contact writes: first, one behind the last
#endif
};
ivec4 window = ivec4(0, 0, given.xy);
int layer = given.z;
#endif

#ifdef REGION
layout(binding = 2, r32i) writeonly restrict uniform iimage2D tile;
#elif defined STORE
layout(binding = 2, r32i) writeonly restrict uniform iimage2DArray tiles;
#else
layout(location = 0) out int offset_out;
#endif

// a / b rounded down, and the rest; a < 2^24, 0 < b <= 81. A float holds `a` exactly, so the guess is wrong by one at most. A processor
// has no division of several whole numbers at once.
uint divided(uint a, uint b, out uint rest)
{
	uint guess = uint(float(a) / float(b));
	int over = int(a - guess * b);
	int by = over < 0 ? -1 : over >= int(b) ? 1 : 0;
	rest = uint(over - by * int(b));
	return uint(int(guess) + by);
}

int smooth_at(ivec2 post)
{
	ivec2 low = max(post - RADIUS, window.xy), high = min(post + RADIUS, window.zw - 1);
	// The sum of up to 81 offsets exceeds 32 bits, so high and low halves are summed apart. Offsets are counted from the
	// lowest possible one, since GLSL does not define the division of negative numbers.
	uint high_sum = 0u, low_sum = 0u, left = 0u, count = 0u, own = 0u;
	int now = imageLoad(offsets, ivec3(post, layer)).r;
	// This loop has a known length, so that it is unrolled.
	for (int y = -RADIUS; y <= RADIUS; y++)
		for (int x = -RADIUS; x <= RADIUS; x++) {
			ivec2 there = post + ivec2(x, y);
#ifdef STORE
			const bool inside = true; // a window has as many posts around those that it writes
#else
			bool inside = all(greaterThanEqual(there, low)) && all(lessThanEqual(there, high));
#endif
			uint contact = inside ? imageLoad(contacts, ivec3(there, layer)).r : NO_GROUND;
			own = x == 0 && y == 0 ? contact : own;
			left |= contact & ~(contact >> 1) & LOWERED; // LOWERED, and not HELD
			count += (contact & NO_GROUND) == 0u ? 1u : 0u;
#if RADIUS == 1
			bool counts = (contact & NO_GROUND) == 0u;
			uint offset = counts ? uint(imageLoad(offsets, ivec3(there, layer)).r) ^ 0x80000000u : 0u;
			high_sum += offset >> 16;
			low_sum += offset & 0xffffu;
#endif
		}
	if (left == 0u || (own & (HELD | NO_GROUND)) != 0u)
		return now;
#if RADIUS > 1
	// This one ends at once if it has nothing to do in a whole block of posts.
	for (int y = low.y; y <= high.y; y++)
		for (int x = low.x; x <= high.x; x++) {
			if ((imageLoad(contacts, ivec3(x, y, layer)).r & NO_GROUND) != 0u)
				continue;
			uint offset = uint(imageLoad(offsets, ivec3(x, y, layer)).r) ^ 0x80000000u;
			high_sum += offset >> 16;
			low_sum += offset & 0xffffu;
		}
#endif
	// floor((sum + count / 2) / count), sum = high_sum * 2^16 + low_sum.
	uint rest, unused;
	uint quotient = divided(high_sum, count, rest);
	uint mean = (quotient << 16) + divided((rest << 16) + low_sum + count / 2u, count, unused);
	return int(mean ^ 0x80000000u);
}

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
#ifdef REGION
	int offset = smooth_at(post);
	if (all(greaterThanEqual(post, reached.xy)) && all(lessThan(post, reached.zw)))
		imageStore(tile, post + region.xy, ivec4(offset));
#elif defined STORE
	if (in_part(post))
		imageStore(tiles, ivec3(post + tile.xy, tile.w), ivec4(smooth_at(post)));
#else
	offset_out = smooth_at(post);
#endif
}
