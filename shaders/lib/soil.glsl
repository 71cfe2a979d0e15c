// Shared by the passes of scm: the ground and the object at a post, and the soil's answer (SOIL.md). A pass has one
// invocation for each row of the window's written posts, which loops over the posts. So sums stay in registers, and posts that
// nothing touches are skipped.
// Heights are fixed-point units (2^-20 m) from the object's centre as prescribed; stress is Pa.
// Defines: SOIL_MAP: posts differ in their soil.

#include "lib/window.glsl"

const float UNIT_METRES = 1.0 / 1048576.0;
const int FAR = (1 << 28) - (1 << 18); // 2^-18 m: ground and object farther apart do not touch
const int FAR_UNITS = (1 << 30) - (1 << 20);
const float STEEPEST = 19.974984;      // slope at which the normal's z is 0.05; steeper slopes are taken as this one
const float STRESS_MOST = 1e20;        // Pa: a limit that keeps all numbers finite
const int SOILS = 16;
const int COLUMNS = 4;                 // rows side by side in the pass's viewport, so that its blocks of pixels are full

struct soil {
	vec4 a; // k_c, k_phi, n, 1 / K_e
	vec4 b; // c, tan phi, 1 / K, damping
};

layout(std140, binding = 0) uniform params {
	ivec4 zero;    // the centre, 2^-18 m from the store's reference, and 0 .. 3 fixed-point units; the layer; the record, or the try
	ivec4 written; // the posts this window writes: first, one behind the last
	ivec4 shadow;  // of those, the posts that the object can be above
	vec4 scale;    // slope of a fixed-point unit between posts; metres between posts; units of force a pascal; 1 / b
	vec4 way;      // motion of the object, m; 1 / its time, 1/s
	vec4 spin;     // its rotation about its centre, rad; share of the plastic flow that is deposited around
	vec4 rolls;    // the rotation of a wheel without slip, rad
	vec4 place;    // post (0, 0) from the centre, m; 1 / unit of length in moments; square metres a post
	vec4 load;     // N; how deep the object may sink below its first contact, fixed-point units; number of the loaded body, from 1; 0: none
	soil soils[SOILS];
};

layout(binding = 0, r32i) uniform readonly restrict iimage2DArray bases;
layout(binding = 1, r32i) uniform readonly restrict iimage2DArray heaps;
layout(binding = 2, r32i) uniform readonly restrict iimage2DArray rests;
layout(binding = 0) uniform isampler2DArray unders;
#ifdef SOIL_MAP
layout(binding = 1) uniform usampler2DArray classes;
#endif

// Returns the row of this invocation. If it is written.w or more, there is none.
int row_of_pass()
{
	ivec2 at = ivec2(gl_FragCoord.xy);
	return written.y + at.x + COLUMNS * at.y;
}

// The undisturbed surface: base and deposited thickness.
struct ground {
	int base, height;
	bool far; // it is out of reach, and `height` is clamped
};

ground ground_at(int x, int y)
{
	ivec3 post = ivec3(x, y, zero.z);
	ground g;
	g.base = imageLoad(bases, post).r;
	int d = g.base - zero.x;
	bool wraps = ((g.base ^ zero.x) & (g.base ^ d)) < 0;
	d = wraps ? (g.base < 0 ? -FAR : FAR) : d;
	g.far = abs(d) >= FAR;
	g.height = clamp(4 * clamp(d, -FAR, FAR) - zero.y + imageLoad(heaps, post).r, -FAR_UNITS, FAR_UNITS);
	return g;
}

float rise_between(ground low, ground at, ground high)
{
	bool no_low = low.base == BASE_NODATA, no_high = high.base == BASE_NODATA;
	float rise = float((no_high ? at.base : high.base) - (no_low ? at.base : low.base)) * (4.0 * scale.x);
	return no_low || no_high ? rise : 0.5 * rise;
}

// The normal of the base: soil that heaps up beside a post does not turn the frame in which its sinkage is measured.
vec3 normal_of(ground west, ground at, ground east, ground south, ground north)
{
	vec2 slope = vec2(rise_between(west, at, east), rise_between(south, at, north));
	float steep = dot(slope, slope);
	slope *= min(1.0, STEEPEST * inversesqrt(max(steep, 1.0)));
	float ca = inversesqrt(1.0 + dot(slope, slope));
	return vec3(-slope * ca, ca);
}

soil soil_at(int x, int y)
{
#ifdef SOIL_MAP
	return soils[min(int(texelFetch(classes, ivec3(x, y, zero.z), 0).r), SOILS - 1)];
#else
	return soils[0];
#endif
}

// Returns the stress that the soil bears at sinkage z, m, when it yields; Pa.
float yield_stress(soil s, float by_width, float z)
{
	float k = max(s.a.x * by_width + s.a.y, 0.0); // k_c may be negative, and a patch small
	return z > 0.0 ? min(k * exp2(s.a.z * log2(max(z, UNIT_METRES))), STRESS_MOST) : 0.0;
}

// Returns the plastic part of sinkage z, m: what stays after unloading.
float plastic_part(soil s, float z, float yields)
{
	return max(0.0, z - yields * s.a.w);
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
	int lowest, rests;
};

object object_at(int x, int y, int raised)
{
	object o;
	int rest = imageLoad(rests, ivec3(x, y, zero.z)).r;
	int lowest = min(rest, texelFetch(unders, ivec3(x, y, zero.z), 0).r);
	o.rests = rest == UNDER_NONE ? UNDER_NONE : max(rest, -FAR_UNITS) + raised;
	o.lowest = lowest == UNDER_NONE ? UNDER_NONE : max(lowest, -FAR_UNITS) + raised;
	return o;
}

bool may_touch(ground g, object o)
{
	return g.base != BASE_NODATA && o.lowest < g.height;
}

// The new state of a post, and how it bears the object.
struct answer {
	int most;      // the largest sinkage so far, fixed-point units
	float plastic; // its plastic part, m
	float yields;  // yield stress at the largest sinkage, Pa
	int sunk;      // sinkage under the end pose, fixed-point units
	bool touched, held;
	float stress;  // Pa
	float stiff;   // how the stress grows with the sinkage, Pa/m
};

answer answer_of(soil s, float by_width, float ca, ground g, object o, int most)
{
	answer a;
	int deepest = sinkage_of(ca, g, o.lowest);
	a.most = max(most, deepest);
	a.sunk = o.rests != UNDER_NONE ? sinkage_of(ca, g, o.rests) : 0;
	float z = float(a.most) * UNIT_METRES;
	a.yields = yield_stress(s, by_width, z);
	a.plastic = plastic_part(s, z, a.yields);
	// The stress grows linearly, from 0 at the plastic sinkage to the yield stress at the largest one.
	float elastic = max(z - a.plastic, 1e-9), sunk = float(a.sunk) * UNIT_METRES;
	a.touched = deepest > 0 && (deepest == a.most || float(deepest) * UNIT_METRES > a.plastic);
	a.held = a.sunk > 0 && (a.sunk == a.most || sunk > a.plastic);
	bool flows = a.sunk == a.most;
	a.stress = !a.held ? 0.0 : flows ? a.yields : a.yields * clamp((sunk - a.plastic) / elastic, 0.0, 1.0);
	a.stiff = !a.held ? 0.0 : flows ? a.yields * s.a.z / max(z, UNIT_METRES) : a.yields / elastic;
	return a;
}

vec3 from_centre(int x, int y, object o, int raised)
{
	return vec3(place.xy + scale.y * vec2(x, y), float(o.rests - raised) * UNIT_METRES);
}

// Returns the motion of the object's surface relative to the ground during the contact, m. `at`: place from the centre.
vec3 way_of_surface(vec3 at)
{
	return way.xyz + cross(spin.xyz, at);
}

// Returns the additional stress of damping: soil that is pushed down fast; Pa.
float damped(soil s, vec3 at, vec3 normal)
{
	return s.b.w * max(0.0, -dot(way.xyz + cross(rolls.xyz, at), normal)) * way.w;
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
