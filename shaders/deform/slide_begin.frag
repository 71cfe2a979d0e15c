#version 450 core
// The first pass of relaxation. It computes the heights with which the iterations begin. They include the soil that a contact deposited.
// One fragment for each post.
//
// Defines, each present or absent:
// - BLOCKS: over active blocks. Over a window: only posts near what the contact reached; soil that it deposited counts, and the last
//   iteration adds it to offsets
// - BOUNDED: only soil down to a depth below the base relaxes, so a floor is written too
// - STEEP: neighbouring posts may differ in height by 1536 m and more
// - HELD_STILL: posts on which an object rests do not relax

#include "lib/slide.glsl"
#include "lib/tally.glsl"

layout(binding = 0, r32i) readonly uniform iimage2DArray bases;
layout(binding = 1, r32i) readonly uniform iimage2DArray offsets;
layout(binding = 2, r8ui) readonly uniform uimage2DArray contacts;

flat in ivec4 passed[PASSED]; // the parameters, from the vertex shader: passed.vert says why. The first is not read
ivec4 place = passed[1];   // x: layer of the images; y: depth of relaxing soil below the base, fixed-point units
ivec4 written = passed[2]; // posts that exchange soil: the first (x, y), one behind the last (z, w)

#ifndef BLOCKS
layout(binding = 3, r32i) readonly uniform iimage2DArray deposits;
#endif

layout(location = 0) out int height_out;
layout(location = 1) out uint still_out;
#ifdef BOUNDED
layout(location = 2) out int floor_out;
#endif

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	ivec3 at = ivec3(post, place.x);
	int base = imageLoad(bases, at).r;
	int offset = imageLoad(offsets, at).r;
	bool ours = all(greaterThanEqual(post, written.xy)) && all(lessThan(post, written.zw));
	uint contact = imageLoad(contacts, at).r;
	bool still = !ours || base == BASE_NODATA || (contact & CLOSED) != 0u;
	uint marks = ours && (contact & HELD) != 0u ? IS_HELD : 0u;
#ifdef HELD_STILL
	still = still || (contact & HELD) != 0u;
#endif
#ifndef BLOCKS
	uint deposit = ours ? uint(imageLoad(deposits, at).r) : 0u;
	uint room = room_at(offset);
	if (deposit > room) {
		tally_add(COMPACTED, deposit - room);
		tally_add(REFUSED, 1u);
		deposit = room;
	}
	marks |= ours && (deposit != 0u || (contact & LOWERED) != 0u) ? IS_DISTURBED : 0u;
	offset += int(deposit);
	if (!still && (offset < SLIDE_LOW || offset > SLIDE_HIGH))
		tally_add(REFUSED, 1u);
#endif
	still = still || offset < SLIDE_LOW || offset > SLIDE_HIGH;
#ifdef STEEP
	for (int k = 0; k < 8; k++) {
		ivec3 there = ivec3(post + SLIDE_NEAR[k], place.x);
		int other = imageLoad(bases, there).r, other_offset = imageLoad(offsets, there).r;
#ifndef BLOCKS
		other_offset = int(min(uint(max(SLIDE_HIGH - other_offset, 0)), uint(imageLoad(deposits, there).r))) + other_offset;
#endif
		int apart = base - other;
		bool wrapped = ((base ^ other) & (base ^ apart)) < 0 || abs(apart) > 1 << 30;
		still = still || (other != BASE_NODATA && (wrapped || abs(apart + ((offset - other_offset) >> 2)) >= SLIDE_APART));
	}
#endif
	height_out = still ? STILL : int(uint(base) * 4u + uint(offset));
	still_out = marks | (still ? IS_STILL : 0u);
#ifdef BOUNDED
	floor_out = int(uint(base) * 4u - uint(place.y));
#endif
}
