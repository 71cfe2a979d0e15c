// Shared by the passes that lay down carried soil (SOIL.md, "Laying"). The last two have one invocation for each row of the window's
// written posts. The invocation that ends last computes what the next pass needs. All numbers are whole.
// Lengths are in 2^-6 post. Places in the body's frame are in 2^-16 post; x points where the body heads, y to its left.
// Define SOILS: number of soil classes that the parameters have room for.

#include "lib/int64.glsl"
#include "lib/laying.glsl"
#include "lib/root.glsl"
#include "lib/tally.glsl"
#include "lib/window.glsl"

const int RATE_BITS = 20;
const int HALF_POST = 1 << 15;
const int NARROWEST = 128; // two posts, so that there is a post in it

layout(std140, binding = 0) uniform params {
	ivec4 place;   // the layer; 1: the soil goes around the patch, 0: to its faces; the widest band
	ivec4 written; // the posts this window writes: first, one behind the last
	ivec4 shadow;  // of those, the posts that the object can be above
	// x, y: post (0, 0) in the frame. z: half the width of a wheel; 0: the width of the patch is used. w: how much the patch's length
	// counts beside its width for the width of a band, 2^-16.
	ivec4 origin;
	ivec4 axis;    // x, y: x axis of the frame, 2^-16. z: beside the patch soil is laid up to this |x|. w: a wheel that goes on
	// lays it from -z over this length; below 0: it rolls backwards, and lays it from z on; 0: along the whole patch
	ivec4 shares;  // of the soil for each face, 2^-16; their sum is 1
	ivec4 soils[SOILS]; // a factor in the square of a band's width, 2^-24 (find_band); share of the depth that is laid, 2^-16
} given;

// Each is fetched once, before the loops.
ivec4 place = given.place, written = given.written, shadow = given.shadow, origin = given.origin, axis = given.axis, shares = given.shares;

// Tells whether this invocation is the last that ends one of the last two passes.
bool is_last(int pass)
{
	memoryBarrier();
	return atomicAdd(handed.ended[pass], 1u) == uint(written.w - written.y - 1);
}

ivec4 rectangle; // around the patch: most and least x, most and least y
int band;        // its width

// Finds both from what was measured. Of the soils that are carried, the least steep one makes the widest band.
void find_band()
{
	int factor = 0;
	for (int i = 0; i < SOILS; i++)
		factor = max(factor, (handed.given_soils >> i & 1u) != 0u ? given.soils[i].x : 0);
	bool wheel = origin.z > 0;
	rectangle.xy = ivec2(int(handed.ends[0]) - BIAS + HALF_POST, BIAS - int(handed.ends[1]) - HALF_POST);
	rectangle.zw = wheel ? ivec2(origin.z, -origin.z) : ivec2(int(handed.ends[2]) - BIAS + HALF_POST, BIAS - int(handed.ends[3]) - HALF_POST);
	uint along = uint(rectangle.x - rectangle.y) >> 10, across = uint(rectangle.z - rectangle.w) >> 10;
	// The cross-section of the soil beside a metre of the patch's contour is this length times the depth.
	uint half_width = ((across * uint(65536 - origin.w)) >> 17) + ((along * uint(origin.w)) >> 17);
	int reaches = int(place.y != 0 ? (along >> 1) * across / (along + across) : half_width);
	i64 square = i64_mul_int(i64_mul(min(int(handed.deep), HOLLOW_MOST), reaches), factor);
	band = min(max(square_root(i64_sar(square, 24)), max(reaches / 4, NARROWEST)), place.z);
}

float least_of(float centre, float reach, int slope)
{
	return slope == 0 ? (abs(centre) > reach ? 1e9 : -1e9) : (centre - sign(float(slope)) * reach) / float(slope);
}

// Returns the posts of a row that may lie in a band: first, one behind the last.
ivec2 posts_of_row(int y)
{
	if (place.y != 0)
		return ivec2(written.x, written.z);
	// Posts whose x and y in the frame lie within the rectangle and its bands, or at most one post outside.
	bool ends = shares[0] + shares[1] > 0;
	ivec4 around = rectangle;
	if (axis.w != 0)
		around.xy = ivec2(max(around.x, axis.w > 0 ? axis.w - axis.z : axis.z), min(around.y, axis.w > 0 ? -axis.z : axis.w + axis.z));
	vec2 half_size = 0.5 * vec2(around.xz - around.yw), wide = vec2(float(band << 10));
	vec2 middle = 0.5 * vec2(around.xz + around.yw) - vec2(origin.xy + y * ivec2(axis.y, axis.x));
	vec2 reach = half_size + 65536.0 + (ends ? wide : vec2(0.0, wide.y));
	float first = max(least_of(middle.x, reach.x, axis.x), least_of(middle.y, reach.y, -axis.y));
	float last = min(-least_of(-middle.x, reach.x, axis.x), -least_of(-middle.y, reach.y, -axis.y));
	ivec2 posts = ivec2(max(int(floor(clamp(first, -1e6, 1e6))), written.x), min(int(ceil(clamp(last, -1e6, 1e6))) + 1, written.z));
	// A row that lies whole between the two bands has no such posts.
	int low = frame_of(origin.xy, axis.xy, posts.x, y).y, high = frame_of(origin.xy, axis.xy, posts.y, y).y;
	bool between = !ends && max(low, high) < rectangle.z && min(low, high) > rectangle.w;
	return between ? ivec2(0) : posts;
}

i64 words(uint lo, uint hi)
{
	return i64(int(hi), lo);
}

// The profile of a band: it rises from both edges, and is level in the middle third.
int profile(int from_edge)
{
	return min(min(from_edge, band - from_edge), band / 3);
}
