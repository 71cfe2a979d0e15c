#version 450 core
// An elastic sheet: half a round of over-relaxation (soil/kinematic/sheet_relax.c). Posts of one colour move, and read those of the other. So they are
// written in place. One fragment for two posts of a row that may change.

#include "lib/sheet.glsl"

layout(binding = 0, r32i) restrict uniform iimage2DArray bents;
layout(binding = 1, r32i) readonly restrict uniform iimage2DArray holders;

uint bent(int x, int y)
{
	bool inside = x >= 0 && y >= 0 && x < window.x && y < window.y;
	return inside ? uint(imageLoad(bents, ivec3(x, y, zero.z)).r) : 0u;
}

void main()
{
	ivec2 fragment = ivec2(gl_FragCoord.xy);
	int y = written.y + fragment.y, first = written.x + 2 * fragment.x, x = first + ((first + y + window.w) & 1);
	if (x >= written.z)
		return;
	ivec3 at = ivec3(x, y, zero.z);
	uint holder = uint(imageLoad(holders, at).r), around = holder >> 29;
	if (around == 0u || around > MOVES_LAST)
		return;
	uint own = bent(x, y), sum = bent(x - 1, y) + bent(x + 1, y) + bent(x, y - 1) + bent(x, y + 1), high, low;
	uint weight = around == 1u ? law.x : around == 2u ? relax.x : around == 3u ? relax.y : around == 4u ? relax.z : relax.w;
	umulExtended(weight, sum, high, low);
	i64 given = i64(int(high), low);
	umulExtended(law.y, own, high, low);
	given = i64_add(i64_sub(given, i64(int(high), low)), i64(0, 1u << 30));
	int wanted = int(uint(given.hi) << 1 | given.lo >> 31); // it fits: the weights of the neighbours are less than 2^32 together
	imageStore(bents, at, ivec4(max(min(wanted, DEFLECTION_MOST), int(holder & DEPTH_MASK))));
}
