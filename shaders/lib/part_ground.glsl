// The ground of a part, read from its tile.

#include "lib/part.glsl"

layout(binding = 0, r32i) readonly restrict uniform iimage2DArray bases;
layout(binding = 1, r32i) readonly restrict uniform iimage2DArray offsets;

int part_base(ivec2 post)
{
	int base = imageLoad(bases, ivec3(post + tile.xy, max(tile.z, 0))).r;
	return tile.z < 0 ? BASE_NODATA : base;
}

int part_offset(ivec2 post)
{
	int offset = imageLoad(offsets, ivec3(post + tile.xy, max(tile.w, 0))).r;
	return tile.w < 0 ? 0 : offset;
}
