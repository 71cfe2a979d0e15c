// What slides between two posts, whatever the rule: the difference of their heights.

#include "lib/window.glsl"

// An offset beyond these gives no more, or takes no more: eight neighbours at SLIDE_MOST each cannot
// take it out of its range then.
const int SLIDE_MOST = 1 << 24;
const int SLIDE_LOW = -OFFSET_LIMIT + (1 << 27), SLIDE_HIGH = OFFSET_LIMIT - (1 << 27);

// a - b, clamped: exactly odd, so that both ends of a pair know what passes between them.
int slide_minus(int a, int b, int most)
{
	int d = a - b;
	bool wrapped = ((a ^ b) & (a ^ d)) < 0;
	return wrapped ? (a < 0 ? -most : most) : clamp(d, -most, most);
}

// Of the surfaces, quanta: within 3/2 of OFFSET_LIMIT.
int slide_difference(int base_a, int offset_a, int base_b, int offset_b)
{
	return slide_minus(base_a, base_b, 1 << 27) * 4 + slide_minus(offset_a, offset_b, OFFSET_LIMIT);
}

const ivec2 SLIDE_NEAR[8] = ivec2[8](ivec2(0, -1), ivec2(-1, 0), ivec2(1, 0), ivec2(0, 1), ivec2(-1, -1),
				     ivec2(1, -1), ivec2(-1, 1), ivec2(1, 1)); // four axial, four diagonal; k and 7 - k
