#version 450 core
// Marks the cells of the atlas in which soil may slide in this interval. There two neighbours differ in height by more than the least
// critical difference of any soil and slope. It also marks those in which heights of slopes are kept. Later passes draw only cells near marked ones. One fragment for each post. The target has
// no attachment.

#include "lib/slide.glsl"
#include "lib/cells.glsl"

layout(binding = 0, r32i) readonly uniform iimage2DArray bases;
layout(binding = 1, r8ui) writeonly uniform uimage2D cells;
layout(binding = 2, r32i) readonly uniform iimage2DArray offsets;
layout(binding = 3, r32i) readonly uniform iimage2DArray kept; // as slope.frag left it in the interval before

flat in ivec4 passed[PASSED]; // the parameters, from the vertex shader: passed.vert says why
ivec4 place = passed[0]; // the layer; least critical differences: axial, diagonal
ivec4 reach = passed[1]; // how far around a steep post cells are marked; a step by which none of them is left out; the last step's end

const ivec2 AFTER[4] = ivec2[4](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(-1, 1)); // each pair of neighbours once

int surface_at(ivec3 at)
{
	int base = imageLoad(bases, at).r;
	return base == BASE_NODATA ? STILL : int(uint(base) * 4u + uint(imageLoad(offsets, at).r));
}

void main()
{
	ivec3 at = ivec3(ivec2(gl_FragCoord.xy), place.x);
	int height = surface_at(at);
	bool steep = false;
	for (int k = 0; k < 4; k++) {
		int other = surface_at(at + ivec3(AFTER[k], 0));
		steep = steep || (other != STILL && abs(height - other) > (k < 2 ? place.y : place.z));
	}
	steep = (steep && height != STILL) || imageLoad(kept, at).r != 0;
	// Where no post is steep, a loop ends at once.
	for (int y = steep ? -reach.x : reach.z; y <= reach.z; y += reach.y)
		for (int x = steep ? -reach.x : reach.z; x <= reach.z && steep; x += reach.y)
			imageStore(cells, clamp((at.xy + ivec2(x, y)) / CELL, ivec2(0), ivec2(CELLS_ACROSS - 1)), uvec4(1u));
}
