#version 450 core
// A rectangle around the posts that a facet is ever above, one instance each. What it covers only bounds the work.

#include "lib/facet.glsl"

layout(std140, binding = 0) uniform params {
	ivec4 window; // posts in x and y; the layer
};

layout(location = 0) flat out int number;

void main()
{
	ivec2 cover = facets[gl_InstanceID].cover.xy;
	ivec2 corner = ivec2((gl_VertexID & 1) != 0 ? cover.x >> 16 : cover.x & 0xffff,
			     (gl_VertexID & 2) != 0 ? cover.y >> 16 : cover.y & 0xffff);
	number = gl_InstanceID;
	gl_Position = vec4(vec2(corner) / vec2(window.xy) * 2.0 - 1.0, 0.0, 1.0);
}
