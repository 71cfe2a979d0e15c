// The ground's slope between posts: the gradient of the quadratic B-spline through a map of integers,
// continuous across cells. Of nine posts: read one by one as an image where pixels ask, which a renderer in
// software does far sooner than it gathers texels; as a texture where vertices do, which have no images.
struct slope_of_map {
	vec2 gradient; // units a post
	float value;   // units
};

#define SLOPE_NODATA int(0x80000000)

// The post whose neighbours count: the nearest that has all of them. Within half a post of a tile's edge that is the next,
// and its patch of the spline goes on.
ivec2 slope_centre(vec2 at, int cells)
{
	return clamp(ivec2(floor(at + 0.5)), ivec2(1), ivec2(cells - 1));
}

// Three rows of posts, from south to north, each from west to east; the place `f` from the middle one.
slope_of_map slope_between(vec2 f, vec3 south, vec3 row, vec3 north)
{
	vec2 before = 0.5 - f, after = 0.5 + f;
	vec3 weight_x = vec3(0.5 * before.x * before.x, 0.75 - f.x * f.x, 0.5 * after.x * after.x);
	vec3 weight_y = vec3(0.5 * before.y * before.y, 0.75 - f.y * f.y, 0.5 * after.y * after.y);
	vec3 by_column = weight_y.x * south + weight_y.y * row + weight_y.z * north;
	vec3 by_row = vec3(dot(weight_x, south), dot(weight_x, row), dot(weight_x, north));
	slope_of_map slope;
	slope.gradient = vec2(mix(by_column.y - by_column.x, by_column.z - by_column.y, after.x),
			      mix(by_row.y - by_row.x, by_row.z - by_row.y, after.y));
	slope.value = dot(weight_y, by_row);
	return slope;
}

// Relative to the middle one: what is small is exact. Posts without data count as level with it.
float slope_post(int post, int middle)
{
	return post == SLOPE_NODATA ? 0.0 : float(post - middle);
}

slope_of_map slope_of_nine(vec2 f, ivec3 south, ivec3 row, ivec3 north)
{
	int m = row.y;
	slope_of_map slope = slope_between(f, vec3(slope_post(south.x, m), slope_post(south.y, m), slope_post(south.z, m)),
					   vec3(slope_post(row.x, m), 0.0, slope_post(row.z, m)),
					   vec3(slope_post(north.x, m), slope_post(north.y, m), slope_post(north.z, m)));
	slope.gradient = m == SLOPE_NODATA ? vec2(0.0) : slope.gradient;
	return slope;
}

#ifdef SLOPE_OF_VERTICES
vec2 slope_of_base(isampler2D map, vec2 at, int cells)
{
	ivec2 c = slope_centre(at, cells);
	return slope_of_nine(at - vec2(c),
			     ivec3(texelFetch(map, c + ivec2(-1, -1), 0).r, texelFetch(map, c + ivec2(0, -1), 0).r,
				   texelFetch(map, c + ivec2(1, -1), 0).r),
			     ivec3(texelFetch(map, c + ivec2(-1, 0), 0).r, texelFetch(map, c, 0).r,
				   texelFetch(map, c + ivec2(1, 0), 0).r),
			     ivec3(texelFetch(map, c + ivec2(-1, 1), 0).r, texelFetch(map, c + ivec2(0, 1), 0).r,
				   texelFetch(map, c + ivec2(1, 1), 0).r))
		.gradient;
}
#else
vec2 slope_of_base(readonly iimage2D map, vec2 at, int cells)
{
	ivec2 c = slope_centre(at, cells);
	return slope_of_nine(at - vec2(c),
			     ivec3(imageLoad(map, c + ivec2(-1, -1)).r, imageLoad(map, c + ivec2(0, -1)).r,
				   imageLoad(map, c + ivec2(1, -1)).r),
			     ivec3(imageLoad(map, c + ivec2(-1, 0)).r, imageLoad(map, c).r, imageLoad(map, c + ivec2(1, 0)).r),
			     ivec3(imageLoad(map, c + ivec2(-1, 1)).r, imageLoad(map, c + ivec2(0, 1)).r,
				   imageLoad(map, c + ivec2(1, 1)).r))
		.gradient;
}

// Offsets are never without data.
slope_of_map slope_of_offset(readonly iimage2D map, vec2 at, int cells)
{
	ivec2 c = slope_centre(at, cells);
	int m = imageLoad(map, c).r;
	slope_of_map slope = slope_between(
		at - vec2(c),
		vec3(imageLoad(map, c + ivec2(-1, -1)).r - m, imageLoad(map, c + ivec2(0, -1)).r - m, imageLoad(map, c + ivec2(1, -1)).r - m),
		vec3(imageLoad(map, c + ivec2(-1, 0)).r - m, 0, imageLoad(map, c + ivec2(1, 0)).r - m),
		vec3(imageLoad(map, c + ivec2(-1, 1)).r - m, imageLoad(map, c + ivec2(0, 1)).r - m, imageLoad(map, c + ivec2(1, 1)).r - m));
	slope.value += float(m);
	return slope;
}
#endif
