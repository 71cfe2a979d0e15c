#version 450 core
// The search before a contact of scm, by one work group. PATCH: it finds the size of the contact patch. LOAD: it finds the equilibrium
// height, at which the soil's whole vertical force, by normal stress and shear, is the load. Each try sums over the posts that the
// object can be above. All sums are whole numbers, so their order does not matter. Heights are fixed-point units above the prescribed
// one.
// Define: BATCH: over windows of a batch, each by a work group

layout(local_size_x = 16, local_size_y = 8) in;

#ifdef BATCH
const int RECORD = 81; // windows.vert

layout(std430, binding = 5) readonly buffer batch {
	ivec4 records[];
};

#define WINDOW (given.zero.x + int(gl_WorkGroupID.x)) // first the draw of windows.vert
#define NUMBER(i) records[WINDOW * RECORD + given.zero.y + i]
#else
#define WINDOW 0
#endif
#include "lib/soil.glsl"
#include "lib/found.glsl"
#include "lib/scm_post.glsl"
#include "lib/tally.glsl"

layout(binding = 4, r32i) uniform readonly restrict iimage2DArray sinkages;
layout(binding = 5, r32i) uniform readonly restrict iimage2DArray shears;
layout(binding = 7, r32i) uniform restrict iimage2DArray gaps; // only for this pass: later passes write the image before they read it

#ifdef LOAD
layout(std430, binding = 3) restrict readonly buffer standings {
	int standing[]; // scm.frag writes it
};
#endif

const int NOWHERE = -2000000000;
const int LANES = int(gl_WorkGroupSize.x * gl_WorkGroupSize.y);
const int WORDS = 5;
// A bracket begins with at most 2^28 units. At most 5 times it is parted by a geometric mean, and 28 times by the arithmetic one.
// Before each of these come at most 3 tries that part it worse. So the search always ends, as a rule after a few tries.
const int TRIES = 4 * (5 + 28);
const float SHARE = 67108864.0;   // forces are counted in 2^-26 of the load
const float GROWTH = 4294967296.0; // and their growth for each unit of sinkage in 2^-32 of it
const float COUNTED_MOST = 1e9;   // the most that one post may add, in these units

shared int words[WORDS][LANES];   // what each invocation summed
shared int sums[WORDS];

// Sums the first `count` words of all invocations. Then all of them may read the sums until the next call.
void sum_up(int count)
{
	int lane = int(gl_LocalInvocationIndex);
	barrier();
	if (lane < count) {
		int sum = 0;
		for (int i = 0; i < LANES; i++)
			sum += words[lane][i];
		sums[lane] = sum;
	}
	barrier();
}

void give(int word, int value)
{
	words[word][gl_LocalInvocationIndex] = value;
}

// A window has at most 2^16 posts, so neither word of a total can overflow. Two words of 32 bits hold an exact sum of 64 bits.
void give_total(int word, total t)
{
	give(word, t.high);
	give(word + 1, int(t.low));
}

float real_of(int word)
{
	return float(sums[word]) * 65536.0 + float(uint(sums[word + 1]));
}

// A post's gap is a height at and above which the object does not touch its cell. Each invocation reads only gaps that it wrote itself.
int gap_at(int x, int y)
{
	return imageLoad(gaps, image_post(x, y)).r;
}

// Writes all gaps. Returns the height of the first contact. NOWHERE: there is no ground below the object.
int first_contact()
{
	int highest = NOWHERE;
	for (int y = shadow.y + int(gl_LocalInvocationID.y); y < shadow.w; y += int(gl_WorkGroupSize.y))
		for (int x = shadow.x + int(gl_LocalInvocationID.x); x < shadow.z; x += int(gl_WorkGroupSize.x)) {
			ground g = ground_at(x, y);
			object o = object_at(x, y, 0);
			int room = touch_room(incline_at(x, y, g), g, o, cell_at(x, y, o));
			imageStore(gaps, image_post(x, y), ivec4(room));
			highest = max(highest, g.far ? NOWHERE : room);
		}
	if (gl_LocalInvocationIndex == 0u)
		sums[0] = NOWHERE;
	barrier();
	if (highest > NOWHERE)
		atomicMax(sums[0], highest);
	barrier();
	int top = sums[0];
	barrier();
	return top;
}

// Returns how many posts the object touches at a height.
uint posts_at(int at)
{
	int posts = 0;
	for (int y = shadow.y + int(gl_LocalInvocationID.y); y < shadow.w; y += int(gl_WorkGroupSize.y))
		for (int x = shadow.x + int(gl_LocalInvocationID.x); x < shadow.z; x += int(gl_WorkGroupSize.x))
			if (at < gap_at(x, y)) {
				ground g = ground_at(x, y);
				posts += int(g.base != BASE_NODATA && object_at(x, y, at).rests < g.height);
			}
	give(0, posts);
	sum_up(1);
	return uint(sums[0]);
}

// Returns what the soil carries at a height: x: the share of the load. y: its growth for each unit of sinkage. z: the area that
// carries it, in posts.
vec3 share_at(int at, float by_width)
{
	total force = total(0, 0u), stiff = total(0, 0u);
	int area = 0;
	float unit = SHARE * place.w / load.x, growth = UNIT_METRES * GROWTH * place.w / load.x;
	for (int y = shadow.y + int(gl_LocalInvocationID.y); y < shadow.w; y += int(gl_WorkGroupSize.y))
		for (int x = shadow.x + int(gl_LocalInvocationID.x); x < shadow.z; x += int(gl_WorkGroupSize.x)) {
			if (at >= gap_at(x, y))
				continue;
			ground g = ground_at(x, y);
			object o = object_at(x, y, at);
			ivec3 post = image_post(x, y);
			post_state before = {0, imageLoad(heaps, post).r, imageLoad(sinkages, post).r, 0, imageLoad(shears, post).r};
#ifdef SLIP
			before.dug = imageLoad(dugs, post).r;
#endif
			bearing b = bearing_of(soil_at(x, y), by_width, incline_at(x, y, g), g, o, cell_at(x, y, o), before);
			if (g.base != BASE_NODATA && b.area > 0.0) {
				area += int(round(b.area * faces[0].w));
				total_add(force, int(round(clamp(b.stress.z * unit, -COUNTED_MOST, COUNTED_MOST))));
				// Friction grows with the normal stress, so the whole force grows about as the normal stress does.
				float whole = clamp(b.stress.z / max(b.normal, 1e-9), 0.0, 4.0);
				total_add(stiff, int(round(min(b.stiff * whole * growth, COUNTED_MOST))));
			}
		}
	give_total(0, force);
	give_total(2, stiff);
	give(4, area);
	sum_up(5);
	return vec3(real_of(0) / SHARE, real_of(2) / GROWTH, float(uint(sums[4])) / faces[0].w);
}

// Returns true if the slope is too steep to hold this load: W sin a > c A + W cos a tan phi. The numbers are those of the soil below the
// object's middle, or of the object's surface.
bool slides(float posts)
{
	vec2 slope = slope_under();
	float sine = length(slope) * inversesqrt(1.0 + dot(slope, slope));
	soil s = soil_at((shadow.x + shadow.z) / 2, (shadow.y + shadow.w) / 2);
	return sine > holds(s, posts * place.w / load.x, sqrt(1.0 - sine * sine));
}

// Returns the height after a step of Newton's method. Force is about a power of depth, so the step uses the logarithms of both.
int stepped(int top, int at, float share, float grows)
{
	float depth = load.y, z = float(top - at), power = clamp(z * grows / max(share, 1e-6), 0.1, 1e6);
	float step = z * exp2(clamp(-log2(max(share, 1e-6)) / power, -20.0, 20.0));
	return top - int(round(min(step, depth)));
}

// Takes force as a power of depth that passes through two tries. Returns the height at which this force is the load.
int between(int top, int first, int second, float at_first, float at_second)
{
	float near = float(max(top - first, 1)), far = float(max(top - second, 1)), rise = log2(at_second / at_first);
	float part = abs(rise) > 1e-9 ? -log2(at_first) / rise : 0.5;
	return top - int(round(min(near * exp2(log2(far / near) * clamp(part, -20.0, 20.0)), 1e9)));
}

// Returns a height between two depths below the first contact: at the geometric mean if the depths differ much, else at the mean.
int middle(int shallow, int deep, int top)
{
	int mean = shallow + (deep - shallow) / 2;
	return top - (deep > 8 * max(shallow, 8) ? int(sqrt(float(max(shallow, 8)) * float(deep))) : mean);
}

void main()
{
	int at = 0;
	uint posts = 0u, state = CARRIED;
	float by_width = scale.w, carried = 1.0, held = 0.0;
#ifdef LOAD
	// The soil carries the load at `low`, or the object may not sink deeper. It does not carry the load at `high`.
	int top = first_contact(), low = top - int(load.y), high = top;
	state = top == NOWHERE ? AIR : SUNK;
	int last = 2 * int(load.y), stalls = 0;
	float at_low = 1e30, at_high = 0.0; // the shares there
	int before = 0;                     // height of the try before
	float at_before = 0.0;
	bool done = top == NOWHERE;
	// The first try is at the height that this object's last contact found. Both heights are above a path that follows the ground.
	at = done ? 0 : clamp(load.z > 0.0 ? standing[int(load.z) - 1] : 0, low + 1, high - 1);
	for (int k = 0; k < TRIES && !done; k++) {
#ifdef PATCH
		posts = posts_at(at);
		by_width = found_by_width(posts, place.w);
#endif
		vec3 share = share_at(at, by_width);
		bool bears = share.x >= 1.0;
		state = bears ? CARRIED : state;
		carried = bears ? share.x : carried;
		low = bears ? at : low;
		high = bears ? high : at;
		at_low = bears ? share.x : at_low;
		at_high = bears ? at_high : share.x;
		int width = high - low;
		bool both = at_low < 1e30 && at_high > 1e-6;
		// The height is found if the next step is shorter than half a unit, or if the bracket is one unit wide.
		float chord = k > 0 ? abs((share.x - at_before) / float(max(abs(at - before), 1))) : share.y, grows = min(share.y, chord);
		bool there = abs(share.x - 1.0) <= 0.5 * grows;
		state = there ? CARRIED : state;
		carried = there ? share.x : carried;
		held = bears || there ? share.z : held;
		done = there || width <= 1;
		// The step uses this try and the one before it. The first step is one of Newton's method.
		bool known = k > 0 && min(share.x, at_before) > 1e-6 && at != before;
		int next = known ? between(top, before, at, at_before, share.x) : stepped(top, at, share.x, share.y);
		bool out_of = next <= low || next >= high;
		next = out_of && both ? between(top, high, low, at_high, at_low) : next;
		// If three steps in a row do not halve the bracket, the next try is in its middle.
		stalls = 2 * width > last ? stalls + 1 : 0;
		bool lags = stalls >= 3 || share.x <= 1e-6 || (out_of && !both && at_low < 1e30);
		stalls = lags ? 0 : stalls;
		last = width;
		before = at;
		at_before = share.x;
		next = clamp(lags ? middle(top - high, top - low, top) : next, low + 1, max(high - 1, low + 1));
		at = there ? at : done ? low : next;
	}
	at = done ? at : low; // the last height that was tried and carries
	if (state == CARRIED && slides(held))
		state = SLIDES;
#endif
#ifdef PATCH
#ifndef LOAD
	first_contact();
#endif
	posts = posts_at(at);
#endif
	if (gl_LocalInvocationIndex == 0u) {
		FOUND.raised = at;
		FOUND.posts = posts;
		FOUND.state = state;
		FOUND.share = carried;
#ifdef LOAD
		FOUND.before = load.z > 0.0 ? standing[int(load.z) - 1] : 0;
		if (state == SLIDES || state == SUNK)
			tally_add(state == SLIDES ? SLID : CARRIED_NOWHERE, 1u);
#endif
	}
}
