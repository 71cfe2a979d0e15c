#version 450 core
// An elastic sheet: tells which posts move: those within the reach of held ones, along x and y, by what sheet_rows.frag marked. Others that may change
// are not deflected. One invocation for each column of posts that may change.

#include "lib/sheet.glsl"
#include "lib/rows.glsl"

layout(binding = 0, r32i) readonly restrict uniform iimage2DArray marks;
layout(binding = 1, r32i) restrict uniform iimage2DArray aboves; // of a column, posts that have a marked one below
layout(binding = 2, r32i) restrict uniform iimage2DArray holders;
layout(binding = 3, r32i) writeonly restrict uniform iimage2DArray bents;
layout(binding = 4, r8ui) readonly restrict uniform uimage2DArray contacts;

bool is_marked(int x, int y)
{
	return imageLoad(marks, ivec3(x, y, zero.z)).r != 0;
}

uint ground_at(ivec2 post)
{
	bool inside = all(greaterThanEqual(post, ivec2(0))) && all(lessThan(post, window.xy));
	return inside && (imageLoad(contacts, ivec3(post, zero.z)).r & NO_GROUND) == 0u ? 1u : 0u;
}

void decide(ivec3 at, bool near)
{
	uint holder = uint(imageLoad(holders, at).r);
	if ((imageLoad(contacts, at).r & NO_GROUND) != 0u || holder >> 29 == OF_OTHERS)
		return;
	uint around = ground_at(at.xy - ivec2(1, 0)) + ground_at(at.xy + ivec2(1, 0)) + ground_at(at.xy - ivec2(0, 1)) + ground_at(at.xy + ivec2(0, 1));
	if (near)
		imageStore(holders, at, ivec4(int((holder & DEPTH_MASK) | (around + 1u) << 29)));
	else
		imageStore(bents, at, ivec4(0));
}

void main()
{
	int x = row_of_pass(written.x), left = 0, reach = window.z;
	if (x >= written.z)
		return;
	for (int y = 0; y < written.w; y++) {
		left = is_marked(x, y) ? reach + 1 : max(left - 1, 0);
		if (y >= written.y)
			imageStore(aboves, ivec3(x, y, zero.z), ivec4(left > 0));
	}
	left = 0;
	for (int y = window.y - 1; y >= written.y; y--) {
		left = is_marked(x, y) ? reach + 1 : max(left - 1, 0);
		if (y < written.w)
			decide(ivec3(x, y, zero.z), left > 0 || imageLoad(aboves, ivec3(x, y, zero.z)).r != 0);
	}
}
