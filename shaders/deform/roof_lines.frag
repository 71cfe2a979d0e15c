#version 450 core
// Lines do not know roofs. So posts below a roof are still while soil slides along lines. One fragment for each post of the window.
// Define: OPENS: ends that

#include "lib/slide.glsl"
#include "lib/roofs.glsl"

layout(binding = 0, r32i) restrict uniform iimage2DArray heights;
layout(binding = 2, r32i) restrict uniform iimage2DArray waits; // heights of posts below a roof
layout(binding = 3, r32i) readonly restrict uniform iimage2DArray bases;

layout(std140, binding = 0) uniform params {
	ivec4 window; // posts in x and y; the layer
};

const int NEAR_ROOF = 1 << 29; // fixed-point units: a higher roof does not count

void main()
{
	ivec3 at = ivec3(ivec2(gl_FragCoord.xy), window.z);
	int highest = imageLoad(roofs, at).r;
	if (highest == ROOF_NONE)
		return;
#ifdef OPENS
	int height = imageLoad(waits, at).r;
#else
	int height = imageLoad(heights, at).r;
	imageStore(waits, at, ivec4(height));
#endif
	int room = int(uint(imageLoad(bases, at).r) * 4u + uint(highest) - uint(height));
	if (height != STILL && room < NEAR_ROOF)
#ifdef OPENS
		imageStore(heights, at, ivec4(height));
#else
		imageStore(heights, at, ivec4(STILL));
#endif
}
