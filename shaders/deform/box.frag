#version 450 core
// Redistribution `box`: a post takes the mean offset of its neighbourhood if the object has left a post in it. The object has
// left a post that the contact lowered and that its end pose does not hold. One fragment for each post of the window.
// Define: RADIUS.

#include "lib/window.glsl"

layout(binding = 0) uniform isampler2DArray bases;
layout(binding = 1) uniform isampler2DArray offsets;
layout(binding = 2) uniform usampler2DArray contacts;

layout(std140, binding = 0) uniform params {
	ivec4 window; // posts in x and y; the layer
};

layout(location = 0) out int offset_out;

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	ivec2 low = max(post - RADIUS, ivec2(0)), high = min(post + RADIUS, window.xy - 1);
	offset_out = texelFetch(offsets, ivec3(post, window.z), 0).r;
	if (texelFetch(bases, ivec3(post, window.z), 0).r == BASE_NODATA ||
	    (texelFetch(contacts, ivec3(post, window.z), 0).r & HELD) != 0u)
		return;
	bool left = false;
	for (int y = low.y; y <= high.y; y++)
		for (int x = low.x; x <= high.x; x++)
			left = left || (texelFetch(contacts, ivec3(x, y, window.z), 0).r & (LOWERED | HELD)) == LOWERED;
	if (!left)
		return;
	// The sum of up to 81 offsets exceeds 32 bits, so high and low halves are summed apart. Offsets are counted from the
	// lowest possible one, since GLSL does not define the division of negative numbers.
	uint count = 0u, high_sum = 0u, low_sum = 0u;
	for (int y = low.y; y <= high.y; y++)
		for (int x = low.x; x <= high.x; x++) {
			if (texelFetch(bases, ivec3(x, y, window.z), 0).r == BASE_NODATA)
				continue;
			uint offset = uint(texelFetch(offsets, ivec3(x, y, window.z), 0).r) ^ 0x80000000u;
			count++;
			high_sum += offset >> 16;
			low_sum += offset & 0xffffu;
		}
	// floor((sum + count / 2) / count), sum = high_sum * 2^16 + low_sum.
	uint quotient = high_sum / count, rest = high_sum % count;
	uint mean = (quotient << 16) + ((rest << 16) + low_sum + count / 2u) / count;
	offset_out = int(mean ^ 0x80000000u);
}
