#version 450 core
// The contact pass of scm: the soil's answer to the object. One invocation for each row of posts that the object can be above, which
// loops over the posts. So sums stay in registers, and posts that nothing touches are skipped. Images change in place: of its neighbours
// a post reads only the base and the deposited thickness, which this pass does not write.
// Defines: FORCES: sums forces and moments; PATCH: b follows from the counted posts; LOAD: the equilibrium height was found; BELT: the object has a belt.

#include "lib/rows.glsl"
#include "lib/soil.glsl"
#include "lib/laying.glsl"
#include "lib/tally.glsl"
#include "lib/scm_post.glsl"
#if defined(PATCH) || defined(LOAD)
#include "lib/found.glsl"
#endif

layout(binding = 3, r32i) uniform restrict iimage2DArray offsets;
layout(binding = 4, r32i) uniform restrict iimage2DArray sinkages;
layout(binding = 5, r32i) uniform restrict iimage2DArray shears;
layout(binding = 6, r8ui) uniform restrict uimage2DArray contacts;
#include "lib/ways.glsl"

#ifdef FORCES
// Each contact with a tag has 20 words. The first twelve are force and moment, 64 bits for each component. Then:
// - area that bears, in units of which a post has faces[0].w
// - the deepest sinkage below the base, fixed-point units
// - the equilibrium height above the prescribed one, fixed-point units
// - posts whose share was too large to count
// - the mean slope of the base under the object, east and north, in 2^-16
// - with BELT: the pull of its belt, 64 bits
layout(std430, binding = 1) restrict buffer records {
	int record[];
};

const int AREA = 12, DEEPEST = 13, RAISED = 14, SATURATED = 15, SLOPE = 16, PULL = 18, WORDS = 20;
const int STATE_BIT = 30; // the state of a loaded object: the two highest bits of the word SATURATED
const float MOST = 2147483000.0;

void record_add(int at, total t)
{
	uvec2 words = total_words(t);
	uint before = uint(atomicAdd(record[at], int(words.x)));
	atomicAdd(record[at + 1], int(words.y + uint(before + words.x < before)));
}
#endif

#ifdef LOAD
layout(std430, binding = 3) restrict buffer standings {
	int standing[]; // for each loaded body: equilibrium height above the prescribed one, fixed-point units
};
#endif

// Tells whether the object was less than two spacings above the surface. Then it has just left the post, or comes next, and the shear
// that the post stores ends. Below a higher object that shear may belong to a second object, so it stays.
bool is_near(ground g, object o, int offset)
{
	int surface = g.height - g.heap + offset;
	return o.lowest != UNDER_NONE && g.base != BASE_NODATA && o.lowest - surface < int(min(scale.y * 2097152.0, 1e9));
}

const int NOTHING = 0, REACHED = 1, CONCERNED = 2;

// Tells whether the object was near the post, and whether it may touch it, may bear on its cell, or ends its shear. It may say so too where
// the object does not quite. fell: how much lower the object was before the contact than it is now, fixed-point units.
int concerns(int x, int y, ground west, ground g, ground east, float by_width, int raised, int fell)
{
	ivec3 post = image_post(x, y);
	bool sheared = imageLoad(shears, post).r != 0;
	ground south = ground_at(x, y - 1), north = ground_at(x, y + 1);
#ifdef SHAPE_WHEEL
	vec2 at = place_of(x, y);
	float height = float(g.height - raised) * UNIT_METRES;
	bool known = g.base != BASE_NODATA, near = known && was_below(at, height + 2.0 * scale.y + float(fell) * UNIT_METRES, 0.0);
	// Under a wheel that goes on, nothing bears above the plastic sinkage that the post had before.
	float gone = stamps > 0.0 ? 0.0 : max(plastic_of(soil_at(x, y), by_width, imageLoad(sinkages, post).r) - LEAST, 0.0);
	float rises = (abs(rise_between(west, g, east)) + abs(rise_between(south, g, north))) * cell_reach;
	bool some = near && sheared || known && was_below(at, height - gone + rises, cell_reach);
#else
	object o = object_at(x, y, raised);
	int offset = imageLoad(offsets, post).r;
	bool near = is_near(g, o, offset + fell), some = may_touch(g, o) || sheared && is_near(g, o, offset);
	// A steep side may bear far above the post. Whether forces are summed must not change what the contact reaches.
#if defined(FORCES) || defined(SHAPE_CYLINDER) || defined(SHAPE_CAPSULE) || defined(SHAPE_ELLIPSOID)
	some = some || touch_room(incline_of(west, g, east, south, north), g, o, cell_at(x, y, o)) > 0;
#endif
#endif
	return some ? CONCERNED : near ? REACHED : NOTHING;
}

void main()
{
	int y = row_of_pass(shadow.y);
	bool begins = y == shadow.y; // one invocation tells what all have in common, also where the object is above no post
	if (!begins && y >= shadow.w)
		return;
	int raised = 0, fell = 0;
	float by_width = scale.w, unit = scale.z;
#ifdef LOAD
	unit /= FOUND.share;
	raised = FOUND.raised;
	fell = max(raised - FOUND.before, 0);
	if (begins && load.z > 0.0)
		standing[int(load.z) - 1] = raised;
#endif
#ifdef PATCH
	by_width = found_by_width(FOUND.posts, place.w);
#endif
	// The posts of this row, without those at its ends that the object does not concern. It may have left some of these.
	int first = shadow.x, last = shadow.z;
	ivec2 reaches = ivec2(last, first);
	ground west = ground_at(first - 1, y), g = ground_at(first, y), east;
	for (; first < last; first++, west = g, g = east) {
		east = ground_at(first + 1, y);
		int what = concerns(first, y, west, g, east, by_width, raised, fell);
		if (what == CONCERNED)
			break;
		reaches = what == REACHED ? ivec2(min(reaches.x, first), first + 1) : reaches;
	}
	ground before_last = ground_at(last - 1, y), at_last = ground_at(last, y);
	for (ground next; first < last; last--, at_last = before_last, before_last = next) {
		next = ground_at(last - 2, y);
		int what = concerns(last - 1, y, next, before_last, at_last, by_width, raised, fell);
		if (what == CONCERNED)
			break;
		reaches.y = what == REACHED ? max(reaches.y, last) : reaches.y;
	}
	if (first < last)
		reaches = ivec2(min(reaches.x, first), max(reaches.y, last));
	reach(y + window_at.y, reaches.x + window_at.x, reaches.y + window_at.x);
	total lost = total(0, 0u), moved = lost;
	uint over = 0u, moving = 0u, of_classes = 0u;
	int hollow = 0, first_touched = last, last_touched = first;
#ifdef FORCES
	total force[3] = total[3](lost, lost, lost), moment[3] = total[3](lost, lost, lost);
	int deepest = 0, area = 0, saturated = 0;
#ifdef BELT
	total pull = lost;
#endif
#endif
	for (int x = first; x < last; x++, west = g, g = east) {
		ivec3 post = image_post(x, y);
		object o = object_at(x, y, raised);
		east = ground_at(x + 1, y);
		soil s = soil_at(x, y);
		post_state before = {imageLoad(offsets, post).r, g.heap, imageLoad(sinkages, post).r, 0, imageLoad(shears, post).r};
#ifdef SLIP
		before.dug = imageLoad(dugs, post).r;
#endif
		incline i = incline_of(west, g, east, ground_at(x, y - 1), ground_at(x, y + 1));
		bearing b = bearing_of(s, by_width, i, g, o, cell_at(x, y, o), before);
		over += uint(b.refused);
		total_add(lost, b.touched ? before.offset - b.after.offset - b.carried : 0);
		if ((b.held || is_near(g, o, before.offset)) && b.after.shear != before.shear)
			imageStore(shears, post, ivec4(b.after.shear));
		if (b.touched) {
			imageStore(offsets, post, ivec4(b.after.offset));
#ifdef SLIP
			imageStore(heaps, post, ivec4(b.after.heap));
			imageStore(dugs, post, ivec4(b.after.dug));
#endif
			imageStore(sinkages, post, ivec4(b.after.sinkage));
			imageStore(contacts, post, uvec4(LOWERED | (b.held ? HELD : 0u)));
		}
		total_add(moved, b.carried);
		moving += uint(b.carried > 0);
		of_classes |= b.carried > 0 ? 1u << class_at(x, y) : 0u;
		hollow = max(hollow, b.touched ? depth_of(b.carried, b.after.offset, b.after.dug, frame_axis.z, frame.w) : 0);
		first_touched = b.touched ? min(first_touched, x) : first_touched;
		last_touched = b.touched ? x : last_touched;
#ifdef FORCES
		vec3 f = b.stress * unit, m = b.moment * unit * place.z;
		bool bears = g.base != BASE_NODATA && b.area > 0.0;
		vec3 large = max(abs(f), abs(m));
		float most = bears ? MOST * min(b.area, 1.0) : 0.0;
		saturated += int(bears && max(large.x, max(large.y, large.z)) > most);
		for (int k = 0; k < 3; k++) {
			total_add(force[k], int(round(clamp(f[k], -most, most))));
			total_add(moment[k], int(round(clamp(m[k], -most, most))));
		}
#ifdef BELT
		total_add(pull, int(round(clamp(b.pull * unit, -most, most))));
#endif
		area += bears ? int(round(b.area * faces[0].w)) : 0;
		deepest = max(deepest, b.held && bears ? b.sunk - b.after.heap : 0);
#endif
	}
#ifdef FORCES
	if (begins && zero.z == 0) {
		vec2 slope = clamp(slope_under(), -1e4, 1e4) * 65536.0;
		record[zero.w * WORDS + SLOPE] = int(round(slope.x));
		record[zero.w * WORDS + SLOPE + 1] = int(round(slope.y));
	}
#endif
#if defined(FORCES) && defined(LOAD)
	if (begins) {
		record[zero.w * WORDS + RAISED] = raised;
		atomicOr(record[zero.w * WORDS + SATURATED], int(FOUND.state << STATE_BIT));
	}
#endif
	if (frame.z != 0)
		store_ways(y + window_at.y, window_at.z, written.x + window_at.x, written.z + window_at.x);
	if (last <= first)
		return;
	if (first_touched < last)
		measured(total_words(moved), moving, of_classes, hollow,
			 ivec2[2](frame_of(frame.xy, frame_axis.xy, first_touched, y), frame_of(frame.xy, frame_axis.xy, last_touched, y)));
	tally_sum(COMPACTED, total_words(lost));
	if (over > 0u)
		tally_add(REFUSED, over);
#ifdef FORCES
	int to = zero.w * WORDS;
	for (int i = 0; i < 3; i++) {
		record_add(to + 2 * i, force[i]);
		record_add(to + 6 + 2 * i, moment[i]);
	}
#ifdef BELT
	record_add(to + PULL, pull);
#endif
	atomicAdd(record[to + AREA], area);
	atomicMax(record[to + DEEPEST], deepest);
	atomicAdd(record[to + SATURATED], saturated);
#endif
}
