// Sliding works on heights, 4 base + offset, in 32 bits that wrap: all that counts are differences of
// neighbours, and those that are too far apart for it (slide_begin.frag) are still.

#include "lib/window.glsl"

const int STILL = int(0x80000000u); // a height: gives nothing and takes nothing
// What `stills` says of a post.
const uint IS_STILL = 1u, IS_HELD = 2u;
const uint MAY_BE_FREED = 4u; // held, but perhaps not by the object as an interval finds it
const uint IS_DISTURBED = 8u; // a contact changed it before it slid
const int SLIDE_MOST = 1 << 22;     // passes between two posts at once, fixed-point units
// Beyond these an offset takes no part: eight iterations with eight neighbours cannot take one out of its range.
const int SLIDE_LOW = -OFFSET_LIMIT + (1 << 28), SLIDE_HIGH = OFFSET_LIMIT - (1 << 28);

// Of neighbours, 2^-18 m (1536 m): eight iterations cannot take their difference out of 32 bits.
const int SLIDE_APART = 3 << 27;

const ivec2 SLIDE_NEAR[8] = ivec2[8](ivec2(0, -1), ivec2(-1, 0), ivec2(1, 0), ivec2(0, 1), ivec2(-1, -1),
				     ivec2(1, -1), ivec2(-1, 1), ivec2(1, 1)); // four axial, four diagonal

#ifdef STOOD
layout(binding = 7, r32i) readonly uniform iimage2DArray grounds; // bases

// By how much the difference of heights to a neighbour exceeds that of the ground as it was.
int risen(int difference, int base, ivec3 there)
{
	return int(uint(difference) - uint(base - imageLoad(grounds, there).r) * 4u);
}
#endif
