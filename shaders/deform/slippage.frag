#version 450 core
// Granular soil under an object: all displaced soil is carried to the posts around. One fragment for each post of the window.
// Define: CONTACT.

#include "lib/contact.glsl"

layout(location = 0) out int offset_out;
layout(location = 1) out uint contact_out;
layout(location = 2) out int carried_out;

void main()
{
	contact_result p = contact_at(ivec2(gl_FragCoord.xy));
	offset_out = p.offset;
	contact_out = p.contact;
	carried_out = contact_carry(p, 1u << 31);
}
