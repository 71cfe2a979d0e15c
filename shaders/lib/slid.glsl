// The end of an iteration: a height, or with LAST what it means. Defines: LAST, HEAPED, FLAGS.

#ifdef LAST
layout(binding = 3, r32i) readonly uniform iimage2DArray bases;
layout(binding = 4, r32i) readonly uniform iimage2DArray offsets; // before
layout(binding = 5, r8ui) readonly uniform uimage2DArray stills;
layout(location = 0) out int offset_out;
#ifdef HEAPED
layout(binding = 6, r32i) readonly uniform iimage2DArray heaps; // before
layout(location = 1) out int heap_out;
#endif
#else
layout(location = 0) out int height_out;
#endif
#ifdef FLAGS
#include "lib/flags.glsl"
#endif

void slid(ivec3 at, int height, int change, int near)
{
	if (height == STILL)
		change = 0;
	height += change;
#ifdef LAST
	int before = imageLoad(offsets, at).r;
	bool still = imageLoad(stills, at).r != 0u;
	int offset = still ? before : int(uint(height) - uint(imageLoad(bases, at).r) * 4u);
	offset_out = offset;
#ifdef HEAPED
	heap_out = imageLoad(heaps, at).r + (offset - before);
#endif
#else
	height_out = height;
#endif
#ifdef FLAGS
	if (change != 0)
		flag_change(at.xy, near);
#endif
}
