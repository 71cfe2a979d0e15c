#version 450 core
// One instance for each facet: a rectangle around the posts that it is ever above. For a few posts it is one triangle around the
// rectangle, which is faster. Posts that are drawn needlessly do no harm.

#include "lib/facet.glsl"

layout(std140, binding = 0) uniform params {
	ivec4 window; // posts in x and y; the layer
};

const int FEW = 2;

layout(location = 0) flat out facet f;

void main()
{
	ivec2 cover = facets[gl_InstanceID].cover.xy, low = cover & 0xffff, size = (cover >> 16) - low;
	ivec2 corner = ivec2(gl_VertexID & 1, gl_VertexID >> 1);
	corner = size.x <= FEW && size.y <= FEW ? low + size * 2 * (gl_VertexID < 3 ? corner : ivec2(0, 1)) : low + size * corner;
	f = facets[gl_InstanceID];
	gl_Position = vec4(vec2(corner) / vec2(window.xy) * 2.0 - 1.0, 0.0, 1.0);
}
