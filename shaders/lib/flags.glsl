// The flags of a block: bit 0: soil still moves in it. Eight more bits: soil moves near that side or corner. With TOUCHED also
// 16 bits from bit 16 on: which sixteenths of the block changed.

layout(std430, binding = 1) buffer flags {
	uint flag_words[]; // one for each block, in the order of the list
};

const int BLOCK = 32; // SOIL_BLOCK

// Sets the flags of a post that moves. at: its place in its block; near: so many posts from a side count as near it.
void flag_post(ivec2 at, int word, int near)
{
	bvec2 low = lessThan(at, ivec2(near)), high = greaterThanEqual(at, ivec2(BLOCK - near));
	uint bits = 1u | (low.x ? 2u : 0u) | (high.x ? 4u : 0u) | (low.y ? 8u : 0u) | (high.y ? 16u : 0u) |
		    (low.x && low.y ? 32u : 0u) | (high.x && low.y ? 64u : 0u) | (low.x && high.y ? 128u : 0u) |
		    (high.x && high.y ? 256u : 0u);
	if ((flag_words[word] & bits) != bits)
		atomicOr(flag_words[word], bits);
}

#ifdef TOUCHED
// Sets the flag of the post's square of 8 x 8 posts, from the south-west.
void flag_changed(ivec2 at, int word)
{
	uint part = 65536u << (at.y / 8 * 4 + at.x / 8);
	if ((flag_words[word] & part) == 0u)
		atomicOr(flag_words[word], part);
}
#endif
