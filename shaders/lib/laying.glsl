// What the passes that lay down carried soil hand on (SOIL.md, "Laying"), and how a contact's soil is measured for them.
// Each of these passes has one invocation for each row of posts. All numbers are whole.
// Places in the body's frame are in 2^-16 post; x points where the body heads, y to its left.

#include "lib/bias.glsl"
#include "lib/rows.glsl"

const int FACES = 4; // of the patch's rectangle: ahead, behind, left, right
const int HOLLOW_MOST = 1 << 23;
const int NO_WAY = 1023;

struct laying_state {
	uint reached[4];       // lib/reached.glsl
	uint carried[2];       // lo, hi: fixed-point units
	uint givers;           // posts that carry soil
	uint deep;             // depth of the hollow, fixed-point units
	uint given_soils;      // of the posts that carry soil: a bit for each class
	uint ends[FACES];      // of the patch: BIAS + x, BIAS - x, BIAS + y, BIAS - y; 0: there is no patch
	uint ended[2];         // invocations that ended each of the last two passes
	uint weights[FACES];   // sums
	uint heaviest[FACES];  // weight << 20 | y << 10 | x of the heaviest post
	uint parts[2 * FACES]; // lo, hi: soil of each face, fixed-point units
	uint rates[2 * FACES]; // lo, hi: soil for each unit of weight, 2^-RATE_BITS fixed-point units
	uint laid[2 * FACES];  // lo, hi
};

layout(std430, binding = 4) coherent restrict buffer laying {
	laying_state handed;
};

// Adds posts of a row to those that the contact reached: from the first to before the last.
void reach(int y, int first, int last)
{
	if (first >= last)
		return;
	atomicMax(handed.reached[0], uint(BIAS + last - 1));
	atomicMax(handed.reached[1], uint(BIAS - first));
	atomicMax(handed.reached[2], uint(BIAS + y));
	atomicMax(handed.reached[3], uint(BIAS - y));
}

// Returns the place of a post in the body's frame. frame: place of post (0, 0); axis: the x axis, 2^-16
ivec2 frame_of(ivec2 frame, ivec2 axis, int x, int y)
{
	return frame + ivec2(x * axis.x + y * axis.y, y * axis.x - x * axis.y);
}

// Returns how deep the hollow counts at a post. carries: soil that the post carries; offset: after the contact; both in fixed-point units.
// share: of the depth, that is laid, 2^-16.
int depth_of(int carries, int offset, int share)
{
	int depth = clamp(-offset, 0, HOLLOW_MOST);
	return max(carries, int((uint(depth >> 8) * uint(share)) >> 8));
}

// Adds the touched posts of a row. soil: lo, hi; at: places of the first and the last of them in the frame. of_classes: of the posts that
// carry soil: a bit for each class.
void measured(uvec2 soil, uint count, uint of_classes, int deepest, ivec2 at[2])
{
	uint before = atomicAdd(handed.carried[0], soil.x);
	atomicAdd(handed.carried[1], soil.y + uint(before + soil.x < before));
	atomicAdd(handed.givers, count);
	atomicOr(handed.given_soils, of_classes);
	atomicMax(handed.deep, uint(deepest));
	ivec2 least = min(at[0], at[1]), most = max(at[0], at[1]);
	atomicMax(handed.ends[0], uint(BIAS + most.x));
	atomicMax(handed.ends[1], uint(BIAS - least.x));
	atomicMax(handed.ends[2], uint(BIAS + most.y));
	atomicMax(handed.ends[3], uint(BIAS - least.y));
}
