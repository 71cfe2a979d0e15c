// Pictures whose colour agrees with their depth: the light is that of the triangle that is drawn, and textures paint no relief.

// Returns the slope of the triangle that is drawn at this pixel, east and north. A triangle that has no area keeps the slope given.
vec2 slope_of_triangle(vec3 place, vec2 otherwise)
{
	vec3 outward = cross(dFdx(place), dFdy(place));
	float least = 1e-3 * (abs(outward.x) + abs(outward.y));
	return abs(outward.z) > least ? -outward.xy / outward.z : otherwise;
}
