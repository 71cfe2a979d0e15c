#version 450 core
// An elastic sheet: marks the posts that have a held one in their row, within the reach. One invocation for each row of the window.

#include "lib/sheet.glsl"
#include "lib/rows.glsl"

layout(binding = 0, r32i) readonly restrict uniform iimage2DArray holders;
layout(binding = 1, r32i) writeonly restrict uniform iimage2DArray marks;

bool is_held(int x, int y)
{
	return uint(imageLoad(holders, ivec3(x, y, zero.z)).r) >> 29 >= OF_OTHERS;
}

void main()
{
	int y = row_of_pass(0), left = 0, reach = window.z;
	if (y >= window.y)
		return;
	for (int x = 0; x < written.z; x++) {
		left = is_held(x, y) ? reach + 1 : max(left - 1, 0);
		if (x >= written.x)
			imageStore(marks, ivec3(x, y, zero.z), ivec4(left > 0));
	}
	left = 0;
	for (int x = window.x - 1; x >= written.x; x--) {
		left = is_held(x, y) ? reach + 1 : max(left - 1, 0);
		if (x < written.z && left > 0)
			imageStore(marks, ivec3(x, y, zero.z), ivec4(1));
	}
}
