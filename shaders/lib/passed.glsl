// The parameters of a pass, of 16 bytes each. A software rasteriser fetches a parameter anew for every pixel, but what a triangle's
// corners have in common only once. So the vertex shader passes them on, if they are few.
// Defines: PASSED: how many, at most 14: from passed.vert or regions.vert. Without it PARAMETERS says how many there are.

#ifdef PASSED
flat in ivec4 passed[PASSED];
#else
layout(std140, binding = 0) uniform params {
	ivec4 passed[PARAMETERS];
};
#endif
