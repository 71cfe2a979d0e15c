// Imagery: the colours that the store has for the ground. Pages of pixels lie in one texture. A draw has a table of the pages that its
// pixels can show (src/render/imagery_pages.c). For each level it has two vectors in the block of parameters, and for each page a texel.
//
// A pixel shows one level, chosen at random between the two whose pixels are a little smaller and a little larger than it. That is cheaper
// than blending them. Before it: lib/pixel.glsl and lib/tone.glsl.

layout(binding = 7) uniform sampler2DArray imagery_map;
// A texel for each page of the tables. Software GL reads a texture faster than a buffer.
// x: its pixels for each one of the level. It is less than 1 if a coarser page is shown there.
// yz: where its south-west pixel lies. w: its layer, or -1.
layout(binding = 8) uniform sampler2D imagery_pages;

// Returns log2 of the size of a pixel on the ground, metres. It is never less than that of the pixel's width.
float imagery_pixel(vec3 place, vec2 gradient)
{
	return max(ground_pixel(place, gradient), 0.5 * ground_log2(dot(place, place)) + pattern.w);
}

// Returns the light of a colour in sRGB that is multiplied by its opacity, as its alpha is. A cubic is exact to half a step of 8 bits.
vec3 imagery_light(vec4 colour)
{
	vec3 coded = colour.rgb / max(colour.a, 1.0 / 512.0);
	return coded * (coded * (coded * 0.305306011 + 0.682171111) + 0.012522878) * colour.a;
}

// Returns the colour of the imagery at a place in the tile, times its opacity, and that.
vec4 imagery_at(vec2 post, float log_pixel)
{
	float fine = max(log_pixel - layer.y + dither() + 0.5, 0.0), cells = float(tile.x);
	int head = 2 * int(clamp(fine - layer.z, 0.0, layer.w));
	vec4 level = imagery_levels[head], box = imagery_levels[head + 1];
	vec2 at = post * level.x + level.yz;
	vec2 page = clamp(floor(at * (1.0 / cells)), box.xy, box.zw), part = clamp(at - page * cells, 0.0, cells), from = page - box.xy;
	int number = int(level.w + from.y * (box.z - box.x + 1.0) + from.x);
	vec4 entry = texelFetch(imagery_pages, ivec2(number & 255, number >> 8), 0);
	// Rounded, so that the bits do not depend on where the page lies.
	vec2 texel = floor(part * entry.x * 256.0 + 0.5) * (1.0 / 256.0) + entry.yz;
	vec4 colour = textureLod(imagery_map, vec3(texel / float(textureSize(imagery_map, 0).x), max(entry.w, 0.0)), 0.0);
	return entry.w < 0.0 ? vec4(0.0) : vec4(imagery_light(colour), colour.a);
}

// Returns how much of the picture is left where the ground was disturbed. What was touched shows its soil: its disturbance is at least 0.38.
float imagery_left(float disturbance)
{
	return 1.0 - min(2.0 * disturbance, 1.0);
}
