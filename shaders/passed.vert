#version 450 core
// As full.vert. It also passes the first parameters on to the fragments. A software rasteriser fetches a parameter anew for every pixel,
// but what a triangle's corners have in common only once.
// Define: PASSED: how many parameters, of 16 bytes each; at most 14.

layout(std140, binding = 0) uniform params {
	ivec4 parameters[PASSED];
};

flat out ivec4 passed[PASSED];

void main()
{
	vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
	passed = parameters;
	gl_Position = vec4(corner * 4.0 - 1.0, 0.0, 1.0);
}
