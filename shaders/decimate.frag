#version 450 core
// Copies a finer tile's offsets (and disturbance) to a coarser tile: every 2^steps-th post, without a filter.
// DISTURBANCE: the tiles have a disturbance plane.

layout(binding = 0) uniform isampler2D fine_offset;
#ifdef DISTURBANCE
layout(binding = 1) uniform usampler2D fine_disturbance;
#endif

layout(std140, binding = 0) uniform params {
	ivec2 from; // the first fine post read
	ivec2 to;   // the coarse post it goes to
	int steps;
};

layout(location = 0) out int offset;
#ifdef DISTURBANCE
layout(location = 1) out uint disturbance;
#endif

void main()
{
	ivec2 p = from + ((ivec2(gl_FragCoord.xy) - to) << steps);
	offset = texelFetch(fine_offset, p, 0).r;
#ifdef DISTURBANCE
	disturbance = texelFetch(fine_disturbance, p, 0).r;
#endif
}
