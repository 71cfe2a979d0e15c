#version 450 core
// A block of a tile: a grid of posts at a stride, its height fetched per vertex. With GEOMORPH a vertex
// slides to the next coarser stride's surface as it recedes, so that nothing jumps when that is drawn.
#include "lib/picture.glsl"
#ifdef LEVEL0
#define SLOPE_OF_VERTICES
#include "lib/slope.glsl"
#endif
#ifdef TEXTURE
#include "lib/noise.glsl"
#endif
#ifdef FOG
#include "lib/sky.glsl"
#include "lib/haze.glsl"
#endif

#define NODATA int(0x80000000)

layout(binding = 0) uniform isampler2D base_map;
#ifdef OFFSET
layout(binding = 1) uniform isampler2D offset_map;
#endif
#ifdef LEVEL0
layout(binding = 3) uniform isampler2D level0_map;
#endif
// block x, y (10 bits each), log2 of the stride (4), edges with a skirt (4)
layout(std430, binding = 0) readonly buffer blocks {
	uint block[];
};

out vec2 post;      // in the tile's posts
out vec3 place;     // metres relative to the eye
#ifdef LEVEL0
out vec2 broad; // slope of the ground without offsets
#endif
#ifdef TEXTURE
out float region; // noise of kilometres
#endif
#ifdef FOG
out vec2 air;
#endif

// Metres relative to the eye. False where there is no ground.
bool fetch_height(ivec2 at, out float height)
{
	int base = texelFetch(base_map, at, 0).r;
	height = float((base >> 1) - tile.z) * half_base_metre - origin.w;
#ifdef OFFSET
	height += float(texelFetch(offset_map, at, 0).r) * offset_metre;
#endif
	return base != NODATA;
}

#ifdef GEOMORPH
// The surface of the triangles that a stride draws, at any post; `fine` where those touch nodata.
float strided_height(ivec2 at, int stride, float fine)
{
	ivec2 corner = at & ~(stride - 1);
	vec2 part = vec2(at - corner) / float(stride);
	ivec2 beyond = min(corner + stride, ivec2(tile.x));
	float most = max(part.x, part.y), least = min(part.x, part.y);
	float a, b, c;
	bool whole = fetch_height(corner, a);
	whole = fetch_height(part.x >= part.y ? ivec2(beyond.x, corner.y) : ivec2(corner.x, beyond.y), b) && whole;
	whole = fetch_height(beyond, c) && whole;
	return whole ? a * (1.0 - most) + b * (most - least) + c * least : fine;
}

#ifdef REACHES
float reach(int power)
{
	return reaches[power >> 2][power & 3];
}

// Strides are passed over whose reach ends where the next begins: from each it slides to the one that follows it.
float morphed_height(ivec2 at, int stride, float fine)
{
	float far = length(vec3(origin.xy + vec2(at) * origin.z, fine));
	int power = findMSB(stride), most = findMSB(tile.x);
	while (power < most && reach(power + 1) <= far)
		power++;
	float now = 1 << power == stride ? fine : strided_height(at, 1 << power, fine);
	if (power == most)
		return now;
	float end = reach(power + 1), begin = max(0.8 * end, reach(power));
	float blend = clamp((far - begin) / max(end - begin, 1e-6 * end), 0.0, 1.0);
	int next = power + 1;
	while (next < most && reach(next + 1) <= end)
		next++;
	return blend > 0.0 ? mix(now, strided_height(at, 1 << next, fine), blend) : now;
}
#else
float morphed_height(ivec2 at, int stride, float fine)
{
	float far = length(vec3(origin.xy + vec2(at) * origin.z, fine)) / (detail.x * float(stride));
	while (far >= 1.0 && 2 * stride < tile.x) {
		far *= 0.5;
		stride *= 2;
	}
	float blend = clamp((far - 0.8) * 5.0, 0.0, 1.0);
	float now = strided_height(at, stride, fine);
	return blend > 0.0 ? mix(now, strided_height(at, 2 * stride, fine), blend) : now;
}
#endif
#endif

void main()
{
	uint which = block[tile.y + gl_InstanceID];
	int stride = 1 << int(which >> 20 & 15u);
	int side = tile.w + 1, skirt = gl_VertexID - side * side;
	ivec2 cell = ivec2(gl_VertexID % side, gl_VertexID / side);
	float drop = 0.0;
#ifdef SKIRTS
	if (skirt >= 0) {
		int edge = skirt / side, along = skirt % side; // south, north, west, east
		cell = edge == 0 ? ivec2(along, 0) : edge == 1 ? ivec2(along, tile.w) :
		       edge == 2 ? ivec2(0, along) : ivec2(tile.w, along);
		drop = (which >> (24 + edge) & 1u) != 0u ? min(detail.y * float(stride), detail.z) : 0.0;
	}
#endif
	ivec2 at = ivec2(which & 1023u, which >> 10 & 1023u) * tile.w * stride + cell * stride;
	float height;
	bool hole = !fetch_height(at, height);
#ifdef GEOMORPH
	height = morphed_height(at, stride, height);
#endif
#if defined SKIRTS && defined REACHES
	// What meets here is off by no more than is allowed, either side.
	if (drop > 0.0)
		drop = max(drop, 2.0 * detail.w * length(vec3(origin.xy + vec2(at) * origin.z, height)));
#endif
	post = vec2(at);
	place = vec3(origin.xy + post * origin.z, height - drop);
#ifdef LEVEL0
	// Below level 0 posts lie on planes between the source's: the broad shape is that of level 0.
	broad = slope_of_base(level0_map, ground.xy + post * ground.z, tile.x) * (base_metre / ground.w);
#endif
#ifdef TEXTURE
	region = noise_at(pattern.xy + post * pattern.z, 8192.0).x;
#endif
#ifdef FOG
	air = haze_between(place);
#endif
	// A triangle with a corner that is nowhere is not drawn.
	gl_Position = hole ? vec4(uintBitsToFloat(0x7fc00000u)) : project * vec4(place, 1.0);
}
