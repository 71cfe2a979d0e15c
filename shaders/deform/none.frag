#version 450 core
// Pure compaction: displaced soil is lost. One fragment for each post of the window. Define: CONTACT.

#include "lib/contact.glsl"

layout(location = 0) out int offset_out;
#ifdef CONTACT
layout(location = 1) out uint contact_out;
#endif

void main()
{
	contact_result p = contact_at(ivec2(gl_FragCoord.xy));
#ifdef CONTACT
	contact_out = p.contact;
#endif
	offset_out = p.offset;
}
