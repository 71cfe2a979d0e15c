// The ground beyond the terrain. Its look goes on as at the terrain's edge, and the air takes its colour as it does the terrain's.
#ifdef MARS
const float planet_radius = 3.39e6; // m
#elif defined MOON
const float planet_radius = 1.7374e6;
#else
const float planet_radius = 6.371e6;
#endif

// Returns the light of ground whose slope is `gradient`, without shadows.
vec3 apron_light(vec3 albedo, vec2 gradient)
{
	vec3 normal = normalize(vec3(-gradient, 1.0));
	return albedo * (sunlight.rgb * max(dot(normal, sun.xyz), 0.0) + mix(groundlight, skylight, 0.5 + 0.5 * normal.z) * sunlight.w);
}
