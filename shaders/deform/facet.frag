#version 450 core
// The lowest height of a facet above a post, during the contact and at its end. The image keeps the minimum of all facets.
// Define: REST: the end pose is needed too.

#include "lib/facet.glsl"

layout(std140, binding = 0) uniform params {
	ivec4 window; // xy: the window's size in posts; z: its layer in the images; w is not used
};

layout(binding = 0, r32i) uniform iimage2DArray under;
#ifdef REST
layout(binding = 1, r32i) uniform iimage2DArray rest;
#endif

layout(location = 0) flat in facet f;

void main()
{
	ivec3 at = ivec3(ivec2(gl_FragCoord.xy), window.z);
	ivec2 post = at.xy - f.base.xy, place = post << 16;
	i64 height = affine(f.plane, post);
	int plane_shift = int(uint(f.cover.w) >> 24) - 64;
	// The facet is above the post after the last edge that enters has passed, and before the first edge that leaves.
	bool inside[3] = bool[3](left_of(f.corners.xy, f.corners.zw, place), left_of(f.corners.zw, f.third.xy, place),
				 left_of(f.third.xy, f.corners.xy, place));
	int first = 0, last = ONE, comes = -1, goes = -1; // times; the edges that enter and leave then
	bool swept = true;
	for (int k = 0; k < 3; k++) {
		int kind = (f.cover.z >> (2 + 2 * k)) & 3;
		int when = fraction_of(affine(f.edges[k], post), ((f.cover.w >> (8 * k)) & 255) - 64);
		bool later = kind == EDGE_ENTERS && when > first, sooner = kind == EDGE_LEAVES && when < last;
		first = later ? when : first;
		comes = later ? k : comes;
		last = sooner ? when : last;
		goes = sooner ? k : goes;
		swept = swept && (kind != 0 || inside[k]);
	}
	if (swept && first <= last) {
		// Its height changes linearly with time. So the lowest is at one of the two times.
		bool later = f.base.z < 0;
		int edge = later ? goes : comes;
		i64 change = later ? i64_sar(i64_mul(ONE, f.base.z), (f.cover.z >> 8) & 63) : i64_from(0);
		int v = fraction_of(i64_add(height, change), plane_shift);
		if (edge >= 0)
			v = fraction_of(affine(f.sides[edge], post), ((f.cover.z >> (14 + 6 * edge)) & 63) - 32);
		v = clamp(v, f.third.z - max(f.base.w, 0), f.third.w + max(-f.base.w, 0));
		imageAtomicMin(under, at, v);
	}
	if ((f.cover.z & 1) != 0 && inside[0] && inside[1] && inside[2]) {
		int v = clamp(fraction_of(height, plane_shift), f.third.z, f.third.w);
		imageAtomicMin(under, at, v);
#ifdef REST
		imageAtomicMin(rest, at, v);
#endif
	}
}
