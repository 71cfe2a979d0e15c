// Where the last iteration changed something in a block: its own bit, and one for each side and corner.

layout(std430, binding = 1) buffer flags {
	uint flag_words[]; // a block's, in the order of the list
};

flat in ivec3 block;

const int BLOCK = 32; // DEFORM_BLOCK

void flag_change(ivec2 post, int near)
{
	ivec2 at = post - block.xy;
	bvec2 low = lessThan(at, ivec2(near)), high = greaterThanEqual(at, ivec2(BLOCK - near));
	uint bits = 1u | (low.x ? 2u : 0u) | (high.x ? 4u : 0u) | (low.y ? 8u : 0u) | (high.y ? 16u : 0u) |
		    (low.x && low.y ? 32u : 0u) | (high.x && low.y ? 64u : 0u) | (low.x && high.y ? 128u : 0u) |
		    (high.x && high.y ? 256u : 0u);
	atomicOr(flag_words[block.z], bits);
}
