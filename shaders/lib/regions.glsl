// The ground of a window, read from the tiles of its fixed regions: two by two of them at most (src/deform/fixed.c).

layout(binding = 0) uniform isampler2D region_bases[4];
layout(binding = 4) uniform isampler2D region_offsets[4];

layout(std140, binding = 0) uniform params {
	ivec4 window;   // posts in x and y; the layer; cells of a tile
	ivec4 written;  // posts that the contact writes: first, one behind the last
	ivec4 own;      // x, y: from a post in the window to that in the region that this pass writes
	ivec4 split;    // first posts of the eastern and of the northern regions; bits of the regions that have a base; that have offsets
	ivec4 places[4]; // x, y: the same as `own` of each region: south-west, south-east, north-west, north-east
};

bool is_written(ivec2 post)
{
	return all(greaterThanEqual(post, written.xy)) && all(lessThan(post, written.zw));
}

int region_of(ivec2 post)
{
	return int(post.x >= split.x) + 2 * int(post.y >= split.y);
}

int region_base(ivec2 post)
{
	int k = region_of(post);
	ivec2 at = post + places[k].xy;
	if ((split.z >> k & 1) == 0 || any(lessThan(at, ivec2(0))) || any(greaterThan(at, ivec2(window.w))))
		return BASE_NODATA;
	switch (k) {
	case 0: return texelFetch(region_bases[0], at, 0).r;
	case 1: return texelFetch(region_bases[1], at, 0).r;
	case 2: return texelFetch(region_bases[2], at, 0).r;
	default: return texelFetch(region_bases[3], at, 0).r;
	}
}

int region_offset(ivec2 post)
{
	int k = region_of(post);
	ivec2 at = post + places[k].xy;
	if ((split.w >> k & 1) == 0 || any(lessThan(at, ivec2(0))) || any(greaterThan(at, ivec2(window.w))))
		return 0;
	switch (k) {
	case 0: return texelFetch(region_offsets[0], at, 0).r;
	case 1: return texelFetch(region_offsets[1], at, 0).r;
	case 2: return texelFetch(region_offsets[2], at, 0).r;
	default: return texelFetch(region_offsets[3], at, 0).r;
	}
}
