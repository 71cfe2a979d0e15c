// What the passes that lay down carried soil hand on (SOIL.md, "Laying"), and how a contact's soil is measured for them. Either the
// contact pass does that or spread_measure.frag. Each of these passes has one invocation for each row of posts. All numbers are whole.
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
	laying_state layings[]; // one for each window of a batch; otherwise one
};
#define LAYING layings[WINDOW]

// Adds posts of a row to those that the contact reached: from the first to before the last.
void reach(int y, int first, int last)
{
	if (first >= last)
		return;
	atomicMax(LAYING.reached[0], uint(BIAS + last - 1));
	atomicMax(LAYING.reached[1], uint(BIAS - first));
	atomicMax(LAYING.reached[2], uint(BIAS + y));
	atomicMax(LAYING.reached[3], uint(BIAS - y));
}

// Returns the place of a post in the body's frame. frame: place of post (0, 0); axis: the x axis, 2^-16
ivec2 frame_of(ivec2 frame, ivec2 axis, int x, int y)
{
	return frame + ivec2(x * axis.x + y * axis.y, y * axis.x - x * axis.y);
}

// Returns how deep the hollow counts at a post. carries: soil that the post carries; offset: after the contact; dug: all that slip has dug
// there; all in fixed-point units. of_dug, share: of that, and of the rest of the depth, that is laid, 2^-16.
int depth_of(int carries, int offset, int dug, int of_dug, int share)
{
	int depth = clamp(-offset, 0, HOLLOW_MOST), part = clamp(dug, 0, depth);
	int counted = int((uint(part >> 8) * uint(of_dug)) >> 8);
	return max(carries, int((uint(depth - counted >> 8) * uint(share)) >> 8) + counted);
}

// Adds the touched posts of a row. soil: lo, hi; at: places of the first and the last of them in the frame. of_classes: of the posts that
// carry soil: a bit for each class.
void measured(uvec2 soil, uint count, uint of_classes, int deepest, ivec2 at[2])
{
	uint before = atomicAdd(LAYING.carried[0], soil.x);
	atomicAdd(LAYING.carried[1], soil.y + uint(before + soil.x < before));
	atomicAdd(LAYING.givers, count);
	atomicOr(LAYING.given_soils, of_classes);
	atomicMax(LAYING.deep, uint(deepest));
	ivec2 least = min(at[0], at[1]), most = max(at[0], at[1]);
	atomicMax(LAYING.ends[0], uint(BIAS + most.x));
	atomicMax(LAYING.ends[1], uint(BIAS - least.x));
	atomicMax(LAYING.ends[2], uint(BIAS + most.y));
	atomicMax(LAYING.ends[3], uint(BIAS - least.y));
}
