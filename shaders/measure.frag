#version 450 core
// What the ground is at a pixel, as numbers: its normal, its height and its soil. The slope is computed from the posts, as light sees
// it in terrain.frag.
#include "lib/picture.glsl"
#include "lib/slope.glsl"

in vec2 post;
in vec3 place;
#ifdef LEVEL0
in vec2 broad; // slope of the ground without offsets
#endif
// x, y: of the normal, east and north; z: height above the eye, metres; w: 1 + class of the soil
layout(location = 0) out vec4 measured;

layout(binding = 0, r32i) readonly uniform iimage2D base_posts;
#define BASE_POST(at) imageLoad(base_posts, at).r
#ifdef OFFSET
layout(binding = 1, r32i) readonly uniform iimage2D offset_posts;
#define OFFSET_POST(at) imageLoad(offset_posts, at).r
#endif
#ifdef CLASSES
layout(binding = 5) uniform usampler2D class_map;
#endif

void main()
{
#ifdef LEVEL0
	vec2 gradient = broad;
#else
	vec2 gradient = slope_of_base(SLOPE_POSTS(BASE_POST, post, tile.x), post, tile.x) * (base_metre / origin.z);
#endif
#ifdef OFFSET
	gradient += slope_of_offset(SLOPE_POSTS(OFFSET_POST, post, tile.x), post, tile.x).gradient * (offset_metre / origin.z);
#endif
	uint soil = 0u;
#ifdef CLASSES
	soil = texelFetch(class_map, clamp(ivec2(floor(post + 0.5)), ivec2(0), ivec2(tile.x)), 0).r;
#endif
	measured = vec4(normalize(vec3(-gradient, 1.0)).xy, place.z, 1.0 + float(soil));
}
