// The end of a relaxation iteration at a post. It writes the new height, or after the last iteration the new offset and the flags of
// its block. Include it after the declaration of the parameters.
// Defines:
// - LAST: this is the last iteration
// - THICKNESS: the deposited thickness is written too
// - FLAGS: the pass computes active blocks; otherwise it computes a window
// - TOUCHED: flags also tell which parts of a block changed
// - WAKES: the height of a slope counts, so a change may set near posts in motion

#ifdef LAST
layout(binding = 3, r32i) readonly uniform iimage2DArray bases;
layout(binding = 4, r32i) readonly uniform iimage2DArray offsets; // before the first iteration
layout(binding = 5, r8ui) readonly uniform uimage2DArray stills;
layout(location = 0) out int offset_out;
#ifdef THICKNESS
layout(binding = 6, r32i) readonly uniform iimage2DArray heaps; // deposited thickness before the first iteration
layout(location = 1) out int heap_out;
#endif
#include "lib/flags.glsl"
#ifdef FLAGS
flat in ivec3 block;
#endif
#else
layout(location = 0) out int height_out;
#endif

// Writes the result. height: before this iteration. change: soil that the post got, less what it gave. moves: the post got or gave
// soil, even if both are equal. steep: if the slope is high enough, the post gives or gets soil.
void slid(ivec3 at, int height, int change, bool moves, bool steep)
{
	if (height == STILL)
		change = 0;
	moves = moves && height != STILL;
	height += change;
#ifdef LAST
	int before = imageLoad(offsets, at).r;
	uint marks = imageLoad(stills, at).r;
	int offset = (marks & IS_STILL) != 0u ? before : int(uint(height) - uint(imageLoad(bases, at).r) * 4u);
	offset_out = offset;
#ifdef THICKNESS
	heap_out = imageLoad(heaps, at).r + (offset - before);
#endif
	// An object that rested on this post may not rest on it any more.
	moves = moves || (marks & MAY_BE_FREED) != 0u || ((marks & IS_HELD) != 0u && offset != before);
#ifdef FLAGS
#ifdef WAKES
	// This interval measured slopes before its first iteration. The next one must measure them again.
	moves = moves || offset != before;
#endif
	if (moves)
		flag_post(at.xy - block.xy, block.z, place.y);
#ifdef TOUCHED
	if (offset != before)
		flag_changed(at.xy - block.xy, block.z);
#endif
#else
	// This window did not compute the posts beyond its rim. So a change on the rim may make soil move there, and flags the block.
	bool rim = any(lessThan(at.xy, edge.xy)) || any(greaterThanEqual(at.xy, edge.zw));
	bool changed = (marks & IS_DISTURBED) != 0u || offset != before;
#ifdef WAKES
	// A contact does not measure slopes. So an interval must do it wherever the ground changed or is steep.
	moves = moves || changed || (steep && height != STILL);
#endif
	ivec2 from_first = at.xy + region.xy;
	ivec2 its_block = from_first >> 5;
	int word = region.w + its_block.y * region.z + its_block.x;
	if (moves || (rim && changed))
		flag_post(from_first & (BLOCK - 1), word, place.y);
#ifdef TOUCHED
	if (changed)
		flag_changed(from_first & (BLOCK - 1), word);
#endif
#endif
#else
	height_out = height;
#endif
}
