// Counts since the start, 64 bits each: struct deform_tally in src/deform/deform.h.

layout(std430, binding = 0) buffer tally {
	uint tally_words[10]; // compacted, refused, confined, sunk, slid: lo, hi
};

const int COMPACTED = 0, REFUSED = 2, CONFINED = 4; // the others are of soil that bears

void tally_add(int what, uint amount)
{
	uint before = atomicAdd(tally_words[what], amount);
	if (before + amount < before)
		atomicAdd(tally_words[what + 1], 1u);
}

// Adds a signed number of 64 bits: low, high word.
void tally_sum(int what, uvec2 words)
{
	uint before = atomicAdd(tally_words[what], words.x);
	atomicAdd(tally_words[what + 1], words.y + uint(before + words.x < before));
}
