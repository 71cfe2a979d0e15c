#version 450 core
// Sliding by what a difference of heights exceeds one that stands: once, between each post and its
// eight neighbours. One fragment a post.
// Defines: FIRST: the deposits are laid down too; HEAPED: the heaped soil moves along; BOUNDED: only loose
// soil slides; SOILS: classes of soil that the parameters hold.

#include "lib/slide.glsl"
#include "lib/tally.glsl"

layout(binding = 0) uniform isampler2DArray bases;
layout(binding = 1) uniform isampler2DArray offsets;
layout(binding = 2) uniform usampler2DArray contacts;
#ifdef FIRST
layout(binding = 3) uniform isampler2DArray deposits;
#endif
#ifdef HEAPED
layout(binding = 4) uniform isampler2DArray heaps;
#endif
#if SOILS > 1
layout(binding = 5) uniform usampler2DArray classes;
#endif

layout(std140, binding = 0) uniform params {
	ivec4 place;         // the layer; loose soil below the base, quanta
	ivec4 written;       // the posts that exchange: first, one behind the last
	ivec4 stands[SOILS]; // difference of heights that stands: axial, diagonal
};

layout(location = 0) out int offset_out;
#ifdef HEAPED
layout(location = 1) out int heap_out;
#endif

struct ground {
	int base, offset, heap; // heap: what counts as loose, from the base
	ivec2 stands;
	bool still; // held, a hole, or not ours
};

ground ground_at(ivec2 post)
{
	ground g;
	ivec3 at = ivec3(post, place.x);
	g.base = texelFetch(bases, at, 0).r;
	g.offset = texelFetch(offsets, at, 0).r;
#ifdef HEAPED
	g.heap = texelFetch(heaps, at, 0).r;
#else
	g.heap = g.offset;
#endif
#if SOILS > 1
	g.stands = stands[min(int(texelFetch(classes, at, 0).r), SOILS - 1)].xy;
#else
	g.stands = stands[0].xy;
#endif
	g.still = g.base == BASE_NODATA || (texelFetch(contacts, at, 0).r & HELD) != 0u;
	return g;
}

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	ground a = ground_at(post);
	int change = 0;
	uint refused = 0u;
	for (int k = 0; k < 8; k++) {
		ivec2 p = post + SLIDE_NEAR[k];
		bool inside = all(greaterThanEqual(p, written.xy)) && all(lessThan(p, written.zw));
		ground b = ground_at(clamp(p, written.xy, written.zw - 1));
		int difference = slide_difference(a.base, a.offset, b.base, b.offset);
		bool gives = difference > 0;
		ivec2 both = gives ? a.stands : b.stands;
		int high = abs(difference), stand = k < 4 ? both.x : both.y;
		int amount = clamp(min((high - stand + 7) >> 3, high >> 3), 0, SLIDE_MOST);
#ifdef BOUNDED
		amount = min(amount, max(0, (gives ? a.heap : b.heap) + place.y) >> 3);
#endif
		amount = inside && !a.still && !b.still ? amount : 0;
		bool refuse = min(gives ? a.offset : b.offset, gives ? a.heap : b.heap) < SLIDE_LOW ||
			      max(gives ? b.offset : a.offset, gives ? b.heap : a.heap) > SLIDE_HIGH;
		refused += uint(refuse && gives && amount > 0);
		amount = refuse ? 0 : amount;
		change += gives ? -amount : amount;
	}
	if (refused > 0u)
		tally_add(REFUSED, refused);
#ifdef FIRST
	uint deposit = uint(texelFetch(deposits, ivec3(post, place.x), 0).r);
	uint room = uint(max(0, SLIDE_HIGH - max(a.offset, a.heap)));
	if (deposit > room) {
		tally_add(COMPACTED, deposit - room);
		tally_add(REFUSED, 1u);
		deposit = room;
	}
	change += int(deposit);
#endif
	offset_out = a.offset + change;
#ifdef HEAPED
	heap_out = a.heap + change;
#endif
}
