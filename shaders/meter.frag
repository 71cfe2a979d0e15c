#version 450 core
// Sums the luminance of a frame's light: each pixel of the target sums a cell of it, in a fixed order.

layout(binding = 0) uniform sampler2D light;
layout(std140, binding = 0) uniform params {
	ivec4 size; // xy: pixels of the frame; zw: cells
};
layout(location = 0) out float sum;

#define MOST 4.0 // what is brighter counts as that: the sun's disc

void main()
{
	ivec2 cell = ivec2(gl_FragCoord.xy), from = cell * size.xy / size.zw, end = (cell + 1) * size.xy / size.zw;
	sum = 0.0;
	for (int y = from.y; y < end.y; y++)
		for (int x = from.x; x < end.x; x++)
			sum += clamp(dot(texelFetch(light, ivec2(x, y), 0).rgb, vec3(0.2126, 0.7152, 0.0722)), 0.0, MOST);
}
