#version 450 core
// Pure compaction: where the underside lies below the surface, the surface becomes it. One fragment a
// post of the window. Define: CONTACT.

#include "lib/int64.glsl"
#include "lib/window.glsl"

layout(binding = 0) uniform isampler2DArray bases;
layout(binding = 1) uniform isampler2DArray offsets;
layout(binding = 2) uniform isampler2DArray unders;
#ifdef CONTACT
layout(binding = 3) uniform isampler2DArray rests;
#endif

layout(std140, binding = 0) uniform params {
	ivec4 zero;    // lo, hi: the window's zero height, quanta from the store's reference; the layer
	ivec4 written; // the posts this window writes: first, one behind the last
};

layout(std430, binding = 0) buffer tally {
	uint compacted[2];
	uint refused[2];
};

layout(location = 0) out int offset_out;
#ifdef CONTACT
layout(location = 1) out uint contact_out;
#endif

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	ivec3 at = ivec3(post, zero.z);
	int base = texelFetch(bases, at, 0).r;
	int offset = texelFetch(offsets, at, 0).r;
	int under = texelFetch(unders, at, 0).r;
	uint contact = 0u;
	// The underside as an offset: from the base, in 64 bits, since it may be far away.
	i64 ground = i64_sub(i64_shl(i64_from(base), 2), i64(zero.y, uint(zero.x)));
	i64 wanted = i64_sub(i64_from(under), ground);
	bool touches = base != BASE_NODATA && under != UNDER_NONE && !i64_less(i64_from(offset), wanted);
	if (touches && i64_less(wanted, i64_from(-OFFSET_LIMIT))) {
		// The rim of one window is another's to count.
		if (all(greaterThanEqual(post, written.xy)) && all(lessThan(post, written.zw)))
			atomicAdd(refused[0], 1u);
		touches = false;
	}
	if (touches) {
		offset = i64_to_int(wanted);
		contact = PRESSED;
	}
#ifdef CONTACT
	int rest = texelFetch(rests, at, 0).r;
	if (base != BASE_NODATA && rest != UNDER_NONE &&
	    !i64_less(i64_add(ground, i64_from(offset + TOUCH)), i64_from(rest)))
		contact |= HELD;
	contact_out = contact;
#endif
	offset_out = offset;
}
