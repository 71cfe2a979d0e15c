#version 450 core
// A block of a tile: a grid of vertices, one at each post of a stride. Each vertex reads its height from the tile.
//
// With GEOMORPH the mesh changes smoothly to a coarser stride as its distance from the eye grows. Each vertex moves, also horizontally,
// to the next post of the coarser stride on its south-west side. When all have arrived, the mesh is the coarser one, so nothing jumps
// when the coarser one is drawn. Where both meet there is no crack and no T-junction.
#include "lib/picture.glsl"
#ifdef LEVEL0
#include "lib/slope.glsl"
#endif
#ifdef TEXTURE
#include "lib/ground_map.glsl"
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
#define LEVEL0_POST(at) texelFetch(level0_map, at, 0).r
#endif
// block x, y (10 bits each), log2 of the stride (4), edges with a skirt (4)
layout(std430, binding = 0) readonly buffer blocks {
	uint block[];
};

out vec2 post;      // place in the tile, in posts
out vec3 place;     // metres relative to the eye
#if defined SKIRTS && (defined TERRAIN_SHADOW || defined TRUTH)
out float sunk; // metres below the ground's edge: more than 0 on skirts alone
#endif
#ifdef LEVEL0
out vec2 broad; // slope of the ground without offsets
#endif
#ifdef TEXTURE
out vec4 squares; // place in the ground's near texture (xy) and far one (zw)
out vec2 country; // x: noise with wavelengths of kilometres; y: how high the ground is: 0 at the lowest, up to 1 on high mountains
#endif
#ifdef FOG
out vec2 air;
#endif

// Finds the height of a post relative to the eye, metres. Returns false if the post is nodata.
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
// Returns the reach of the stride 2^power: the distance from the eye, in metres, from which on this stride is fine enough. Without a
// pixel error it depends only on the distance between vertices, not on the tile. So all tiles that share a vertex move it alike.
float reach(int power)
{
#ifdef REACHES
	return reaches[power >> 2][power & 3];
#else
	float apart = origin.z * float(1 << power);
	return apart * (apart <= RUT_CELL ? detail.z : detail.x);
#endif
}

// Moves the vertex of a stride to the place where it is drawn. Returns false if there is no ground. First the vertex goes to the
// coarsest stride that is fine enough at its distance. Then it is blended toward the next coarser stride. If two strides have the same
// reach, the finer of them is skipped.
bool morph(ivec2 at, int stride, bool ground, inout float height, out vec2 drawn)
{
	float far = length(vec3(origin.xy + vec2(at) * origin.z, ground ? height : 0.0));
	int power = findMSB(stride), most = findMSB(tile.x) - 1; // a quadrant's vertices stay in it
	ivec2 now = at;
	while (power < most && reach(power + 1) <= far) {
		power++;
		ivec2 onto = at & ~((1 << power) - 1);
		if (onto == now)
			continue;
		now = onto;
		ground = fetch_height(now, height);
		far = length(vec3(origin.xy + vec2(now) * origin.z, ground ? height : 0.0));
	}
	drawn = vec2(now);
	if (power == most)
		return ground;
	float end = reach(power + 1), begin = max(0.8 * end, reach(power));
	float blend = clamp((far - begin) / max(end - begin, 1e-6 * end), 0.0, 1.0);
	int next = power + 1;
	while (next < most && reach(next + 1) <= end)
		next++;
	ivec2 then = at & ~((1 << next) - 1);
	float coarse;
	// If the coarser post is nodata, the vertex stays where it is.
	if (blend > 0.0 && then != now && fetch_height(then, coarse)) {
		drawn = mix(drawn, vec2(then), blend);
		height = mix(height, coarse, blend);
	}
	return ground;
}
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
		drop = float(which >> (24 + edge) & 1u);
	}
#endif
	ivec2 at = ivec2(which & 1023u, which >> 10 & 1023u) * tile.w * stride + cell * stride;
	float height;
	bool ground_here = fetch_height(at, height);
	post = vec2(at);
#ifdef GEOMORPH
	ground_here = morph(at, stride, ground_here, height, post);
#endif
	place = vec3(origin.xy + post * origin.z, height);
#ifdef SKIRTS
	// A skirt covers the gap to the neighbouring tile. Both edges may have the allowed error. If coarser tiles are drawn in place of
	// missing ones, the gap may be larger, so detail.y gives the least depth.
	if (drop > 0.0)
		drop = max(2.0 * detail.w * length(place), detail.y);
	place.z -= drop;
#if defined TERRAIN_SHADOW || defined TRUTH
	sunk = drop;
#endif
#endif
#ifdef LEVEL0
	// Base heights of levels below 0 are interpolated linearly, so their slope would jump at each level-0 post. The slope of the
	// level-0 posts is smooth.
	vec2 level0_post = ground.xy + post * ground.z;
	broad = slope_of_base(SLOPE_POSTS(LEVEL0_POST, level0_post, tile.x), level0_post, tile.x) * (base_metre / ground.w);
#endif
#ifdef TEXTURE
	squares = ground_squares(post);
	country.x = ground_region(pattern.xy + post * pattern.z);
	float rise = (place.z + relief.w - relief.x) * relief.y;
	country.y = min(rise, 0.3) + max(rise - 0.3, 0.0) * relief.z;
#endif
#ifdef FOG
	air = haze_between(place);
#endif
	// A vertex without ground becomes NaN. Triangles with such a corner are not drawn.
	gl_Position = ground_here ? project * vec4(place, 1.0) : vec4(uintBitsToFloat(0x7fc00000u));
}
