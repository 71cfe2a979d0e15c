// The size of a pixel on the ground.

// Returns about log2(x), exact enough to choose a level of a texture.
float ground_log2(float x)
{
	return float(floatBitsToInt(x)) * 1.1920929e-7 - 126.957;
}

// Returns log2 of the size of a pixel on the ground, metres. In a grazing view it is larger. It is then between the pixel's width and
// its length.
float ground_pixel(vec3 place, vec2 gradient)
{
	float square = dot(place, place), facing = max(abs(dot(place, vec3(-gradient, 1.0))), 1e-3 * abs(place.x + place.y));
	return 0.75 * ground_log2(square) - 0.5 * ground_log2(facing) + pattern.w;
}
