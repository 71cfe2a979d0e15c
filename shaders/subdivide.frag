#version 450 core
// Technique 4: a tile of a level below zero, interpolated from the patch of level-0 posts it lies in.
// One fragment a post. The same as lattice_subdivide().

#include "lib/lattice.glsl"

layout(binding = 0) uniform isampler2D patch_posts;

layout(std140, binding = 0) uniform params {
	uvec2 sub;   // the tile's first post within the patch's first cell, in 2^-shift of a cell
	uint stride; // posts along a side of the patch
	int shift;
};

layout(location = 0) out int base;

void main()
{
	uvec2 at = sub + uvec2(gl_FragCoord.xy);
	uvec2 cell = at >> shift;
	uvec2 f = at & uvec2((1u << shift) - 1u);
	// The last row and column of posts belong to the last cell.
	for (int i = 0; i < 2; i++) {
		if (cell[i] == stride - 1u) {
			cell[i]--;
			f[i] = 1u << shift;
		}
	}
	ivec2 p = ivec2(cell);
	base = lattice_interpolate(texelFetch(patch_posts, p, 0).r,
				   texelFetch(patch_posts, p + ivec2(1, 0), 0).r,
				   texelFetch(patch_posts, p + ivec2(0, 1), 0).r,
				   texelFetch(patch_posts, p + ivec2(1, 1), 0).r, f, shift);
}
