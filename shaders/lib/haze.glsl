// Returns what the air between the eye and a place does. x: share of light that passes. y: 0 .. 1, more where the place lies in the
// direction of the sun.
vec2 haze_between(vec3 place)
{
	float far = length(place), lift = place.z * haze.y;
	// Air becomes thinner with height. This is its mean density on the way to the place.
	float mean = abs(lift) < 1e-3 ? 1.0 : (1.0 - exp(-lift)) / lift;
	return vec2(exp(-haze.x * mean * far), haze_glow(place / far));
}

// Returns the light that reaches the eye. between: from haze_between. Blue is scattered more than red: the shares that pass are about
// x^0.75, x^0.95 and x^1.25.
vec3 through_haze(vec3 light, vec2 between)
{
	vec3 through = between.x * (1.0 + vec3(0.25, 0.05, -0.25) * (1.0 - between.x));
	return light * through + haze_colour(between.y) * (1.0 - through);
}
