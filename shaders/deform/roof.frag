#version 450 core
// A body at rest keeps ground out of itself (src/soil/sliding/roofs.h). It marks the posts that the body holds, and notes the highest offset to which
// soil may bring each post below it. A post whose ground is above the whole body has no roof. One fragment for each post that the body may be above.

#include "lib/int64.glsl"
#include "lib/window.glsl"

layout(binding = 0, r32i) readonly restrict uniform iimage2DArray rests;
layout(binding = 1, r32i) readonly restrict uniform iimage2DArray tops; // lower envelope of the body upside down
layout(binding = 2, r32i) readonly restrict uniform iimage2DArray bases;
layout(binding = 3, r32i) readonly restrict uniform iimage2DArray offsets;
layout(binding = 4, r8ui) restrict uniform uimage2DArray contacts;
layout(binding = 5, r32i) restrict uniform iimage2DArray roofs;

layout(std140, binding = 0) uniform params {
	ivec4 zero;  // lo, hi: height of the envelopes' zero, fixed-point units from the store's reference; their layer, and that of the ground
	ivec4 place; // x, y: of the envelopes' first post in the ground's layer. z: soil is not laid where the body leaves less room, fixed-point units
};

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	ivec3 at = ivec3(post, zero.w), there = ivec3(post - place.xy, zero.z);
	int base = imageLoad(bases, at).r, offset = imageLoad(offsets, at).r, rest = imageLoad(rests, there).r, top = imageLoad(tops, there).r;
	if (base == BASE_NODATA || rest == UNDER_NONE)
		return;
	i64 ground = i64_sub(i64_shl(i64_from(base), 2), i64(zero.y, uint(zero.x)));
	i64 surface = i64_add(ground, i64_from(offset)), above = i64_sub(surface, i64_from(rest)), room = i64_sub(i64_from(rest), ground);
	uint before = imageLoad(contacts, at).r, contact = before;
	// The body does not rest on soil above its lower envelope, which lies against its side.
	if (!i64_less(above, i64_from(-TOUCH)) && !i64_less(i64_from(TOUCH), above))
		contact |= HELD;
	bool far = !i64_less(room, i64_from(OFFSET_LIMIT)) || !i64_less(i64_from(-OFFSET_LIMIT), room);
	bool buried = i64_less(i64_from(TOUCH), above) && top != UNDER_NONE && !i64_less(surface, i64_from(-top));
	if (!far && !buried) {
		int highest = min(i64_to_int(room), imageLoad(roofs, at).r);
		imageStore(roofs, at, ivec4(highest));
		contact |= highest - offset < place.z ? CRAMPED : 0u;
	}
	if (contact != before)
		imageStore(contacts, at, uvec4(contact));
}
