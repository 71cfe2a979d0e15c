#version 450 core
// Sumner's soil under an object: a share of the displaced soil is compacted, the rest is carried to the posts around. One
// fragment for each post of the window. Defines: CONTACT; SOILS: number of soil classes in the parameters.

#define CONTACT_MORE uvec4 kept[SOILS]; // in 2^-31: share of the displaced soil that is carried
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
