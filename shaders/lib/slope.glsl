// The slope of the ground between posts. It is the gradient of a quadratic B-spline over nine posts of a map of integers, and is
// continuous across cells. Fragment shaders read the nine posts one by one from an image, since a software renderer does that much
// faster than a texture gather. Vertex shaders read them from a texture, since a driver need not give them images.
struct slope_of_map {
	vec2 gradient; // east and north, units of the map for each post
	float value;   // units of the map
};

#define SLOPE_NODATA int(0x80000000)

// Returns the weights of three neighbouring posts along an axis. f: place from the middle post, -0.5 .. 0.5. first, last: the middle
// post is on the tile's edge, so the post before it, or after it, is missing. Then the other two get its weight, as if the ground went
// on beyond the edge with the same slope.
vec3 slope_weights(float f, bool first, bool last)
{
	float before = 0.5 - f, after = 0.5 + f;
	vec3 w = vec3(0.5 * before * before, 0.75 - f * f, 0.5 * after * after);
	w = first ? vec3(0.0, w.y + 2.0 * w.x, w.z - w.x) : w;
	return last ? vec3(w.x - w.z, w.y + 2.0 * w.z, 0.0) : w;
}

float slope_along(vec3 posts, float f, bool first, bool last)
{
	float before = posts.y - posts.x, after = posts.z - posts.y;
	return mix(first ? after : before, last ? before : after, 0.5 + f);
}

// Returns the slope at the place `f` from post `c`, -0.5 .. 0.5 along each axis. south, row, north: the three rows of posts around
// `c`, each from west to east. Posts beyond the tile's edge are not used; they may have any value.
slope_of_map slope_between(ivec2 c, vec2 f, vec3 south, vec3 row, vec3 north, int cells)
{
	bvec2 first = equal(c, ivec2(0)), last = equal(c, ivec2(cells));
	vec3 weight_x = slope_weights(f.x, first.x, last.x), weight_y = slope_weights(f.y, first.y, last.y);
	vec3 by_column = weight_y.x * south + weight_y.y * row + weight_y.z * north;
	vec3 by_row = vec3(dot(weight_x, south), dot(weight_x, row), dot(weight_x, north));
	slope_of_map slope;
	slope.gradient = vec2(slope_along(by_column, f.x, first.x, last.x), slope_along(by_row, f.y, first.y, last.y));
	slope.value = dot(weight_y, by_row);
	return slope;
}

// Returns the height of a post above the middle one. The difference is small, so a float holds it exactly. A post without data
// counts as level with the middle one.
float slope_post(int post, int middle)
{
	return post == SLOPE_NODATA ? 0.0 : float(post - middle);
}

// Nine posts of a map: three rows from the south, each from west to east.
struct slope_posts {
	ivec3 south, row, north;
};

// Returns the post that is `way` from the one nearest to `at`, or the one at the tile's edge before it.
ivec2 slope_near(vec2 at, int cells, ivec2 way)
{
	ivec2 middle = clamp(ivec2(floor(at + 0.5)), ivec2(0), ivec2(cells));
	return clamp(middle + way, ivec2(0), ivec2(cells));
}

// Reads the nine posts around `at`. READ(post): a macro that reads one post of the map. It is a macro since GLSL cannot hand an image
// to a function portably: NVIDIA's compiler refuses to read an image that is a parameter.
#define SLOPE_ROW(READ, at, cells, y) \
	ivec3(READ(slope_near(at, cells, ivec2(-1, y))), READ(slope_near(at, cells, ivec2(0, y))), READ(slope_near(at, cells, ivec2(1, y))))
#define SLOPE_POSTS(READ, at, cells) \
	slope_posts(SLOPE_ROW(READ, at, cells, -1), SLOPE_ROW(READ, at, cells, 0), SLOPE_ROW(READ, at, cells, 1))

vec2 slope_of_base(slope_posts posts, vec2 at, int cells)
{
	ivec2 c = slope_near(at, cells, ivec2(0));
	int m = posts.row.y;
	ivec3 s = posts.south, r = posts.row, n = posts.north;
	slope_of_map slope = slope_between(c, at - vec2(c), vec3(slope_post(s.x, m), slope_post(s.y, m), slope_post(s.z, m)),
					   vec3(slope_post(r.x, m), 0.0, slope_post(r.z, m)),
					   vec3(slope_post(n.x, m), slope_post(n.y, m), slope_post(n.z, m)), cells);
	return m == SLOPE_NODATA ? vec2(0.0) : slope.gradient;
}

// As slope_of_base, but every post has data, and the value is returned too.
slope_of_map slope_of_offset(slope_posts posts, vec2 at, int cells)
{
	ivec2 c = slope_near(at, cells, ivec2(0));
	int m = posts.row.y;
	slope_of_map slope = slope_between(c, at - vec2(c), vec3(posts.south - m), vec3(posts.row - m), vec3(posts.north - m), cells);
	slope.value += float(m);
	return slope;
}
