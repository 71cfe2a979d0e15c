// Turns light into the colour on a screen: a filmic curve, then noise of less than one step of 8 bits. The noise keeps wide
// gradients from banding. The target's sRGB encoding comes after.
float dither()
{
	// Interleaved gradient noise: no table, even at every scale.
	return fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
}

vec3 tone(vec3 light)
{
	vec3 film = clamp(light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14), 0.0, 1.0);
	// A step of 8 bits is about 2.2 * value^0.55 / 255 wide in light. One root for the three: none is far from green.
	return max(film + dither() * ((0.04 + 2.0 * sqrt(film.g)) / 255.0), 0.0);
}
