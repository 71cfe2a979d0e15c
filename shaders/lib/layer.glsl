// False colours of the ground: one value at a pixel through a ramp, with enough of the light that shape reads.
// The ramps are those of tools/view_legend.c, sRGB.
#define LAYER_OFFSETS 1
#define LAYER_DIRT 2
#define LAYER_HEIGHTS 3
#define LAYER_SLOPES 4
#define LAYER_TILES 5

// Blue below, white, red above; and dark to light.
const vec3 apart[5] = vec3[5](vec3(0.02, 0.19, 0.38), vec3(0.26, 0.58, 0.77), vec3(0.97, 0.97, 0.97),
			      vec3(0.84, 0.38, 0.30), vec3(0.40, 0.00, 0.12));
const vec3 rising[5] = vec3[5](vec3(0.27, 0.00, 0.33), vec3(0.23, 0.32, 0.55), vec3(0.13, 0.57, 0.55),
			       vec3(0.37, 0.79, 0.38), vec3(0.99, 0.91, 0.14));
const vec3 levels[6] = vec3[6](vec3(0.90, 0.60, 0.00), vec3(0.34, 0.71, 0.91), vec3(0.00, 0.62, 0.45),
			       vec3(0.94, 0.89, 0.26), vec3(0.00, 0.45, 0.70), vec3(0.80, 0.47, 0.65));

struct layer_values {
	float moved, dirt, height, steep; // metres, 0 to 1, metres, rise a metre
};

vec3 layer_linear(vec3 coded)
{
	return mix(coded / 12.92, pow((coded + 0.055) / 1.055, vec3(2.4)), step(0.04045, coded));
}

vec3 layer_ramp(vec3 colours[5], float at)
{
	float place = clamp(at, 0.0, 1.0) * 4.0;
	int below = min(int(place), 3);
	return layer_linear(mix(colours[below], colours[below + 1], place - float(below)));
}

// Each level has a colour; neighbours differ in how light they are, and a line is between them.
vec3 layer_tile()
{
	int code = int(layer.w), level = (code >> 1) % 6;
	vec2 edge = min(post, vec2(tile.x) - post) / max(fwidth(post), vec2(1e-6));
	float line = 1.0 - smoothstep(0.5, 1.5, min(edge.x, edge.y));
	return layer_linear(levels[level]) * ((code & 1) != 0 ? 0.75 : 1.0) * (1.0 - 0.7 * line);
}

vec4 layer_colour(layer_values values, vec2 gradient)
{
	int kind = int(layer.x);
	vec3 flat_colour;
	if (kind == LAYER_TILES) {
		flat_colour = layer_tile();
	} else {
		float value = kind == LAYER_OFFSETS ? values.moved : kind == LAYER_DIRT ? values.dirt :
			      kind == LAYER_HEIGHTS ? values.height : degrees(atan(values.steep));
		float at = (value - layer.y) * layer.z;
		if (kind == LAYER_OFFSETS)
			flat_colour = layer_ramp(apart, at);
		else
			flat_colour = layer_ramp(rising, at);
	}
	float facing = max(dot(normalize(vec3(-gradient, 1.0)), sun.xyz), 0.0);
	return vec4(flat_colour * (0.45 + 0.55 * min(facing / sun.z, 1.4)), 1.0);
}
