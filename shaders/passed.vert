#version 450 core
// As full.vert. It also passes the parameters on to the fragments (lib/passed.glsl). Define: PASSED: how many.

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
