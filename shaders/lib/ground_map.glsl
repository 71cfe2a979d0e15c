// The ground's textures: src/render/textures.h.
layout(binding = 4) uniform sampler2DArray ground_map;

#define GROUND_WIDE 5.0 // layer

// Noise of kilometres, -1 .. 1.
float ground_region(vec2 metres)
{
	return 2.0 * textureLod(ground_map, vec3(metres / 8192.0, GROUND_WIDE), 2.0).g - 1.0;
}

// Turned against each other and against the posts, by whole numbers: RENDER_GROUND_* in src/render/internal.h.
vec4 ground_squares(vec2 post)
{
	return corner_squares + pattern.z * vec4(vec2(2.0 * post.x + post.y, 2.0 * post.y - post.x) / 8.0,
						 vec2(3.0 * post.x + post.y, 3.0 * post.y - post.x) / 512.0);
}
