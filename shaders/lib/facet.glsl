// A facet: a triangle in straight motion over the posts of a window. src/soil/shape/facet.c computes the numbers, all of them
// integers. Each facet has its own post, near it. Places are in 2^-16 posts from that post. Heights are in fixed-point units from the
// window's zero. Times are in 2^-28 of the motion, counted back from its end.
//
// Affine numbers change by the same amount from each post to the next. Four integers hold such a number. x and y: the low and the
// high half of its 64-bit value at the facet's own post. z: its change for one post to the east. w: for one post to the north.

#include "lib/int64.glsl"

struct facet {
	ivec4 corners; // places of two corners at the end of the motion: x, y of the first; x, y of the second
	ivec4 third;   // x, y: place of the third corner, counter-clockwise after the two; z, w: the lowest and the highest of the three heights
	// x and y: the columns and rows of the window over which the triangle ever is. Low 16 bits: the first. High 16 bits: one behind
	// the last.
	// z: bit 0: the triangle rests at the end. From bit 2 on: kinds of the three edges, two bits each. From bit 8 on: binary shift of
	// base.z. From bit 14 on: shifts of `sides` + 32, six bits each.
	// w: shifts of `edges` and of `plane` + 64, a byte each.
	ivec4 cover;
	ivec4 base;    // x, y: the facet's own post in the window; z: change of height over the motion, counted back; w: its rise
	ivec4 plane;   // affine: height of the triangle's plane at the end
	ivec4 edges[3]; // affine: time at which an edge passes over a post
	ivec4 sides[3]; // affine: height of the edge at that time
};

layout(std430, binding = 0) readonly buffer facet_list {
	facet facets[];
};

// Kinds of edges, with time counted back: when the edge passes over a post, the triangle comes over the post, or leaves it.
const int EDGE_ENTERS = 1, EDGE_LEAVES = 2;
const int ONE = 1 << 28; // time of the whole motion

// Returns the value of an affine number at a post, given from the facet's own post.
i64 affine(ivec4 words, ivec2 post)
{
	return i64_add(i64(words.y, uint(words.x)), i64_add(i64_mul(words.z, post.x), i64_mul(words.w, post.y)));
}

// Returns v >> shift (or v << -shift), limited to -2^30 .. 2^30.
int fraction_of(i64 v, int shift)
{
	v = i64_sar(i64_shl(v, max(-shift, 0)), max(shift, 0));
	return i64_to_int(i64_clamp(v, i64_from(-(1 << 30)), i64_from(1 << 30)));
}

// Returns true if the place is on the left of the edge, or on it.
bool left_of(ivec2 from, ivec2 to, ivec2 place)
{
	ivec2 edge = to - from, way = place - from;
	return !i64_less(i64_mul(edge.x, way.y), i64_mul(edge.y, way.x));
}
