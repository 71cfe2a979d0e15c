#version 450 core
// Writes the offsets of a batch to the tiles. One fragment for each post of a part.

#include "lib/part.glsl"

layout(binding = 0, r32i) readonly restrict uniform iimage2DArray offsets;
layout(binding = 2, r32i) writeonly restrict uniform iimage2DArray tiles;

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	if (in_part(post))
		imageStore(tiles, ivec3(post + tile.xy, tile.w), imageLoad(offsets, ivec3(post, 0)));
}
