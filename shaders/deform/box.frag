#version 450 core
// Redistribution `box`: a post takes the mean offset of its neighbourhood if the object has left a post in it. The object has
// left a post that the contact lowered and that its end pose does not hold. One fragment for each post of the window.
// Defines:
// - RADIUS
// - BATCH: the windows of a batch. Posts are counted from the first of the layer

#include "lib/window.glsl"

layout(binding = 0, r32i) readonly restrict uniform iimage2DArray offsets;
layout(binding = 1, r8ui) readonly restrict uniform uimage2DArray contacts;

#ifdef BATCH
flat in ivec4 passed[PASSED];
ivec4 window = passed[0]; // the window's posts: first, one behind the last
const int layer = 0;
#else
layout(std140, binding = 0) uniform params {
	ivec4 given; // posts in x and y; the layer
};
ivec4 window = ivec4(0, 0, given.xy);
int layer = given.z;
#endif

layout(location = 0) out int offset_out;

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

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	ivec2 low = max(post - RADIUS, window.xy), high = min(post + RADIUS, window.zw - 1);
	offset_out = imageLoad(offsets, ivec3(post, layer)).r;
	// This loop has a known length, so that it is unrolled. The next one ends at once if it has nothing to do in a whole block of posts.
	uint left = 0u, count = 0u, own = 0u;
	for (int y = -RADIUS; y <= RADIUS; y++)
		for (int x = -RADIUS; x <= RADIUS; x++) {
			ivec2 there = post + ivec2(x, y);
			bool inside = all(greaterThanEqual(there, low)) && all(lessThanEqual(there, high));
			uint contact = inside ? imageLoad(contacts, ivec3(there, layer)).r : NO_GROUND;
			own = x == 0 && y == 0 ? contact : own;
			left |= contact & ~(contact >> 1) & LOWERED; // LOWERED, and not HELD
			count += (contact & NO_GROUND) == 0u ? 1u : 0u;
		}
	if (left == 0u || (own & (HELD | NO_GROUND)) != 0u)
		return;
	// The sum of up to 81 offsets exceeds 32 bits, so high and low halves are summed apart. Offsets are counted from the
	// lowest possible one, since GLSL does not define the division of negative numbers.
	uint high_sum = 0u, low_sum = 0u;
	for (int y = low.y; y <= high.y; y++)
		for (int x = low.x; x <= high.x; x++) {
			if ((imageLoad(contacts, ivec3(x, y, layer)).r & NO_GROUND) != 0u)
				continue;
			uint offset = uint(imageLoad(offsets, ivec3(x, y, layer)).r) ^ 0x80000000u;
			high_sum += offset >> 16;
			low_sum += offset & 0xffffu;
		}
	// floor((sum + count / 2) / count), sum = high_sum * 2^16 + low_sum.
	uint rest, unused;
	uint quotient = divided(high_sum, count, rest);
	uint mean = (quotient << 16) + divided((rest << 16) + low_sum + count / 2u, count, unused);
	offset_out = int(mean ^ 0x80000000u);
}
