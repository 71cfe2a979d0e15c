// False colours of the ground: each pixel has one value, and a ramp gives its colour. Part of the light stays, so that the shape of the
// ground is seen. src/render/layer.c and ramp.c have the same ramps on the CPU, in sRGB.
#define LAYER_OFFSETS 1
#define LAYER_DISTURBANCE 2
#define LAYER_HEIGHTS 3
#define LAYER_SLOPES 4
#define LAYER_TILES 5

// Colours of offsets: down from zero (lowered) and up from zero (raised), mixed over the colour of zero (paper). Colours of other
// values: from low to high (rising). levels: colours of tiles by their level.
const vec3 lowered[4] = vec3[4](vec3(150, 205, 255), vec3(55, 130, 235), vec3(75, 50, 195), vec3(62, 0, 105));
const vec3 raised[4] = vec3[4](vec3(255, 226, 140), vec3(253, 160, 50), vec3(222, 70, 25), vec3(125, 0, 32));
const vec3 paper = vec3(232, 230, 224);
const vec3 rising[5] = vec3[5](vec3(69, 0, 84), vec3(59, 82, 140), vec3(33, 145, 140), vec3(94, 201, 97), vec3(252, 232, 36));
const vec3 levels[6] = vec3[6](vec3(0.90, 0.60, 0.00), vec3(0.34, 0.71, 0.91), vec3(0.00, 0.62, 0.45),
			       vec3(0.94, 0.89, 0.26), vec3(0.00, 0.45, 0.70), vec3(0.80, 0.47, 0.65));

struct layer_values {
	float moved, disturbance, height, steep; // metres, 0 to 1, metres, rise a metre
};

vec3 layer_linear(vec3 coded)
{
	return mix(coded / 12.92, pow((coded + 0.055) / 1.055, vec3(2.4)), step(0.04045, coded));
}

vec3 layer_rising(float at)
{
	float place = clamp(at, 0.0, 1.0) * 4.0;
	int below = min(int(place), 3);
	return layer_linear(mix(rising[below], rising[below + 1], place - float(below)) / 255.0);
}

vec3 layer_apart(float at)
{
	float signed_size = clamp(2.0 * at - 1.0, -1.0, 1.0), size = abs(signed_size), place = size * 3.0;
	int below = min(int(place), 2);
	vec3 colour = signed_size < 0.0 ? mix(lowered[below], lowered[below + 1], place - float(below)) :
					  mix(raised[below], raised[below + 1], place - float(below));
	return layer_linear(mix(paper, colour, min(1.6 * sqrt(size), 0.94)) / 255.0);
}

// Returns the colour of a tile by its level. Neighbouring tiles differ in brightness, and a line separates them.
vec3 layer_tile()
{
	int code = int(layer.w), level = (code >> 1) % 6;
	vec2 edge = min(post, vec2(tile.x) - post) / max(fwidth(post), vec2(1e-6));
	float line = 1.0 - smoothstep(0.5, 1.5, min(edge.x, edge.y));
	return layer_linear(levels[level]) * ((code & 1) != 0 ? 0.75 : 1.0) * (1.0 - 0.7 * line);
}

vec4 layer_colour(layer_values values, float facing)
{
	int kind = int(layer.x);
	vec3 flat_colour;
	if (kind == LAYER_TILES) {
		flat_colour = layer_tile();
	} else {
		float value = kind == LAYER_OFFSETS ? values.moved : kind == LAYER_DISTURBANCE ? values.disturbance :
			      kind == LAYER_HEIGHTS ? values.height : degrees(atan(values.steep));
		float at = (value - layer.y) * layer.z;
		flat_colour = kind == LAYER_OFFSETS ? layer_apart(at) : layer_rising(at);
	}
	return vec4(flat_colour * (0.35 + 0.65 * facing), 1.0);
}
