#version 450 core
// Which posts of a block an object rests on. One fragment a post of what the object's window and the
// block's square share. Define: LOAD: where the object stands was found when it last pressed.

#include "lib/int64.glsl"
#include "lib/window.glsl"

layout(binding = 0, r32i) readonly uniform iimage2DArray rests;
layout(binding = 1, r32i) readonly uniform iimage2DArray bases;
layout(binding = 2, r32i) readonly uniform iimage2DArray offsets;

layout(std140, binding = 0) uniform params {
	ivec4 zero;   // lo, hi: the window's zero height, fixed-point units from the store's reference; the window's layer, the atlas'
	ivec4 window; // where its first post lies in the atlas; LOAD: whose load it is, from 0
};

#ifdef LOAD
layout(std430, binding = 0) restrict readonly buffer standings {
	int standing[]; // scm.frag's
};
#endif

layout(location = 0) out uint contact_out;

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	ivec3 at = ivec3(post, zero.w);
	int base = imageLoad(bases, at).r, offset = imageLoad(offsets, at).r;
	int rest = imageLoad(rests, ivec3(post - window.xy, zero.z)).r;
	i64 ground = i64_sub(i64_shl(i64_from(base), 2), i64(zero.y, uint(zero.x)));
#ifdef LOAD
	ground = i64_sub(ground, i64_from(standing[window.z]));
#endif
	// Soil that was laid or slid up into the object's side is not what it rests on: it goes on sliding.
	i64 above = i64_sub(i64_add(ground, i64_from(offset)), i64_from(rest));
	bool held = base != BASE_NODATA && rest != UNDER_NONE && !i64_less(above, i64_from(-TOUCH)) &&
		    !i64_less(i64_from(TOUCH), above);
	if (!held)
		discard; // what another object holds stays held
	contact_out = HELD;
}
