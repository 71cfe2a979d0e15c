#version 450 core
// An elastic sheet, first pass: a body lets go of the posts that it held at the end of its last motion. One fragment for each post of the window.

#include "lib/sheet.glsl"

layout(binding = 0) uniform isampler2DArray bases;
layout(binding = 1) uniform isampler2DArray offsets;
layout(binding = 2) uniform isampler2DArray floors;
layout(binding = 3) uniform isampler2DArray rests;

layout(location = 0) out int floor_out;

void main()
{
	ivec3 at = ivec3(ivec2(gl_FragCoord.xy), zero.z);
	int base = texelFetch(bases, at, 0).r, held = texelFetch(floors, at, 0).r, rest = texelFetch(rests, at, 0).r;
	bool may = base != BASE_NODATA && is_written(at.xy) && (held & 1) != 0 && rest != UNDER_NONE;
	i64 depth = depth_below(base, rest, surface_of(texelFetch(offsets, at, 0).r, deflection_of(held)));
	floor_out = may && !i64_less(depth, i64_from(-TOUCH)) ? held & ~1 : held;
}
