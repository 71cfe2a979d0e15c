#version 450 core
// Pure compaction: displaced soil is lost. One fragment for each post of the window.
// Defines:
// - CONTACT
// - REGION: writes the tile of a fixed region. KEPT: writes the offsets to the window's layer instead, since the next pass reads them there

#ifdef REGION
#define CONTACT_MORE ivec4 region;
#endif
#include "lib/contact.glsl"

#ifdef REGION
#ifdef CONTACT
layout(binding = 4, r8ui) writeonly restrict uniform uimage2DArray contacts;
#endif
#ifdef KEPT
layout(binding = 5, r32i) writeonly restrict uniform iimage2DArray kept;
#endif

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	contact_result p = contact_at(post);
#ifdef CONTACT
	imageStore(contacts, ivec3(post, zero.z), uvec4(p.contact));
#endif
#ifdef KEPT
	imageStore(kept, ivec3(post, zero.z), ivec4(p.offset));
#else
	imageStore(offsets, post + region.xy, ivec4(p.offset));
#endif
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
