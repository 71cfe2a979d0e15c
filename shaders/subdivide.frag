#version 450 core
// Technique 4: a tile of a level below zero, interpolated from the patch of level-0 posts it lies in.
// One fragment a post. The same as lattice_subdivide().
// RELIEF: adds detail to posts that have data, as relief_heights() does.

#include "lib/lattice.glsl"
#ifdef RELIEF
const int RELIEF_BANDS = 14;
#include "lib/relief.glsl"
#endif

layout(binding = 0) uniform isampler2D patch_posts;

layout(std140, binding = 0) uniform params {
	uvec2 sub;   // the tile's first post within the patch's first cell, in 2^-shift of a cell
	uint stride; // posts along a side of the patch
	int shift;
#ifdef RELIEF
	int count; // of bands, each of the level that follows, the coarsest first
	int down;  // bits from the sum of details to 2^-18 m
	relief_band bands[RELIEF_BANDS];
#endif
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
#ifdef RELIEF
	i64 sum = i64(0, 0u);
	for (int i = count; i-- > 0;)
		sum = relief_add(sum, relief_detail(bands[i], uvec2(gl_FragCoord.xy)));
	sum = i64_add(sum, i64_shl(i64_from(1), down - 1));
	if (base != BASE_NODATA)
		base += i64_to_int(i64_sar(sum, down));
#endif
}
