// Shared by the passes of scm: the ground and the object at a post, and the soil's answer (SOIL.md).
// Heights are fixed-point units (2^-20 m) from the object's centre as prescribed; stress is Pa.
// Defines:
// - SOIL_MAP: posts differ in their soil
// - SOIL_RASTERS: rasters give some numbers of the soil at each post. A post has a byte for each raster. Three bits of the define's
//   value belong to each byte: 0: there is no raster; otherwise 1 + the number as in enum soil_number
// - SLIP: slip digs
// - BATCH: over all windows of a batch. Posts are counted from the first of their own window, so that numbers are rounded as in a window
//   that is alone

#include "lib/window.glsl"

const float UNIT_METRES = 1.0 / 1048576.0;
const int FAR = (1 << 28) - (1 << 18); // 2^-18 m: ground and object farther apart do not touch
const int FAR_UNITS = (1 << 30) - (1 << 20);
const float UPRIGHT_LEAST = 0.05;      // z of a unit normal; steeper slopes are taken as the one with this z
const float STEEPEST = 19.974984;      // that slope
const float STRESS_MOST = 1e20;        // Pa: a limit that keeps all numbers finite
const int SOILS = 16;

struct soil {
	vec4 a; // k_c, k_phi, n, 1 / K_e
	vec4 b; // c, tan phi, 1 / K, damping
	vec4 c; // K_e, K
};

layout(std140, binding = 0) uniform params {
	ivec4 zero;    // the centre, 2^-18 m from the store's reference, and 0 .. 3 fixed-point units; the layer; the record
	ivec4 written; // the posts this window writes: first, one behind the last
	ivec4 shadow;  // of those, the posts that the object can be above
	vec4 scale;    // slope of a fixed-point unit between posts; metres between posts; units of force a pascal; 1 / b
	vec4 way;      // motion of the object in its frame, m; 1 / its time, 1/s
	vec4 spin;     // its rotation about its centre, rad, in its frame; share of the plastic flow that is deposited around
	vec4 rolls;    // the rotation of a wheel without slip, rad, in its frame
	vec4 place;    // post (0, 0) from the centre, m; 1 / unit of length in moments; square metres a post
	vec4 load;     // N; how deep the object may sink below its first contact, fixed-point units; number of the loaded body, from 1; 0: none
	vec4 body;     // radius, m (of an ellipsoid: half its length along its motion); half its breadth, m, 0: whole posts
	vec4 heading;  // x axis of the object's frame, in plan; the larger of that vector's parts; half the length of a box, m
	vec4 moves;    // a round object: metres forwards; rise a metre; sine of that; how long a wheel's rim takes, of the soil's time; 0: 1
	vec4 faces[3]; // box: height at its centre, m, and slope of its lower faces in its frame; of the first: units of area a post. Of other
	               // shapes: lib/scm_body.glsl
	ivec4 drawn;   // the posts over which `rests` was computed
	vec4 digs;     // how far the object slips over the ground during the contact, m; how deep that digs at most, in units of K; radius of a
	               // wheel with its grousers, m; a host moves the object: 1 + how much the hollow before has its shape; 0: none does
	vec4 surface;  // the object's: adhesion, Pa, and tangent of its friction angle; then 1 for each that is the soil's own instead: c, tan phi
	vec4 belt;     // with BELT: the object's axis to its left, in its frame; what its belt ran, m
	ivec4 frame;   // of laying. x, y: post (0, 0), 2^-16 post. z: 1 if soil is laid all around the patch. w: share of the depth that is laid, 2^-16
	ivec4 frame_axis; // x, y: its x axis, 2^-16. z: share of the dug soil that counts for the depth that is laid, 2^-16
	soil soils[SOILS];
#ifdef SOIL_RASTERS
	vec4 rasters[4]; // of the bytes in `numbers`: least and greatest value, step between levels; SI, angles in radians
#endif
} given;

#ifdef BATCH
// From the record of the window: the numbers above from the first on, then those of lib/rows.glsl. Of `given` only the soils count.
ivec4 zero = NUMBER(0), written = NUMBER(1), shadow = NUMBER(2), drawn = NUMBER(15), frame = NUMBER(19), frame_axis = NUMBER(20);
vec4 scale = intBitsToFloat(NUMBER(3)), way = intBitsToFloat(NUMBER(4)), spin = intBitsToFloat(NUMBER(5)), rolls = intBitsToFloat(NUMBER(6));
vec4 place = intBitsToFloat(NUMBER(7)), load = intBitsToFloat(NUMBER(8)), body = intBitsToFloat(NUMBER(9)), heading = intBitsToFloat(NUMBER(10));
vec4 moves = intBitsToFloat(NUMBER(11)), digs = intBitsToFloat(NUMBER(16)), surface = intBitsToFloat(NUMBER(17));
vec4 faces[3] = vec4[3](intBitsToFloat(NUMBER(12)), intBitsToFloat(NUMBER(13)), intBitsToFloat(NUMBER(14)));
#ifdef BELT
vec4 belt = intBitsToFloat(NUMBER(18));
#endif
ivec4 last_number = NUMBER(21);
ivec3 window_at = ivec3(last_number.w & 0xffff, last_number.w >> 16, 0); // the window's first post in the layer
#else
// A software rasteriser fetches a parameter anew for each invocation and wherever it is named. So all are fetched once, before the loops.
ivec4 zero = given.zero, written = given.written, shadow = given.shadow, drawn = given.drawn, frame = given.frame, frame_axis = given.frame_axis;
vec4 scale = given.scale, way = given.way, spin = given.spin, rolls = given.rolls, place = given.place, load = given.load;
vec4 body = given.body, heading = given.heading, moves = given.moves, faces[3] = given.faces, digs = given.digs, surface = given.surface;
#ifdef BELT
vec4 belt = given.belt;
#endif
ivec3 window_at = ivec3(0, 0, zero.z);
#endif
#ifdef BELT
float belt_level = length(belt.xy);
#endif

// Returns where the images have a post of the window.
ivec3 image_post(int x, int y)
{
	return ivec3(x, y, 0) + window_at;
}

#ifndef SOIL_MAP
soil the_soil = given.soils[0];
#endif

// There are only eight images, and a software rasteriser reads a texture more slowly. So the more often read of two planes is the image.
layout(binding = 2, r32i) uniform readonly restrict iimage2DArray often;
layout(binding = 3) uniform isampler2DArray seldom;
#ifdef SLIP
layout(binding = 0, r32i) uniform restrict iimage2DArray dugs;
#endif
layout(binding = 1, r32i) uniform restrict iimage2DArray heaps;
layout(binding = 0) uniform isampler2DArray unders;
#ifdef SOIL_MAP
layout(binding = 1) uniform usampler2DArray classes;
#endif
#ifdef SOIL_RASTERS
layout(binding = 2) uniform usampler2DArray numbers; // a level for each raster: 0: the soil's own number; 1 .. 255
#endif

#if !defined(SHAPE_WHEEL) && !defined(SHAPE_SPHERE) && !defined(SHAPE_BOX) && !defined(SHAPE_CYLINDER) && !defined(SHAPE_CAPSULE) && !defined(SHAPE_ELLIPSOID)
#define POSTS_ONLY
#endif
#ifndef POSTS_ONLY
int base_at(ivec3 post)
{
	return imageLoad(often, post).r;
}

int rest_at(ivec3 post)
{
	return texelFetch(seldom, post, 0).r;
}
#else
// Here the lower envelope is known only at posts, so that of several posts is read.
int base_at(ivec3 post)
{
	return texelFetch(seldom, post, 0).r;
}

int rest_at(ivec3 post)
{
	return imageLoad(often, post).r;
}
#endif

// The undisturbed surface: base and deposited thickness. `bare`: without that.
struct ground {
	int base, height, bare, heap;
	bool far; // it is out of reach, and `height` is clamped
};

ground ground_at(int x, int y)
{
	ivec3 post = image_post(x, y);
	ground g;
	g.base = base_at(post);
	int d = g.base - zero.x;
	bool wraps = ((g.base ^ zero.x) & (g.base ^ d)) < 0;
	d = wraps ? (g.base < 0 ? -FAR : FAR) : d;
	g.far = abs(d) >= FAR;
	g.bare = 4 * clamp(d, -FAR, FAR) - zero.y;
	g.heap = imageLoad(heaps, post).r;
	g.height = clamp(g.bare + g.heap, -FAR_UNITS, FAR_UNITS);
	return g;
}

float rise_between(ground low, ground at, ground high)
{
	bool no_low = low.base == BASE_NODATA, no_high = high.base == BASE_NODATA;
	float rise = float((no_high ? at.bare : high.bare) - (no_low ? at.bare : low.bare)) * scale.x;
	return no_low || no_high ? rise : 0.5 * rise;
}

// The object's frame: x forwards, y to its left, from its centre.
vec2 into_frame(vec2 v)
{
	return vec2(dot(v, heading.xy), heading.x * v.y - heading.y * v.x);
}

vec2 out_of_frame(vec2 v)
{
	return v.x * heading.xy + v.y * vec2(-heading.y, heading.x);
}

// How the ground lies at a post.
struct incline {
	vec2 rise;       // for each metre along the axes of the object's frame
	float up, by_up; // z of its unit normal, and 1 / z
};

// Deposited soil does not turn the frame in which contact is judged: neighbours that rise would lift a post out of contact.
incline incline_of(ground west, ground at, ground east, ground south, ground north)
{
	vec2 rise = vec2(rise_between(west, at, east), rise_between(south, at, north));
	float by_up = sqrt(1.0 + dot(rise, rise)), up = 1.0 / by_up, squares = up * up;
	// STEEPEST / length(rise), by a series that is exact to 1e-8 where it is less than 1.
	float limit = STEEPEST * up * (1.0 + squares * (0.5 + 0.375 * squares));
	return incline(into_frame(rise * min(1.0, limit)), max(up, UPRIGHT_LEAST), min(by_up, 1.0 / UPRIGHT_LEAST));
}

incline incline_at(int x, int y, ground g)
{
	return incline_of(ground_at(x - 1, y), g, ground_at(x + 1, y), ground_at(x, y - 1), ground_at(x, y + 1));
}

// Returns the mean slope of the base between two posts that lie along one axis. Without data at an end, the middle is used.
float slope_between(ivec2 low, ivec2 high)
{
	ivec2 middle = (low + high) / 2;
	int first = base_at(image_post(low.x, low.y)), last = base_at(image_post(high.x, high.y));
	int between = base_at(image_post(middle.x, middle.y));
	low = first == BASE_NODATA ? middle : low;
	high = last == BASE_NODATA ? middle : high;
	first = first == BASE_NODATA ? between : first;
	last = last == BASE_NODATA ? between : last;
	int posts = high.x - low.x + high.y - low.y;
	bool known = first != BASE_NODATA && last != BASE_NODATA && posts > 0;
	return known ? 4.0 * (float(last) - float(first)) * scale.x / float(posts) : 0.0;
}

// Returns the mean slope of the base under the object. The base is the ground as it was before all drives.
vec2 slope_under()
{
	ivec2 low = shadow.xy, high = shadow.zw - 1, middle = (low + high) / 2;
	return vec2(slope_between(ivec2(low.x, middle.y), ivec2(high.x, middle.y)),
		    slope_between(ivec2(middle.x, low.y), ivec2(middle.x, high.y)));
}

#ifdef SOIL_RASTERS
// Replaces a number of a soil. `number` is known when the program is compiled, so the other cases cost nothing.
void soil_set(inout soil s, int number, float value)
{
	if (number == 0)
		s.a.x = value;
	else if (number == 1)
		s.a.y = value;
	else if (number == 2)
		s.a.z = value;
	else if (number == 3)
		s.b.x = value;
	else if (number == 4)
		s.b.y = tan(value);
	else if (number == 5)
		s.b.z = 1.0 / (s.c.y = value);
	else if (number == 6)
		s.a.w = 1.0 / (s.c.x = value);
}

void soil_take(inout soil s, int number, uint level, vec4 raster)
{
	if (level != 0u)
		soil_set(s, number, level == 255u ? raster.y : raster.x + raster.z * float(level - 1u));
}
#endif

// Returns the class of a post's soil.
int class_at(int x, int y)
{
#ifdef SOIL_MAP
	return min(int(texelFetch(classes, image_post(x, y), 0).r), SOILS - 1);
#else
	return 0;
#endif
}

soil soil_at(int x, int y)
{
#ifdef SOIL_MAP
	soil s = given.soils[class_at(x, y)];
#else
	soil s = the_soil;
#endif
#ifdef SOIL_RASTERS
	uvec4 levels = texelFetch(numbers, image_post(x, y), 0);
	soil_take(s, (SOIL_RASTERS & 7) - 1, levels.x, given.rasters[0]);
	soil_take(s, (SOIL_RASTERS >> 3 & 7) - 1, levels.y, given.rasters[1]);
	soil_take(s, (SOIL_RASTERS >> 6 & 7) - 1, levels.z, given.rasters[2]);
	soil_take(s, (SOIL_RASTERS >> 9 & 7) - 1, levels.w, given.rasters[3]);
#endif
	return s;
}

// Returns the stress that the soil bears at sinkage z, m, when it yields; Pa.
float yield_stress(soil s, float by_width, float z)
{
	float k = max(s.a.x * by_width + s.a.y, 0.0); // k_c may be negative, and a patch small
	float bekker = k * exp2(s.a.z * log2(max(z, UNIT_METRES)));
	return z > 0.0 ? min(min(bekker, z * s.c.x), STRESS_MOST) : 0.0;
}

// Returns how the yield stress grows with the sinkage, Pa/m.
float yield_growth(soil s, float yields, float z)
{
	return yields >= 0.9999999 * s.c.x * z ? s.c.x : yields * s.a.z / max(z, UNIT_METRES);
}

// Returns the plastic part of sinkage z, m: what stays after unloading.
float plastic_part(soil s, float z, float yields)
{
	return max(0.0, z - yields * s.a.w);
}

// Returns the largest shear force on an area: of the soil, or along the object's surface if that is less. normal: force across it.
float holds(soil s, float area, float normal)
{
	vec2 along = surface.xy + surface.zw * s.b.xy;
	return min(s.b.x * area + s.b.y * normal, along.x * area + along.y * normal);
}

// Returns the sinkage of a height below the surface, along the normal, fixed-point units. It is whole, so that the stored number
// is the compared one.
int sinkage_of(float ca, ground g, int height)
{
	return int(round(clamp(ca * float(g.height - height), 0.0, 1.9e9)));
}

// The object's lowest height during the contact, and its height in the end pose, `raised` above the prescribed one. UNDER_NONE: it
// is not above the post.
struct object {
	int lowest, rests, raised;
};

object object_at(int x, int y, int raised)
{
	object o;
	o.raised = raised;
	int rest = rest_at(image_post(x, y));
	int lowest = min(rest, texelFetch(unders, image_post(x, y), 0).r);
	o.rests = rest == UNDER_NONE ? UNDER_NONE : max(rest, -FAR_UNITS) + raised;
	o.lowest = lowest == UNDER_NONE ? UNDER_NONE : max(lowest, -FAR_UNITS) + raised;
	return o;
}

bool may_touch(ground g, object o)
{
	return g.base != BASE_NODATA && o.lowest < g.height;
}

// A wheel turns about its own axle.
vec3 turns_by(vec4 rotation)
{
#ifdef SHAPE_WHEEL
	return vec3(0.0, rotation.y, 0.0);
#else
	return rotation.xyz;
#endif
}

// Returns the motion of the object's surface relative to the ground during the contact, m, in the object's frame. `at`: place there.
vec3 way_of_surface(vec3 at)
{
	return way.xyz + cross(turns_by(spin), at);
}

#ifdef BELT
// Returns the direction in which the belt runs over the object where the object's lower envelope has this normal, in the object's frame. It is
// along the surface, across the object's left axis: backward where the normal is upright.
vec3 along_belt(vec3 normal)
{
	return cross(normal, belt.xyz);
}
#endif

// Returns the additional stress of damping: soil that is pushed down fast; Pa.
float damped(soil s, vec3 at, vec3 normal)
{
	return s.b.w * max(0.0, -dot(way.xyz + cross(turns_by(rolls), at), normal)) * way.w;
}

// An exact sum of at most 2^15 whole numbers. It needs no carries.
struct total {
	int high;
	uint low;
};

void total_add(inout total t, int value)
{
	t.high += value >> 16;
	t.low += uint(value) & 0xffffu;
}

// Returns it in 64 bits, two's complement: low, high word.
uvec2 total_words(total t)
{
	uint carry;
	uint low = uaddCarry(uint(t.high) << 16, t.low, carry);
	return uvec2(low, uint(t.high >> 16) + carry);
}
