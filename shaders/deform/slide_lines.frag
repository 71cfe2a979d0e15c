#version 450 core
// Sliding along the lines of a window, in one direction. One invocation walks along a line and back. Where soil slides, posts join a
// pool: they get the heights at which each difference from post to post is the critical one. So a line is at rest when it was walked
// (lines.c; SOIL.md, "Along lines").
// Defines:
// - DIAGONAL: lines to the north-east or to the south-east; otherwise along x or y
// - BOUNDED: relaxing soil has a bottom
// - STOOD: undisturbed ground is stable, however steep
// - SOILS: number of soil classes in the parameters

#include "lib/slide.glsl"
#include "lib/reached.glsl"
#include "lib/rows.glsl"

layout(binding = 0, r32i) restrict uniform iimage2DArray heights;
#ifdef BOUNDED
layout(binding = 1, r32i) readonly restrict uniform iimage2DArray floors;
#endif
#if SOILS > 1
layout(binding = 2, r8ui) readonly restrict uniform uimage2DArray classes;
#endif

layout(std140, binding = 0) uniform params {
	ivec4 of_pass;       // layer; direction: x, y, north-east, south-east; tolerance; no difference up to this slides
	ivec4 window;        // the posts that the window writes: first, one behind the last
	ivec4 around;        // x: of reached_posts
	ivec4 limits[SOILS]; // critical difference of heights in this direction
};

ivec4 place = of_pass, written = reached_posts(window, around.x); // written: posts that exchange soil: first, one behind the last

const int POPS_MOST = 512;  // posts that join from before the pool, of all pools of a walk: drivers end long loops

ivec2 extent; // posts of the window

// The pool: posts of the line, one behind the other. A post's fall is the sum of the critical differences before it; its level is its
// height and its fall. All levels are `level`, but those of the last `rest` posts are one more.
int count, level, rest, first_fall, last_fall;
int lowest, highest; // levels that posts of the pool had before
#ifdef BOUNDED
int bottom; // the highest level that a post of the pool has at its floor
#endif

// Returns the critical difference between a post and a lower one beside it.
int limit_of(ivec3 high, ivec3 low)
{
#if SOILS > 1
	int limit = limits[min(int(imageLoad(classes, high).r), SOILS - 1)].x;
#else
	int limit = limits[0].x;
#endif
#ifdef STOOD
	limit = max(limit, int(uint(imageLoad(grounds, high).r - imageLoad(grounds, low).r) * 4u));
#endif
	return limit;
}

// Returns a / b rounded down; b > 0.
int quotient(int a, int b)
{
	int q = a / b;
	return q - int(q * b > a);
}

// Begins a pool with one post.
void begin_pool(int height)
{
	count = 1;
	level = lowest = highest = height;
	rest = first_fall = last_fall = 0;
}

// Adds soil to the pool: with a post, by how much that lies above the pool's level.
void add_to_pool(int soil, int posts)
{
	int sum = rest + soil, mean = quotient(sum, count + posts);
	count += posts;
	rest = sum - mean * count;
	level += mean;
}

int last_height()
{
	return level + int(rest > 0) - last_fall;
}

// Returns whether soil may slide from one post to another. It may be wrong of a post that is still.
bool may_slide(int high, int low)
{
	return uint(high - low - place.w - 1) < 1u << 30;
}

// Returns the post after `at`. cut: it lies at the other side of the window, where the line goes on.
ivec3 next_post(ivec3 at, ivec3 step, out bool cut)
{
	ivec3 to = at + step;
#ifdef DIAGONAL
	cut = to.y < written.y || to.y >= written.w;
	to.y += to.y < written.y ? extent.y : to.y >= written.w ? -extent.y : 0;
#else
	cut = false;
#endif
	return to;
}

// Lets posts before and after the pool join it as long as soil slides. last: the pool's last post. before, after: posts of the line
// on both sides. back: looks before the pool first. Returns soil that the pool cannot keep, for the post after it.
int grow_pool(ivec3 step, inout ivec3 last, int before, inout int after, bool back, inout int pops)
{
	int surplus = 0;
	ivec3 first = last;
	bool grows = true;
	while (grows) {
		ivec3 there = back ? first - step : last + step;
		bool takes = back ? before > 0 && pops < POPS_MOST : after > 0;
#ifdef DIAGONAL
		takes = takes && there.y >= written.y && there.y < written.w;
#endif
		int height = takes ? imageLoad(heights, there).r : STILL, edge = back ? level - first_fall : last_height();
		takes = takes && height != STILL && edge != STILL && (back ? may_slide(height, edge) : may_slide(edge, height));
		int limit = limit_of(back ? there : last, back ? first : there);
		int fall = back ? first_fall - limit : last_fall + limit, own = height + fall, above = own - level;
		takes = takes && (back ? above : int(rest > 0) - above) > place.z;
		takes = takes && max(highest, own) - min(lowest, own) < POOLED_MOST;
#ifdef BOUNDED
		int under = imageLoad(floors, there).r + fall;
		takes = takes && (back ? own > under : level > bottom);
		bool ends = takes && level + quotient(rest + above, count + 1) < (back ? under : bottom);
		takes = takes && !ends;
		if (ends && back) {
			imageStore(heights, there, ivec4(under - fall));
			add_to_pool(own - under, 0);
		} else if (ends) {
			surplus = (level - bottom) * count + rest;
			level = bottom;
			rest = 0;
		}
		bottom = takes ? max(bottom, under) : bottom;
#endif
		if (takes) {
			add_to_pool(above, 1);
			lowest = min(lowest, own);
			highest = max(highest, own);
			first = back ? there : first;
			first_fall = back ? fall : first_fall;
			before -= int(back);
			last = back ? last : there;
			last_fall = back ? last_fall : fall;
			after -= int(!back);
			pops += int(back);
		}
		grows = takes || back;
		back = takes;
	}
	return surplus;
}

void write_pool(ivec3 last, ivec3 step)
{
	int fall = last_fall;
	for (int i = count - 1; i >= 0; i--) {
		imageStore(heights, last, ivec4(level + int(i >= count - rest) - fall));
		fall -= i > 0 ? limit_of(last - step, last) : 0;
		last -= step;
	}
}

// Walks along a line, from its end `at`, over so many posts. Returns true if soil slid, or may slide the other way.
bool walk(ivec3 at, ivec3 step, int posts)
{
	int height = imageLoad(heights, at).r, after = posts - 1, pops = 0;
	bool other = false, given = false, walks = true;
	while (walks) {
		bool found = given, skips = !given, cut;
		// As a rule posts are at rest, so four are looked at together.
		while (skips) {
			ivec3 to = at;
			int last = height;
			bool falls = after < 4, rises = false;
			for (int k = 0; k < 4; k++) {
				to = next_post(to, step, cut);
				int next = imageLoad(heights, to).r;
				falls = falls || (!cut && may_slide(last, next));
				rises = rises || may_slide(next, last);
				last = next;
			}
			skips = !falls;
			other = other || (skips && rises);
			at = skips ? to : at;
			height = skips ? last : height;
			after -= skips ? 4 : 0;
		}
		while (!found && after > 0) {
			ivec3 to = next_post(at, step, cut);
			int next = imageLoad(heights, to).r;
			found = !cut && may_slide(height, next);
			other = other || may_slide(next, height);
			at = found ? at : to;
			height = found ? height : next;
			after -= int(!found);
		}
		walks = found;
		if (found) {
			begin_pool(height);
#ifdef BOUNDED
			bottom = imageLoad(floors, at).r;
#endif
			int surplus = grow_pool(step, at, posts - 1 - after, after, given, pops);
			write_pool(at, step);
			given = surplus > 0;
			other = other || given || count > 1;
			walks = after > 0;
			after--;
			at = next_post(at, step, cut);
			height = imageLoad(heights, at).r + surplus;
		}
	}
	return other;
}

void main()
{
	int line = row_of_pass(0);
	extent = written.zw - written.xy;
	bool column = place.y == 1;
	ivec2 step = column ? ivec2(0, 1) : ivec2(1, place.y == 0 ? 0 : place.y == 2 ? 1 : -1);
	int lines = column ? extent.x : extent.y, posts = column ? extent.y : extent.x;
	if (line >= lines || posts == 0)
		return;
	ivec2 first = column ? ivec2(line, 0) : ivec2(0, line), last = first + step * (posts - 1);
#ifdef DIAGONAL
	last.y = (last.y + extent.y * posts) % extent.y;
#endif
	if (walk(ivec3(written.xy + first, place.x), ivec3(step, 0), posts))
		walk(ivec3(written.xy + last, place.x), ivec3(-step, 0), posts);
}
