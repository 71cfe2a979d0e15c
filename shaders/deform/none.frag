#version 450 core
// Pure compaction: displaced soil is lost. One fragment for each post of the window.
// Defines:
// - CONTACT
// - REGION: writes the tile of a fixed region. KEPT: reads that tile, and writes the window's layer

#ifdef REGION
#define CONTACT_MORE ivec4 region, reached;
#endif
#include "lib/contact.glsl"

#if defined REGION && !defined KEPT
#ifdef CONTACT
layout(binding = 4, r8ui) writeonly restrict uniform uimage2DArray contacts;
#endif

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	contact_result p = contact_at(post);
#ifdef CONTACT
	imageStore(contacts, ivec3(post, zero.z), uvec4(p.contact));
#endif
	if (all(greaterThanEqual(post, reached.xy)) && all(lessThan(post, reached.zw)))
		imageStore(offsets, post + region.xy, ivec4(p.offset));
}
#else
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
#endif
