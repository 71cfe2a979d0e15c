#version 450 core
// A block of a tile: a grid of posts at a stride. Each vertex reads its height. With GEOMORPH a vertex that recedes moves to the
// next coarser stride's post south-west of it, also horizontally, until both coincide. The mesh is then the coarser one. So
// nothing jumps when the coarser mesh is drawn. Where both meshes meet there is no crack and no T-junction.
#include "lib/picture.glsl"
#ifdef LEVEL0
#define SLOPE_OF_VERTICES
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
out vec4 squares; // the place in the ground's textures, near and far
out vec2 country; // noise of kilometres; 0 at the lowest, 1 at the highest, less so where that is no mountain
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
// Metres from the eye from which on a stride of 2^power does. By radii of how far apart its posts are alone, whatever the
// tile: so all that meet at a vertex move it alike.
float reach(int power)
{
#ifdef REACHES
	return reaches[power >> 2][power & 3];
#else
	float apart = origin.z * float(1 << power);
	return apart * (apart <= RUT_CELL ? detail.z : detail.x);
#endif
}

// A vertex of a stride to where it is drawn; false: there is no ground. Strides are passed over whose reach ends where the
// next begins: from each it slides to the one that follows it.
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
	// Beside a hole it stays until the coarser stride is drawn.
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
	// What meets here is off by as much as is allowed, either side; or, where tiles stand in for others, by anything.
	if (drop > 0.0)
		place.z -= max(2.0 * detail.w * length(place), detail.y);
#endif
#ifdef LEVEL0
	// Below level 0 posts lie on planes between the source's: the broad shape is that of level 0.
	broad = slope_of_base(level0_map, ground.xy + post * ground.z, tile.x) * (base_metre / ground.w);
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
	// A triangle with a corner that is nowhere is not drawn.
	gl_Position = ground_here ? project * vec4(place, 1.0) : vec4(uintBitsToFloat(0x7fc00000u));
}
