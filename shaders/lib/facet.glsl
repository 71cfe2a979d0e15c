// A triangle in straight motion over the posts of a window; whole numbers as src/deform/shape/facet.c makes
// them. Places are in 2^-16 posts from the facet's own post, heights in fixed-point units from the window's zero, times in
// 2^-28 of the motion, counted back from its end.

#include "lib/int64.glsl"

struct facet {
	ivec4 corners; // x, y; x, y: at the end, counter-clockwise
	ivec4 third;   // x, y; the lowest and the highest of the three
	ivec4 cover;   // posts of the window it is ever above, in x and in y: first, one behind the last << 16;
	               // bit 0: rests, two bits an edge from bit 2 on, rate's shift << 8, six bits a side from bit
	               // 14 on: its shift + 32; the shifts of the edges and of the plane + 64, a byte each
	ivec4 base;    // its own post, of the window; how much lower it was at a post at the start; rise of the motion
	ivec4 plane;   // height at the end: lo, hi at its own post; a post east, north
	ivec4 edges[3]; // when an edge passes over a post: the same
	ivec4 sides[3]; // how high it is then: the same
};

layout(std430, binding = 0) readonly buffer facet_list {
	facet facets[];
};

const int EDGE_ENTERS = 1, EDGE_LEAVES = 2;
const int ONE = 1 << 28;

i64 affine(ivec4 words, ivec2 post)
{
	return i64_add(i64(words.y, uint(words.x)), i64_add(i64_mul(words.z, post.x), i64_mul(words.w, post.y)));
}

int fraction_of(i64 v, int shift)
{
	v = i64_sar(i64_shl(v, max(-shift, 0)), max(shift, 0));
	return i64_to_int(i64_clamp(v, i64_from(-(1 << 30)), i64_from(1 << 30)));
}

bool left_of(ivec2 from, ivec2 to, ivec2 place)
{
	ivec2 edge = to - from, way = place - from;
	return !i64_less(i64_mul(edge.x, way.y), i64_mul(edge.y, way.x));
}
