// Sliding computes with heights, 4 base + offset, in 32 bits that wrap. Only differences between neighbours matter. Neighbours too
// far apart in height for 32 bits do not slide (slide_begin.frag).

#include "lib/window.glsl"

const int STILL = int(0x80000000u); // a height: the post gives no soil and takes none
// Bits of a post in `stills`.
const uint IS_STILL = 1u, IS_HELD = 2u;
const uint IS_DISTURBED = 8u; // a contact changed the post before sliding
const int SLIDE_MOST = 1 << 22;     // most soil that two posts exchange in an iteration, fixed-point units
const int POOLED_MOST = 1 << 22;    // the same along a line
// Posts with offsets beyond these do not slide. So eight iterations with eight neighbours, and eight walks along lines, cannot exceed
// an offset's range.
const int SLIDE_LOW = -OFFSET_LIMIT + (9 << 25), SLIDE_HIGH = OFFSET_LIMIT - (9 << 25);

// Returns how much soil can be deposited on a post, fixed-point units.
uint room_at(int offset)
{
	return uint(max(0, SLIDE_HIGH - offset));
}

// Largest difference between neighbours, 2^-18 m (1536 m). So eight iterations cannot exceed 32 bits.
const int SLIDE_APART = 3 << 27;

const ivec2 SLIDE_NEAR[8] = ivec2[8](ivec2(0, -1), ivec2(-1, 0), ivec2(1, 0), ivec2(0, 1), ivec2(-1, -1),
				     ivec2(1, -1), ivec2(-1, 1), ivec2(1, 1)); // four axial, four diagonal

#if defined(STOOD) || defined(LAST) || defined(ROOFS)
layout(binding = 7, r32i) readonly uniform iimage2DArray grounds; // bases
#endif

#ifdef STOOD
// Returns by how much a difference of heights exceeds the difference of the undisturbed ground.
int risen(int difference, int base, ivec3 there)
{
	return int(uint(difference) - uint(base - imageLoad(grounds, there).r) * 4u);
}
#endif
