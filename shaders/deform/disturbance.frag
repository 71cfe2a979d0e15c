#version 450 core
// The disturbance plane: how much the soil was disturbed, kept beside the offset. One fragment for each post.
// Defines: BATCH: parts of the windows of a batch; REGION: a fixed region. Offset and disturbance are then those of the tiles

#ifdef BATCH
#include "lib/part.glsl"

layout(binding = 0, r32i) readonly restrict uniform iimage2DArray offsets;
layout(binding = 1, r8ui) readonly restrict uniform uimage2DArray contacts;
layout(binding = 2, r8ui) restrict uniform uimage2DArray disturbances;
#elif defined REGION
layout(binding = 0, r32i) readonly restrict uniform iimage2D offsets;
layout(binding = 1, r8ui) readonly restrict uniform uimage2DArray contacts;
layout(binding = 2, r8ui) restrict uniform uimage2D disturbances;

layout(std140, binding = 0) uniform params {
	ivec4 region;  // x, y: from a post in the window to that in the tile
	ivec4 reached; // posts that the contact writes: first, one behind the last
};
#else
layout(binding = 0) uniform isampler2DArray offsets;
layout(binding = 1) uniform usampler2DArray contacts;
layout(binding = 2) uniform usampler2DArray disturbances;

layout(std140, binding = 0) uniform params {
	ivec4 window; // posts in x and y; the layer
};

layout(location = 0) out uint disturbance_out;
#endif

uint disturbed(uint before, uint contact, int offset)
{
	uint depth = uint(min(255, 96 + (max(0, -offset) >> 10)));
	return (contact & 1u) == 0u ? before : max(before, depth);
}

#ifdef BATCH
void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	if (!in_part(post))
		return;
	ivec3 there = ivec3(post + tile.xy, tile.w);
	uint before = imageLoad(disturbances, there).r;
	uint after = disturbed(before, imageLoad(contacts, ivec3(post, 0)).r, imageLoad(offsets, there).r);
	imageStore(disturbances, there, uvec4(after));
}
#elif defined REGION
void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy), there = post + region.xy;
	uint before = imageLoad(disturbances, there).r;
	uint after = disturbed(before, imageLoad(contacts, ivec3(post, 0)).r, imageLoad(offsets, there).r);
	if (all(greaterThanEqual(post, reached.xy)) && all(lessThan(post, reached.zw)))
		imageStore(disturbances, there, uvec4(after));
}
#else
void main()
{
	ivec3 post = ivec3(ivec2(gl_FragCoord.xy), window.z);
	disturbance_out = disturbed(texelFetch(disturbances, post, 0).r, texelFetch(contacts, post, 0).r, texelFetch(offsets, post, 0).r);
}
#endif
