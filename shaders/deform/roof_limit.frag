#version 450 core
// Takes laid soil away that has no room below a body at rest. It is compacted. One fragment for each post of the window.

#include "lib/tally.glsl"
#include "lib/roofs.glsl"

layout(binding = 0, r32i) restrict uniform iimage2DArray deposits;
layout(binding = 2, r32i) readonly restrict uniform iimage2DArray offsets;

layout(std140, binding = 0) uniform params {
	ivec4 window; // posts in x and y; the layer
};

void main()
{
	ivec3 at = ivec3(ivec2(gl_FragCoord.xy), window.z);
	int highest = imageLoad(roofs, at).r;
	uint fits = uint(max(highest - imageLoad(offsets, at).r, 0)), has = uint(imageLoad(deposits, at).r);
	if (highest == ROOF_NONE || has <= fits)
		return;
	imageStore(deposits, at, ivec4(int(fits)));
	tally_add(COMPACTED, has - fits);
}
