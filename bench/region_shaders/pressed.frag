#version 450 core
// The dissertation's displacement: the depth difference between the object and the terrain, kept in an offset map of few bits.
// Define: NORMALISED: the map holds depths as shares of `range`; otherwise metres as floats

layout(binding = 0) uniform sampler2D depths;
layout(binding = 1) uniform sampler2D before;
layout(binding = 2) uniform isampler2D bases; // 2^-18 m

layout(std140, binding = 0) uniform params {
	vec4 scale; // lowest height and range of the depth buffer, range of the offset map, metres
};

layout(location = 0) out float offset_out;

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	float depth = texelFetch(depths, post, 0).r, offset = texelFetch(before, post, 0).r;
	float base = float(texelFetch(bases, post, 0).r) / 262144.0;
#ifdef NORMALISED
	float metres = -offset * scale.z;
#else
	float metres = offset;
#endif
	float wanted = scale.x + (1.0 - depth) * scale.y - base;
	metres = depth > 0.0 ? min(metres, wanted) : metres;
#ifdef NORMALISED
	offset_out = clamp(-metres / scale.z, 0.0, 1.0);
#else
	offset_out = metres;
#endif
}
