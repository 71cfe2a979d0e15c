// The colour of the sky in a direction. From the horizon, where haze has its colour, it changes to the colour at the zenith. It is
// brighter around the sun. On a planet without air it is black.
#include "lib/body.glsl"

float haze_glow(vec3 direction)
{
	float toward_sun = max(dot(direction, sun.xyz), 0.0);
	return toward_sun * toward_sun * toward_sun;
}

vec3 haze_colour(float glow)
{
	return mix(horizon * sunlight.w, toward * tint.rgb, haze_turns * glow);
}

vec3 sky_colour(vec3 direction)
{
	float height = max(direction.z, 0.0);
	vec3 colour = mix(middle, zenith, 1.0 - exp(-sky_falls * height)) * sunlight.w;
	return mix(colour, haze_colour(haze_glow(direction)), exp(-haze_falls * height));
}

// Returns the light of a star. The sky is divided into cells, and one cell in about 70 has a star.
float star_light(vec3 direction)
{
	vec3 at = direction * 90.0, cell = floor(at + 0.5), off = at - cell;
	float dice = fract(sin(dot(cell, vec3(12.9898, 78.233, 37.719))) * 43758.5453);
	return dice > 0.985 ? 66.0 * (dice - 0.985) * smoothstep(0.035, 0.01, dot(off, off)) : 0.0;
}

vec3 sky_with_sun(vec3 direction)
{
	float toward_sun = max(dot(direction, sun.xyz), 0.0), edge = 1.0 - sun_edge;
	float glow = pow(toward_sun, 24.0) + 2.4 * pow(toward_sun, 400.0);
	float disc = smoothstep(sun_edge - 0.15 * edge, sun_edge + 0.15 * edge, toward_sun) * 3.0;
	return sky_colour(direction) + halo * tint.rgb * glow + sunlight.rgb * disc + stars * star_light(direction);
}
