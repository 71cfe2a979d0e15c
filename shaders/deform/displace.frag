#version 450 core
// Displacement: where the object's underside lies below the surface, the surface becomes it.
// One fragment a post of the window. Defines: SHAPE_WHEEL, SHAPE_SPHERE or SHAPE_BOX; CONTACT.

#include "lib/underside.glsl"

layout(binding = 0) uniform isampler2DArray bases;
layout(binding = 1) uniform isampler2DArray offsets;

layout(std430, binding = 0) buffer refusals {
	uint refused;
};

layout(location = 0) out int offset_out;
#ifdef CONTACT
layout(location = 1) out uint contact_out;
#endif

const int BASE_NODATA = int(0x80000000u);
const int OFFSET_LIMIT = 1 << 30;
const int TOUCH = 4; // quanta; the sweep and its end are rounded apart

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	int base = texelFetch(bases, ivec3(post, zero.z), 0).r;
	int offset = texelFetch(offsets, ivec3(post, zero.z), 0).r;
	uint contact = 0u;
	int under;
	if (base != BASE_NODATA && underside(0, post, under)) {
		// The underside as an offset: from the base, in 64 bits, since it may be far away.
		i64 ground = i64_sub(i64_shl(i64_from(base), 2), i64(zero.y, uint(zero.x)));
		i64 wanted = i64_sub(i64_from(under), ground);
		bool touches = !i64_less(i64_from(offset), wanted);
		if (touches && i64_less(wanted, i64_from(-OFFSET_LIMIT))) {
			// The rim of one window is another's to count.
			if (all(greaterThanEqual(post, written.xy)) && all(lessThan(post, written.zw)))
				atomicAdd(refused, 1u);
			touches = false;
		}
		if (touches) {
			offset = i64_to_int(wanted);
			contact = 1u;
		}
#ifdef CONTACT
		if (underside(1, post, under) && !i64_less(i64_add(ground, i64_from(offset + TOUCH)), i64_from(under)))
			contact |= 2u;
#endif
	}
	offset_out = offset;
#ifdef CONTACT
	contact_out = contact;
#endif
}
