// An elastic sheet over a window: what its passes share (soil/kinematic/sheet.h).

#include "lib/int64.glsl"
#include "lib/window.glsl"

layout(std140, binding = 0) uniform params {
	ivec4 zero;    // lo, hi: the window's zero height, fixed-point units from the store's reference; the layer; 1: the body is taken away
	ivec4 written; // posts that may change: first, one behind the last
	ivec4 window;  // posts in x and y; the reach; the colour of the half round: 0 or 1
	uvec4 relax;   // 2^-31: over-relaxation times the weight of the neighbours' sum, of 1 to 4 neighbours
	uvec4 law;     // the same without a neighbour; over-relaxation less 1, 2^-31; the yield, fixed-point units; 2^-31: the share beyond it that stays
};

const int SHEET_BITS = 6;          // more binary digits of a deflection while it is computed
const int SHEET_MOST = 1 << 23;    // fixed-point units
const int DEFLECTION_MOST = (SHEET_MOST << SHEET_BITS) - 1;

// A post of the texture `holders`. Its low 29 bits are how deep the body holds the post at least, as finely as its deflection. Above them is what holds
// it. Posts that move have one more than the number of their neighbours with ground there.
const uint DEPTH_MASK = (1u << 29) - 1u, OF_OTHERS = 6u, OF_THIS = 7u, MOVES_LAST = 5u;

bool is_written(ivec2 post)
{
	return all(greaterThanEqual(post, written.xy)) && all(lessThan(post, written.zw));
}

int deflection_of(int held)
{
	return clamp(held >> 1, 0, SHEET_MOST - 1);
}

// Returns the offset of the sheet's own surface.
int surface_of(int offset, int deflection)
{
	return clamp(offset, -OFFSET_LIMIT, OFFSET_LIMIT) + deflection;
}

// Returns how far an envelope is below an offset.
i64 depth_below(int base, int envelope, int offset)
{
	i64 ground = i64_sub(i64_shl(i64_from(base), 2), i64(zero.y, uint(zero.x)));
	return i64_sub(i64_add(ground, i64_from(offset)), i64_from(envelope));
}

// a * b / 2^31, rounded down; it must fit 32 bits.
uint share_of(uint a, uint b)
{
	uint high, low;
	umulExtended(a, b, high, low);
	return (high << 1) | (low >> 31);
}
