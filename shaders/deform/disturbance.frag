#version 450 core
// The disturbance plane: how much the soil was disturbed, kept beside the offset. One fragment for each post.

layout(binding = 0) uniform isampler2DArray offsets;
layout(binding = 1) uniform usampler2DArray contacts;
layout(binding = 2) uniform usampler2DArray disturbances;

layout(std140, binding = 0) uniform params {
	ivec4 window; // posts in x and y; the layer
};

layout(location = 0) out uint disturbance_out;

void main()
{
	ivec3 post = ivec3(ivec2(gl_FragCoord.xy), window.z);
	disturbance_out = texelFetch(disturbances, post, 0).r;
	if ((texelFetch(contacts, post, 0).r & 1u) == 0u)
		return;
	int depth = max(0, -texelFetch(offsets, post, 0).r);
	disturbance_out = max(disturbance_out, uint(min(255, 96 + (depth >> 10))));
}
