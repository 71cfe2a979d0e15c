// Relief below the source, the same as relief_heights() in src/base/relief.c without classes. tests/gpu/relief.c compares them.

struct relief_band {
	uint key;
	int amplitude;
	int depth; // a cell of the band has 2 << depth posts along a side
	int unused;
	uvec2 cell; // where the tile begins: in which cell,
	uvec2 rest; // and at which of its posts
};

uint relief_mix(uint v)
{
	v ^= v >> 16;
	v *= 0x7feb352du;
	v ^= v >> 15;
	v *= 0x846ca68bu;
	return v ^ (v >> 16);
}

uint relief_edges(uint key, uvec2 p)
{
	return relief_mix(relief_mix(key + p.x) + p.y);
}

int relief_half_height(uint number, int amplitude)
{
	i64 product = i64_mul(2 * int(number) - 65535, amplitude);
	return (product.hi << 16) | int(product.lo >> 16);
}

// Returns by how much one level raises a post of the tile. The unit is 2^-24 m divided by 2^(2 depth), so that no division is needed.
i64 relief_detail(relief_band band, uvec2 post)
{
	uvec2 at = band.rest + post, cell = band.cell + (at >> (band.depth + 1));
	ivec2 u = ivec2(at & uvec2((2u << band.depth) - 1u));
	int q = 1 << band.depth;
	bool south = u.y < q, west = u.x < q;
	ivec2 w = ivec2(west ? u.x : 2 * q - u.x, south ? u.y : 2 * q - u.y);
	uint here = relief_edges(band.key, cell);
	int s = relief_half_height(here & 0xffffu, band.amplitude);
	int l = relief_half_height(here >> 16, band.amplitude);
	int n = relief_half_height(relief_edges(band.key, cell + uvec2(0u, 1u)) & 0xffffu, band.amplitude);
	int r = relief_half_height(relief_edges(band.key, cell + uvec2(1u, 0u)) >> 16, band.amplitude);
	i64 sum = i64_mul(-(s + n + l + r), w.x * w.y);
	sum = i64_add(sum, i64_mul(2 * (south ? s : n), w.x * (q - w.y)));
	return i64_add(sum, i64_mul(2 * (west ? l : r), (q - w.x) * w.y));
}

// Adds a level to the sum of the finer ones. The sum is multiplied by 4 first, since the unit of the next level is a quarter as large.
i64 relief_add(i64 finer, i64 detail)
{
	return i64_add(i64((finer.hi << 2) | int(finer.lo >> 30), finer.lo << 2), detail);
}
