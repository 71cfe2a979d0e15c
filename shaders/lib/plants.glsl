// How plants on the ground look. VEGETATION 2: their cover differs between classes of soil.
#if VEGETATION == 2
layout(binding = 5) uniform usampler2D cover_classes;
#endif

const vec3 standing_colour = vec3(0.055, 0.115, 0.022), dry_colour = vec3(0.13, 0.16, 0.045), bent_colour = vec3(0.27, 0.31, 0.13);

// Returns a number from 0 to 1 that looks random, the same each time for the same cell.
float plants_random(ivec2 at)
{
	uint v = uint(at.x) * 0x9e3779b9u ^ uint(at.y) * 0x85ebca6bu;
	v ^= v >> 16;
	v *= 0x7feb352du;
	v ^= v >> 15;
	v *= 0x846ca68bu;
	return float(v >> 8) / 16777216.0;
}

float plants_noise(vec2 at)
{
	ivec2 low = ivec2(floor(at));
	vec2 part = at - vec2(low), soft = part * part * (3.0 - 2.0 * part);
	return mix(mix(plants_random(low), plants_random(low + ivec2(1, 0)), soft.x),
		   mix(plants_random(low + ivec2(0, 1)), plants_random(low + ivec2(1, 1)), soft.x), soft.y);
}

float plants_cover(vec2 post)
{
	int of = 0;
#if VEGETATION == 2
	of = min(int(texelFetch(cover_classes, clamp(ivec2(floor(post + 0.5)), ivec2(0), ivec2(tile.x)), 0).r), 15);
#endif
	return cover[of / 4][of % 4];
}

// Returns the colour of ground with plants. place: metres. Bent stems lie flat and shine; where they are torn there is bare soil.
vec3 overgrown(vec3 soil, vec2 place, float share, float bent, float torn)
{
	float tuft = plants.x * 1.5, pixel = max(fwidth(place.x), fwidth(place.y));
	float fine = plants_noise(place / tuft), broad = plants_noise(place / 3.0), sharp = clamp(tuft / max(pixel, 1e-6), 0.0, 1.0);
	vec3 stems = mix(standing_colour, dry_colour, 0.6 * broad) * mix(1.0, 0.6 + 0.8 * fine, sharp);
	stems = mix(stems, bent_colour * mix(1.0, 0.8 + 0.4 * fine, sharp), 0.75 * bent);
	// Tufts stand where the noise is below their share of the ground. Far away the mean is seen.
	float left = share * (1.0 - torn), here = smoothstep(left + 0.15, left - 0.15, mix(0.15, 0.85, fine));
	return mix(soil, stems, left >= 1.0 ? 1.0 : mix(left, here, sharp * step(0.001, left)));
}
