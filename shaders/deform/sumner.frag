#version 450 core
// The contact of the model sumner. The object displaces soil. A share of it is compacted, and the rest is carried to the posts
// around the object. One fragment for each post of the window.
//
// Defines:
// - CONTACT: the pass also finds the posts on which the object rests (lib/contact.glsl)
// - SOILS: number of soil classes that the parameters have room for

#define CONTACT_MORE uvec4 kept[SOILS]; // x: share of the displaced soil that is carried, in 2^-31
#include "lib/contact.glsl"

#if SOILS > 1
layout(binding = 4) uniform usampler2DArray classes;
#endif

layout(location = 0) out int offset_out;
layout(location = 1) out uint contact_out;
layout(location = 2) out int carried_out;

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	contact_result p = contact_at(post);
	offset_out = p.offset;
	contact_out = p.contact;
#if SOILS > 1
	carried_out = contact_carry(p, kept[min(int(texelFetch(classes, ivec3(post, zero.z), 0).r), SOILS - 1)].x);
#else
	carried_out = contact_carry(p, kept[0].x);
#endif
}
