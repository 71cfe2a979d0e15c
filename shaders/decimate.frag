#version 450 core
// Copies a finer tile's offsets (and other drawn planes) to a coarser tile: every 2^steps-th post, without a filter.
// Defines: DISTURBANCE: the tiles have a disturbance plane. MARKS: how many planes of marks that fade they have, 1 to 3.

layout(binding = 0) uniform isampler2D fine_offset;
#ifdef DISTURBANCE
layout(binding = 1) uniform usampler2D fine_disturbance;
#define FIRST_MARK 2
#else
#define FIRST_MARK 1
#endif
#ifdef MARKS
layout(binding = 2) uniform isampler2D fine_marks[MARKS];
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
#ifdef MARKS
layout(location = FIRST_MARK) out int marks[MARKS];
#endif

void main()
{
	ivec2 p = from + ((ivec2(gl_FragCoord.xy) - to) << steps);
	offset = texelFetch(fine_offset, p, 0).r;
#ifdef DISTURBANCE
	disturbance = texelFetch(fine_disturbance, p, 0).r;
#endif
#ifdef MARKS
	for (int i = 0; i < MARKS; i++)
		marks[i] = texelFetch(fine_marks[i], p, 0).r;
#endif
}
