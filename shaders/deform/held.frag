#version 450 core
// Marks the posts of a block that an object rests on as held. One fragment for each post that lies both in the object's window
// and in the block's square.

#include "lib/int64.glsl"
#include "lib/window.glsl"

layout(binding = 0, r32i) readonly uniform iimage2DArray rests;
layout(binding = 1, r32i) readonly uniform iimage2DArray bases;
layout(binding = 2, r32i) readonly uniform iimage2DArray offsets;

layout(std140, binding = 0) uniform params {
	ivec4 zero;   // lo, hi: the window's zero height, fixed-point units from the store's reference; layers of the window and of the atlas
	ivec4 window; // place of its first post in the atlas
};

layout(location = 0) out uint contact_out;

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	ivec3 at = ivec3(post, zero.w);
	int base = imageLoad(bases, at).r, offset = imageLoad(offsets, at).r;
	int rest = imageLoad(rests, ivec3(post - window.xy, zero.z)).r;
	i64 ground = i64_sub(i64_shl(i64_from(base), 2), i64(zero.y, uint(zero.x)));
	// The object does not rest on soil above its lower envelope, which lies against its side. Such soil goes on sliding.
	i64 above = i64_sub(i64_add(ground, i64_from(offset)), i64_from(rest));
	bool held = base != BASE_NODATA && rest != UNDER_NONE && !i64_less(above, i64_from(-TOUCH)) &&
		    !i64_less(i64_from(TOUCH), above);
	if (!held)
		discard; // another object may hold the post
	contact_out = HELD;
}
