#version 450 core
// Displaced soil goes to the nearest free posts of its row and its column. One fragment for each written post of the window.
// There is no attachment.

#include "lib/tally.glsl"
#include "lib/window.glsl"

layout(binding = 0, r8ui) readonly uniform uimage2DArray contacts;
layout(binding = 1, r32i) readonly uniform iimage2DArray carries;
layout(binding = 2, r32i) uniform iimage2DArray deposits;

layout(std140, binding = 0) uniform params {
	ivec4 place;   // the layer
	ivec4 written; // the posts this window writes: first, one behind the last
};

const ivec2 WAYS[4] = ivec2[4](ivec2(0, -1), ivec2(-1, 0), ivec2(1, 0), ivec2(0, 1));

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	int amount = imageLoad(carries, ivec3(post, place.x)).r;
	bvec4 found = bvec4(false);
	bool goes_on = amount > 0;
	int far = 0;
	while (goes_on) {
		far++;
		bool within = false;
		for (int way = 0; way < 4; way++) {
			ivec2 p = post + far * WAYS[way];
			bool inside = all(greaterThanEqual(p, written.xy)) && all(lessThan(p, written.zw));
			ivec3 at = ivec3(clamp(p, written.xy, written.zw - 1), place.x);
			within = within || inside;
			found[way] = inside && imageLoad(contacts, at).r == 0u;
		}
		goes_on = within && !any(found);
	}
	if (amount <= 0)
		return;
	if (!any(found)) {
		tally_add(COMPACTED, uint(amount));
		tally_add(CONFINED, 1u);
		return;
	}
	int ways = int(found.x) + int(found.y) + int(found.z) + int(found.w);
	uint third, low;
	umulExtended(uint(amount), 0x55555556u, third, low); // exact below 2^31
	int each = ways == 1 ? amount : ways == 2 ? amount >> 1 : ways == 3 ? int(third) : amount >> 2;
	int rest = amount - ways * each;
	for (int way = 0; way < 4; way++)
		if (found[way]) {
			imageAtomicAdd(deposits, ivec3(post + far * WAYS[way], place.x), each + rest);
			rest = 0;
		}
}
