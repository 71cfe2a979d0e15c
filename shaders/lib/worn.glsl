// How dark soil is in ruts and where it was disturbed, beside soil that nothing touched. docs/CAMERAS.md has the sources.
#if defined MOON
const float rut_dark = 0.15, mark_dark = 1.0 - 0.70 / 0.85; // in a rut with the darkest mark 0.70 of the light is left
#else
const float rut_dark = 0.45, mark_dark = 0.4; // by eye
#endif

// Returns the albedo of ground with a mark, 0 to 1. On the Earth the darkest mark is that of wet soil. Its film of water reflects 2 % of the
// light above it. It reflects 47 % of what the soil scatters back to the soil (Lekner and Dorf 1988).
vec3 worn(vec3 albedo, float mark)
{
	if (water > 0.0)
		return albedo * mix(vec3(1.0), 0.98 * 0.53 / (1.0 - 0.47 * min(albedo, 1.0)), mark);
	return albedo * (1.0 - mark_dark * mark);
}
