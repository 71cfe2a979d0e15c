// Turns light into the colour on a screen. A filmic curve is followed by noise of less than one step of 8 bits. Without the noise, bands
// would show in wide gradients. GL encodes the result as sRGB when it writes it to the target.
float dither()
{
	// Interleaved gradient noise. It needs no table and is evenly distributed at every scale.
	return fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
}

vec3 film_of(vec3 light)
{
	vec3 film = clamp(light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14), 0.0, 1.0);
	// In linear light a step of 8 bits has a width of about 2.2 * value^0.55 / 255. The width for green is used for all three colours,
	// since they do not differ much.
	return max(film + dither() * ((0.04 + 2.0 * sqrt(film.g)) / 255.0), 0.0);
}

#ifndef EXPOSE
// sun.w is the exposure less 1. With LINEAR light is kept as it is: expose.frag exposes it.
vec3 tone(vec3 radiance)
{
#ifdef LINEAR
	return radiance;
#else
	return film_of(radiance * (1.0 + sun.w));
#endif
}
#endif
