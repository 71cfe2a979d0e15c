// Shared by the three passes that lay down carried soil (SOIL.md, "Laying"). Each has one invocation for each row of the window's
// written posts. The invocation that ends last computes what the next pass needs. All numbers are whole.
// Lengths are in 2^-6 post. Places in the body's frame are in 2^-16 post; x points where the body heads, y to its left.

#include "lib/int64.glsl"
#include "lib/tally.glsl"
#include "lib/window.glsl"

const int FACES = 4; // of the patch's rectangle: ahead, behind, left, right
const int BIAS = 1 << 30;
const int COLUMNS = 4; // rows side by side in the pass's viewport, so that its blocks of pixels are full
const int RATE_BITS = 20;

layout(std140, binding = 0) uniform params {
	// the layer; 1: the soil goes around the patch, 0: to its faces; share of the depth that is laid, 2^-16; the widest band
	ivec4 place;
	ivec4 written; // the posts this window writes: first, one behind the last
	ivec4 shadow;  // of those, the posts that the object can be above
	// x, y: post (0, 0) in the frame. z: half the width of a wheel; 0: the width of the patch is used. w: how much the patch's length
	// counts beside its width for the width of a band, 2^-16.
	ivec4 origin;
	// x, y: x axis of the frame, 2^-16. z: a factor in the square of a band's width, 2^-24 (spread_measure.frag). w: beside the patch
	// soil is laid up to this |x|.
	ivec4 axis;
	ivec4 shares;  // of the soil for each face, 2^-16; their sum is 1
};

layout(std430, binding = 1) coherent restrict buffer laying {
	uint carried[2];       // lo, hi: fixed-point units
	uint givers;         // posts that carry soil
	uint deep;             // depth of the hollow, fixed-point units
	uint ends[FACES];      // of the patch: BIAS + x, BIAS - x, BIAS + y, BIAS - y; 0: there is no patch
	uint ended[3];         // invocations that ended each pass
	int width;             // of a band
	int sides[FACES];      // of the patch's rectangle: most and least x, most and least y
	uint weights[FACES];   // sums
	uint heaviest[FACES];  // weight << 20 | y << 10 | x of the heaviest post
	uint parts[2 * FACES]; // lo, hi: soil of each face, fixed-point units
	uint rates[2 * FACES]; // lo, hi: soil for each unit of weight, 2^-RATE_BITS fixed-point units
	uint laid[2 * FACES];  // lo, hi
};

// Returns the row of this invocation. If it is written.w or more, there is none.
int row_of_pass()
{
	ivec2 at = ivec2(gl_FragCoord.xy);
	return written.y + at.x + COLUMNS * at.y;
}

bool is_last(int pass)
{
	memoryBarrier();
	return atomicAdd(ended[pass], 1u) == uint(written.w - written.y - 1);
}

ivec2 frame_of(int x, int y)
{
	return origin.xy + ivec2(x * axis.x + y * axis.y, y * axis.x - x * axis.y);
}

// Copies of what the passes read from the buffer for every post.
ivec4 rectangle;
int band;

void read_band()
{
	rectangle = ivec4(sides[0], sides[1], sides[2], sides[3]);
	band = width;
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
	vec2 half_size = 0.5 * vec2(rectangle.xz - rectangle.yw), wide = vec2(float(band << 10));
	vec2 middle = 0.5 * vec2(rectangle.xz + rectangle.yw) - vec2(origin.xy + y * ivec2(axis.y, axis.x));
	vec2 reach = half_size + 65536.0 + (ends ? wide : vec2(0.0, wide.y));
	float first = max(least_of(middle.x, reach.x, axis.x), least_of(middle.y, reach.y, -axis.y));
	float last = min(-least_of(-middle.x, reach.x, axis.x), -least_of(-middle.y, reach.y, -axis.y));
	ivec2 posts = ivec2(max(int(floor(clamp(first, -1e6, 1e6))), written.x), min(int(ceil(clamp(last, -1e6, 1e6))) + 1, written.z));
	// A row that lies whole between the two bands has no such posts.
	int low = frame_of(posts.x, y).y, high = frame_of(posts.y, y).y;
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
