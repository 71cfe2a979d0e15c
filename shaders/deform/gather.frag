#version 450 core
// Copies the ground below the windows of a batch from the tiles into the layer, before contacts. One fragment for each post of a part.
// Define: CONTACT: also what lib/contact.glsl leaves at a post that nothing touches

#include "lib/window.glsl"
#include "lib/part_ground.glsl"

layout(location = 0) out int offset_out;
#ifdef CONTACT
layout(location = 1) out uint contact_out;
#endif

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	offset_out = part_offset(post);
#ifdef CONTACT
	contact_out = part_base(post) == BASE_NODATA ? NO_GROUND : 0u;
#endif
}
