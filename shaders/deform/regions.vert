#version 450 core
// Draws rectangles of posts in the atlas, in one draw: four vertices for each.
// Defines:
// - BY_CELLS: draws only cells near marked ones (steep.frag)
// - OF_BLOCKS: with BY_CELLS: only those of blocks

#include "lib/squares.glsl"
#include "lib/cells.glsl"

layout(std140, binding = 0) uniform regions {
	ivec4 squares[SQUARES];   // the first post (x, y); posts in x (low 16 bits) and in y; of a block: index of its word in the flags
	ivec4 parameters[PASSED]; // BY_CELLS: the last of the first: how many cells away a mark counts
};

#define ATLAS_POSTS 256.0 /* DEFORM_WINDOW_POSTS */

#ifdef BY_CELLS
layout(binding = 0) uniform usampler2D marks;
#endif

flat out ivec3 block; // x, y: the first post of a block; z: number of the block
flat out ivec4 passed[PASSED]; // the parameters, for the fragment shader: passed.vert says why

void main()
{
	int quad = gl_VertexID >> 2;
	passed = parameters;
#ifdef BY_CELLS
#ifdef OF_BLOCKS
	ivec4 square = squares[quad >> 2];
	ivec2 first = square.xy + CELL * ivec2(quad & 1, quad >> 1 & 1);
	block = square.xyw;
#else
	ivec2 first = CELL * ivec2(quad % CELLS_ACROSS, quad / CELLS_ACROSS);
	block = ivec3(first, 0);
#endif
	int near = parameters[0].w;
	uint mark = 0u;
	for (int y = -near; y <= near; y++)
		for (int x = -near; x <= near; x++)
			mark |= texelFetch(marks, clamp(first / CELL + ivec2(x, y), ivec2(0), ivec2(CELLS_ACROSS - 1)), 0).r;
	ivec2 posts = ivec2(CELL * int(mark));
#else
	ivec4 square = squares[quad];
	ivec2 first = square.xy, posts = ivec2(square.z & 0xffff, square.z >> 16);
	block = square.xyw;
#endif
	ivec2 corner = ivec2(gl_VertexID & 1, gl_VertexID >> 1 & 1);
	gl_Position = vec4(vec2(first + corner * posts) * (2.0 / ATLAS_POSTS) - 1.0, 0.0, 1.0);
}
