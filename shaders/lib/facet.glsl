// A triangle in straight motion over the posts of a window, as whole numbers from src/deform/shape/facet.c. Places are in
// 2^-16 posts from the facet's own post. Heights are in fixed-point units from the window's zero. Times are in 2^-28 of the motion,
// counted back from its end.

#include "lib/int64.glsl"

struct facet {
	ivec4 corners; // two corners at the end: x, y; x, y. The three are counter-clockwise
	ivec4 third;   // the third corner: x, y; the lowest and the highest of the three heights
	// x and y: posts of the window that it is ever above, along each axis: first, one behind the last << 16.
	// z: bit 0: it rests at the end. From bit 2 on: kinds of the edges, two bits each. From bit 8 on: shift of base.z.
	// From bit 14 on: shifts of the sides + 32, six bits each.
	// w: shifts of the three edges and of the plane + 64, a byte each.
	ivec4 cover;
	ivec4 base;    // its own post in the window; change of height over the motion, counted back; rise of the motion
	ivec4 plane;   // height at the end, affine: lo, hi at its own post; change one post east; one post north
	ivec4 edges[3]; // time at which an edge passes over a post, affine as `plane`
	ivec4 sides[3]; // height of the edge at that time, affine as `plane`
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
