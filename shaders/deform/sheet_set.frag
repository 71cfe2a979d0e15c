#version 450 core
// An elastic sheet, last pass: offsets and what the plane `floor` keeps, by the deflections that were found. One invocation for 16 posts of a row.

#include "lib/sheet.glsl"
#include "lib/tally.glsl"

layout(binding = 0, r32i) readonly restrict uniform iimage2DArray bents;
layout(binding = 1, r32i) readonly restrict uniform iimage2DArray holders;
layout(binding = 2, r8ui) readonly restrict uniform uimage2DArray contacts;
layout(binding = 3, r32i) readonly restrict uniform iimage2DArray before; // offsets
layout(binding = 4, r32i) restrict uniform iimage2DArray surfaces;        // becomes offsets
layout(binding = 5, r32i) writeonly restrict uniform iimage2DArray floors;

const int ABREAST = 16; // src/deform/soil/sheet.c

void main()
{
	ivec2 fragment = ivec2(gl_FragCoord.xy);
	int y = written.y + fragment.y, first = written.x + ABREAST * fragment.x;
	i64 fell = i64(0, 0u);
	for (int x = first; x < min(first + ABREAST, written.z); x++) {
		ivec3 at = ivec3(x, y, zero.z);
		if ((imageLoad(contacts, at).r & NO_GROUND) != 0u)
			continue;
		uint holder = uint(imageLoad(holders, at).r);
		int deflection = (imageLoad(bents, at).r + (1 << (SHEET_BITS - 1))) >> SHEET_BITS, offset = imageLoad(surfaces, at).r - deflection;
		bool held = holder >> 29 == OF_OTHERS || (holder & DEPTH_MASK) != 0u;
		fell = i64_add(fell, i64_sub(i64_from(imageLoad(before, at).r), i64_from(offset)));
		imageStore(surfaces, at, ivec4(offset));
		imageStore(floors, at, ivec4(2 * deflection + int(held)));
	}
	if (fell.hi != 0 || fell.lo != 0u)
		tally_sum(COMPACTED, uvec2(fell.lo, uint(fell.hi)));
}
