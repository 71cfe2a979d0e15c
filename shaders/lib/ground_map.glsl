// The ground's textures, one a layer; src/render/textures.h explains them.
layout(binding = 4) uniform sampler2DArray ground_map;

#define GROUND_WIDE 5.0 // layer of the far texture

// Returns noise that changes over kilometres, -1 .. 1.
float ground_region(vec2 metres)
{
	return 2.0 * textureLod(ground_map, vec3(metres / 8192.0, GROUND_WIDE), 2.0).g - 1.0;
}

// Returns the place of a post in the near texture (xy) and in the far one (zw), in repeats. The textures are turned against the posts
// and against each other, so that no pattern shows. The sizes are RENDER_GROUND_* in src/render/internal.h.
vec4 ground_squares(vec2 post)
{
	return corner_squares + pattern.z * vec4(vec2(2.0 * post.x + post.y, 2.0 * post.y - post.x) / 8.0,
						 vec2(3.0 * post.x + post.y, 3.0 * post.y - post.x) / 512.0);
}
