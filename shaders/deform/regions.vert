#version 450 core
// One instance for each block: its square of posts in the atlas, without the border that later passes do not need.

#ifndef PASSED
#define PASSED 1
#endif
layout(std140, binding = 0) uniform regions {
	ivec4 parameters[PASSED]; // the first: posts along a square's side; squares in a row; posts cut off along each side; the first block
};

#define ATLAS_POSTS 256.0 /* DEFORM_WINDOW_POSTS */

flat out ivec3 block; // x, y: the first post that is drawn; z: number of the block
flat out ivec4 passed[PASSED]; // the parameters, for the fragment shader: passed.vert says why

void main()
{
	ivec4 squares = parameters[0];
	passed = parameters;
	ivec2 square = ivec2(gl_InstanceID % squares.y, gl_InstanceID / squares.y);
	ivec2 first = square * squares.x + squares.z, corner = ivec2(gl_VertexID & 1, gl_VertexID >> 1);
	block = ivec3(first, squares.w + gl_InstanceID);
	gl_Position = vec4(vec2(first + corner * (squares.x - 2 * squares.z)) * (2.0 / ATLAS_POSTS) - 1.0, 0.0, 1.0);
}
