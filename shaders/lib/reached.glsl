// The posts of a window in which soil can slide after a contact (SOIL.md, "Sliding"). They are a rectangle around the posts that the contact
// changed or the object left, and `around` posts on each side.

#include "lib/bias.glsl"

layout(std140, binding = 1) uniform laying_begins {
	uvec4 reached; // of the posts that the contact reached: BIAS + x, BIAS - x, BIAS + y, BIAS - y of the outermost; 0: there are none
};

// Returns them: first, one behind the last. written: the posts that the window writes. around: below 0: all of these.
ivec4 reached_posts(ivec4 written, int around)
{
	if (around < 0 || reached.x == 0u)
		return around < 0 ? written : ivec4(written.xy, written.xy);
	ivec2 first = BIAS - ivec2(reached.yw), last = ivec2(reached.xz) - BIAS;
	return ivec4(max(first - around, written.xy), min(last + 1 + around, written.zw));
}
