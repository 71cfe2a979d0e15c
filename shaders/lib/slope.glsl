// The ground's slope between posts: the gradient of the quadratic B-spline through a map of integers,
// continuous across cells.
struct slope_of_map {
	vec2 gradient; // units a post
	float value;   // units
};

#define SLOPE_NODATA int(0x80000000)

// Of the 3 x 3 posts around `c`: those of its four corners, relative to it, as gathered (north-west,
// north-east, south-east, south-west), and the point's place `f` from it.
slope_of_map slope_between(vec2 c, vec2 f, vec4 sw, vec4 se, vec4 nw, vec4 ne, float cells)
{
	slope_of_map slope;
	vec3 west = vec3(sw.w, sw.x, nw.x), centre = vec3(sw.z, 0.0, nw.y), east = vec3(se.z, se.y, ne.y);
	// Beyond the tile's edge the ground goes on as it came.
	west = c.x == 0.0 ? 2.0 * centre - east : west;
	east = c.x == cells ? 2.0 * centre - west : east;
	vec3 south = vec3(west.x, centre.x, east.x), north = vec3(west.z, centre.z, east.z);
	vec3 row = vec3(west.y, centre.y, east.y);
	south = c.y == 0.0 ? 2.0 * row - north : south;
	north = c.y == cells ? 2.0 * row - south : north;

	vec2 before = 0.5 - f, after = 0.5 + f;
	vec3 weight_x = vec3(0.5 * before.x * before.x, 0.75 - f.x * f.x, 0.5 * after.x * after.x);
	vec3 weight_y = vec3(0.5 * before.y * before.y, 0.75 - f.y * f.y, 0.5 * after.y * after.y);
	vec3 step_x = vec3(-before.x, -2.0 * f.x, after.x), step_y = vec3(-before.y, -2.0 * f.y, after.y);
	vec3 by_row = weight_y.x * south + weight_y.y * row + weight_y.z * north;
	slope.gradient.x = dot(step_x, by_row);
	slope.gradient.y = dot(weight_x, step_y.x * south + step_y.y * row + step_y.z * north);
	slope.value = dot(weight_x, by_row);
	return slope;
}

// Posts without data count as level with the nearest.
vec4 slope_part(isampler2D map, vec2 corner, float scale, int middle)
{
	ivec4 q = textureGather(map, corner * scale);
	return mix(vec4(q - middle), vec4(0.0), equal(q, ivec4(SLOPE_NODATA)));
}

slope_of_map slope_of_base(isampler2D map, vec2 at, int cells)
{
	vec2 c = clamp(floor(at + 0.5), vec2(0.0), vec2(float(cells)));
	float scale = 1.0 / float(cells + 1);
	int middle = textureGather(map, c * scale).y;
	return slope_between(c, at - c, slope_part(map, c, scale, middle), slope_part(map, c + vec2(1.0, 0.0), scale, middle),
			     slope_part(map, c + vec2(0.0, 1.0), scale, middle), slope_part(map, c + 1.0, scale, middle),
			     float(cells));
}

// Offsets are never without data.
slope_of_map slope_of_offset(isampler2D map, vec2 at, int cells)
{
	vec2 c = clamp(floor(at + 0.5), vec2(0.0), vec2(float(cells)));
	float scale = 1.0 / float(cells + 1);
	ivec4 sw = textureGather(map, c * scale);
	slope_of_map slope = slope_between(c, at - c, vec4(sw - sw.y), vec4(textureGather(map, (c + vec2(1.0, 0.0)) * scale) - sw.y),
					   vec4(textureGather(map, (c + vec2(0.0, 1.0)) * scale) - sw.y),
					   vec4(textureGather(map, (c + 1.0) * scale) - sw.y), float(cells));
	slope.value += float(sw.y);
	return slope;
}
