// Clear-day sky: horizon haze to zenith blue, warmer and brighter round the sun.
float haze_glow(vec3 direction)
{
	float toward = max(dot(direction, sun.xyz), 0.0);
	return toward * toward * toward;
}

vec3 haze_colour(float glow)
{
	return mix(vec3(0.50, 0.62, 0.76), vec3(0.95, 0.83, 0.66), 0.55 * glow);
}

vec3 sky_colour(vec3 direction)
{
	float height = max(direction.z, 0.0);
	vec3 zenith = vec3(0.075, 0.19, 0.50), middle = vec3(0.22, 0.42, 0.74);
	vec3 colour = mix(middle, zenith, 1.0 - exp(-2.2 * height));
	return mix(colour, haze_colour(haze_glow(direction)), exp(-7.0 * height));
}

vec3 sky_with_sun(vec3 direction)
{
	float toward = max(dot(direction, sun.xyz), 0.0);
	float glow = 0.25 * pow(toward, 24.0) + 0.6 * pow(toward, 400.0);
	float disc = smoothstep(0.99985, 0.99993, toward) * 20.0;
	return sky_colour(direction) + vec3(1.0, 0.86, 0.66) * (glow + disc);
}
