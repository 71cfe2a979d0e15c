// Noise from a map that holds each texel's 2 x 2 neighbours in its four channels: one fetch is a bilinear
// sample, with its slope.
layout(binding = 4) uniform sampler2D noise_map;

#define NOISE_SIZE 256

// Value in x (-0.5 .. 0.5), its slope in y and z (a pattern's side), of a pattern `scale` metres wide.
vec3 noise_at(vec2 metres, float scale)
{
	vec2 at = metres * (float(NOISE_SIZE) / scale), cell = floor(at), part = at - cell;
	vec4 q = texelFetch(noise_map, ivec2(cell) & (NOISE_SIZE - 1), 0) - 0.5;
	vec2 row = mix(q.xz, q.yw, part.x);
	return vec3(mix(row.x, row.y, part.y),
		    float(NOISE_SIZE) * vec2(mix(q.y - q.x, q.w - q.z, part.y), row.y - row.x));
}

// The same look at every distance: the scale follows the size of a pixel on the ground.
vec3 noise_near(vec2 metres, float log_pixel)
{
	float size = clamp(log_pixel + 8.6, 1.0, 13.0), whole = floor(size), scale = exp2(whole);
	return mix(noise_at(metres, scale), noise_at(metres, 2.0 * scale), size - whole);
}
