// The air between the eye and a place. x: how much light passes; y: how near its direction is to the sun.
vec2 haze_between(vec3 place)
{
	float far = length(place), lift = place.z * haze.y;
	// The mean along the way of air that thins with height.
	float mean = abs(lift) < 1e-3 ? 1.0 : (1.0 - exp(-lift)) / lift;
	return vec2(exp(-haze.x * mean * far), haze_glow(place / far));
}

// Blue is scattered more than red: pass^0.75, pass^0.95, pass^1.25, nearly.
vec3 through_haze(vec3 light, vec2 between)
{
	vec3 through = between.x * (1.0 + vec3(0.25, 0.05, -0.25) * (1.0 - between.x));
	return light * through + haze_colour(between.y) * (1.0 - through);
}
