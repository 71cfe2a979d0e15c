// The end of a relaxation iteration at a post. It writes the new height, or after the last iteration the new offset and the flags of
// its block. Include it after the declaration of the parameters.
// Defines:
// - LAST: this is the last iteration
// - BLOCKS: the pass computes active blocks. Otherwise it computes posts of a window, near what a contact reached, and its last iteration adds
//   the deposited soil
// - TOUCHED: flags also tell which parts of a block changed
// - WAKES: the height of a slope counts, so a change may set near posts in motion

#ifdef LAST
layout(binding = 4, r32i) restrict uniform iimage2DArray offsets; // before the first iteration
layout(binding = 5, r8ui) readonly uniform uimage2DArray stills;
#ifndef BLOCKS
layout(binding = 3, r32i) readonly uniform iimage2DArray deposits; // not yet in the offsets
#else
flat in ivec3 block;
#endif
#include "lib/flags.glsl"
#else
layout(location = 0) out int height_out;
#endif

#ifdef LAST
// Sets the flags of a post. moves: soil may go on moving there. changed: the contact, or this interval, changed the post.
#ifndef BLOCKS
void flag(ivec2 post, bool moves, bool changed)
{
	// Beyond the border no soil slid. So a change at the border may make soil move there, and flags the block.
	bool border = any(lessThan(post, looked.xy)) || any(greaterThanEqual(post, looked.zw));
	ivec2 from_first = post + region.xy;
	int word = region.w + (from_first.y >> 5) * region.z + (from_first.x >> 5);
	if (moves || (border && changed))
		flag_post(from_first & (BLOCK - 1), word, place.y);
#ifdef TOUCHED
	if (changed)
		flag_changed(from_first & (BLOCK - 1), word);
#endif
}
#else
void flag(ivec2 post, bool moves, bool changed)
{
	if (moves)
		flag_post(post - block.xy, block.z, place.y);
#ifdef TOUCHED
	if (changed)
		flag_changed(post - block.xy, block.z);
#endif
}
#endif
#endif

// Writes the result. height: before this iteration. change: soil that the post got, less what it gave. moves: the post got or gave
// soil, even if both are equal. steep: over a window: if the slope is high enough, the post gives or gets soil; over blocks: its slope became higher or
// lower.
void slid(ivec3 at, int height, int change, bool moves, bool steep)
{
	if (height == STILL)
		change = 0;
	moves = moves && height != STILL;
	height += change;
#ifdef LAST
	int before = imageLoad(offsets, at).r, deposit = 0;
	uint marks = imageLoad(stills, at).r;
#ifndef BLOCKS
	deposit = int(min(uint(imageLoad(deposits, at).r), room_at(before)));
#endif
	int offset = (marks & IS_STILL) != 0u ? before + deposit : int(uint(height) - uint(imageLoad(grounds, at).r) * 4u);
	bool slides = offset != before + deposit, changed = slides;
	// An object that rested on this post may not rest on it any more.
	moves = moves || ((marks & IS_HELD) != 0u && slides);
#ifndef BLOCKS
	changed = changed || (marks & IS_DISTURBED) != 0u;
#endif
	if (offset != before)
		imageStore(offsets, at, ivec4(offset));
#ifdef WAKES
	// Slopes are measured before the first iteration over blocks. So the next interval must measure them where the ground changed. Over
	// a window they are not measured, so the next interval must also do it where the ground is steep.
#ifndef BLOCKS
	steep = steep && height != STILL;
#endif
	moves = moves || changed || steep;
#endif
	flag(at.xy, moves, changed);
#else
	height_out = height;
#endif
}
