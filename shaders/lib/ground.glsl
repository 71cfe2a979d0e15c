// The material of the ground and its look. One number gives the material: sand 0, grass 1, soil 2, rock 3, snow 4. A place has at most
// two materials. With SPLAT the classes of the soil map give the material, except where rock shows. With HEAP it is that
// of heap_class. With ONE_SOIL all ground is of the first class, steep and high ground too.
//
// There are two textures. The near one repeats every few metres. A second material of a place shows in its hollows. The far one repeats
// every hundred metres and more, and makes the borders between materials uneven. Both are filtered: details smaller than a pixel
// become their mean.
#include "lib/body.glsl"
#include "lib/ground_map.glsl"
#include "lib/pixel.glsl"
#include "lib/tone.glsl"
#if defined ONE_SOIL && !defined HEAP
#define HEAP
const int heap_class = 0;
#endif
#if defined SPLAT && !defined HEAP
layout(binding = 5) uniform usampler2D class_map;
#endif

// Added to the log2 of a pixel's size in metres, they give the level of each texture to read. They are a little less than log2 of
// texels per metre (RENDER_GROUND_* in src/render/internal.h), so that the ground looks sharper.
#define GROUND_NEAR_LEVEL 7.26
// In pictures whose colour agrees with their depth, stones, blades and ripples have no height, so they are blurred to their mean colour.
#ifdef TRUTH
#define GROUND_LEAST_LEVEL 4.0
#else
#define GROUND_LEAST_LEVEL 0.0
#endif
#define GROUND_FAR_LEVEL 2.66
#define GROUND_BEYOND 1.0 // log2 of metres per pixel; see ground_at

struct ground_surface {
	vec3 albedo;
	vec2 tilt;   // slope of its fine structure, to the east and north
	float loose; // how loose it is: 0.4 rock .. 1 soil
};

float ground_ramp(float low, float high, float x)
{
	return clamp((x - low) * (1.0 / (high - low)), 0.0, 1.0);
}

#if defined SPLAT && !defined HEAP
// Finds the two soil classes with the largest weights at a place, from the four posts around it. Noise moves the borders. part: the
// share of the second class among the two.
void ground_classes(vec2 post, float noise, out int one, out int other, out float part)
{
	vec2 at = clamp(floor(post), vec2(0.0), vec2(float(tile.x - 1))), in_cell = clamp(post - at + 0.8 * noise, 0.0, 1.0);
	ivec4 of = ivec4(textureGather(class_map, (at + 1.0) / float(tile.x + 1))); // north-west, north-east, south-east, south-west
	vec4 share = vec4(1.0 - in_cell.x, in_cell.x, in_cell.x, 1.0 - in_cell.x) *
		     vec4(in_cell.y, in_cell.y, 1.0 - in_cell.y, 1.0 - in_cell.y);
	vec4 sums = share.x * vec4(equal(of, of.xxxx)) + share.y * vec4(equal(of, of.yyyy)) + share.z * vec4(equal(of, of.zzzz)) +
		    share.w * vec4(equal(of, of.wwww));
	float most = max(max(sums.x, sums.y), max(sums.z, sums.w));
	one = most == sums.x ? of.x : most == sums.y ? of.y : most == sums.z ? of.z : of.w;
	sums *= vec4(notEqual(of, ivec4(one)));
	part = max(max(sums.x, sums.y), max(sums.z, sums.w));
	other = part == sums.x ? of.x : part == sums.y ? of.y : part == sums.z ? of.z : of.w;
	part /= most + part;
}
#endif

#ifdef SPLAT
vec3 ground_like(vec4 soil, const vec3 sand, const vec3 earth, const vec3 rock, const vec3 snow)
{
	return soil.rgb * (soil.w == 0.0 ? sand : soil.w == 2.0 ? earth : soil.w == 3.0 ? rock : snow);
}

vec3 ground_middle(vec4 soil)
{
	return ground_like(soil, 0.5 * (sand_colours[0] + sand_colours[1]), 0.5 * (soil_colours[0] + soil_colours[1]),
			   0.5 * (rock_colours[0] + rock_colours[1]), 0.5 * (snow_colours[0] + snow_colours[1]));
}

vec3 ground_apart(vec4 soil)
{
	return ground_like(soil, sand_colours[1] - sand_colours[0], soil_colours[1] - soil_colours[0],
			   rock_colours[1] - rock_colours[0], snow_colours[1] - snow_colours[0]);
}
#else
// Returns a mean of the values of the five materials. shares: of grass, soil, rock and snow; the rest is sand.
vec3 ground_mean(vec4 shares, const vec3 sand, const vec3 cover, const vec3 earth, const vec3 rock, const vec3 snow)
{
	return sand + shares.x * (cover - sand) + shares.y * (earth - sand) + shares.z * (rock - sand) + shares.w * (snow - sand);
}

// Two materials of a place, and the share of the second, at most 0.5.
struct ground_pair {
	float first, second, part;
};

// Lets a third material come to a place, by its share. The two with the largest shares stay. So between sand and soil there is no grass.
ground_pair ground_with(ground_pair pair, float material, float share)
{
	if (share <= pair.part)
		return pair;
	bool more = share > 0.5;
	return ground_pair(more ? material : pair.first, more ? pair.first : material, min(share, 1.0 - share));
}
#endif

// Returns the look of the ground at a pixel.
// post: the place in the tile. squares: the place in the near texture (xy) and in the far one (zw). log_pixel: from ground_pixel.
// region: noise of kilometres, -1 .. 1. rise: 0 at the lowest ground, 1 at the highest. steep: slope. dug: 0 .. 1, how much a wheel
// has turned it over.
ground_surface ground_at(vec2 post, vec4 squares, float log_pixel, float region, float rise, float steep, float dug)
{
	// The near texture is read from one level, chosen at random between two, which is cheaper than blending them. The far
	// texture is read from a coarse level, since large texture reads fill the cache.
	float level = log_pixel + dither();
	// The far texture repeats, and from far away a viewer would see the pattern. So beyond a distance it is drawn 16 times as wide. Near
	// that distance its contrast falls to 0, so that no border is seen.
	float beyond = log_pixel > GROUND_BEYOND ? 1.0 : 0.0, strong = clamp(0.7 * abs(log_pixel - GROUND_BEYOND), 0.0, 1.0);
	vec4 wide = textureLod(ground_map, vec3(squares.zw * (1.0 - 0.9375 * beyond), GROUND_WIDE), log_pixel + GROUND_FAR_LEVEL - 4.0 * beyond);
	wide = 0.5 + strong * (wide - 0.5);
#ifdef TRUTH
	wide.r = 0.5; // its humps and hollows have no height, either
#endif
	float noise = 2.0 * wide.g - 1.0, large = region + 0.5 * noise, slope = steep + 0.35 * noise;
	rise += 0.14 * region + 0.10 * noise;
#ifdef ONE_SOIL
	const float stony = 0.0;
#else
	float stony = min(ground_ramp(0.58, 0.82, slope) + ground_ramp(0.62, 0.76, rise), 1.0);
#endif
#ifdef SPLAT
	int one, other;
	float part;
#ifdef HEAP
	one = other = heap_class;
	part = 0.0;
#else
	ground_classes(post, noise, one, other, part);
#endif
	vec4 soil = soils[one], beside = soils[other];
	if (stony > part) {
		beside = stony > 0.5 ? soil : vec4(1.0, 1.0, 1.0, 3.0);
		soil = stony > 0.5 ? vec4(1.0, 1.0, 1.0, 3.0) : soil;
		part = min(stony, 1.0 - stony);
	}
	float layer = soil.w;
#else
	// Low and level ground has sand. Steep or high ground has bare soil or rock. High ground that is not too steep has snow. All other
	// ground has grass.
	float bare = max(ground_ramp(0.36, 0.58, slope) + ground_ramp(0.46, 0.60, rise), ground_ramp(0.15, 0.40, large));
	float sandy = ground_ramp(-0.10, -0.03, -rise) * ground_ramp(-0.35, -0.15, -slope) * (1.0 - stony);
	float white = snow_lies * ground_ramp(0.70, 0.74, rise) * ground_ramp(-1.05, -0.75, -slope);
	// Where the ground is dug up, soil shows under grass, and sand under sand.
	float along = 1.0 + max(min(bare, 1.0) + stony, dug * (1.0 - 0.6 * stony)), near = floor(along + 0.5);
	ground_pair pair = ground_pair(near, along < near ? near - 1.0 : near + 1.0, abs(along - near));
	pair = ground_with(ground_with(pair, 0.0, sandy), 4.0, white);
	float layer = pair.first, part = pair.part;
#endif

	vec4 grain = textureLod(ground_map, vec3(squares.xy, layer), max(level + GROUND_NEAR_LEVEL, GROUND_LEAST_LEVEL));
	part = clamp(0.5 + 3.0 * (part - 0.5) + 1.2 * (0.5 - grain.r), 0.0, 1.0);
	float hue = grain.g - 0.5 + 0.35 * large;
#ifdef SPLAT
	vec3 colour = mix(ground_middle(soil), ground_middle(beside), part), apart = mix(ground_apart(soil), ground_apart(beside), part);
#else
	const vec4 materials = vec4(1.0, 2.0, 3.0, 4.0);
	vec4 shares = (1.0 - part) * vec4(equal(vec4(layer), materials)) + part * vec4(equal(vec4(pair.second), materials));
	vec3 colour = ground_mean(shares, 0.5 * (sand_colours[0] + sand_colours[1]), 0.5 * (cover_colours[0] + cover_colours[1]),
				   0.5 * (soil_colours[0] + soil_colours[1]), 0.5 * (rock_colours[0] + rock_colours[1]),
				   0.5 * (snow_colours[0] + snow_colours[1]));
	vec3 apart = ground_mean(shares, sand_colours[1] - sand_colours[0], cover_colours[1] - cover_colours[0],
				  soil_colours[1] - soil_colours[0], rock_colours[1] - rock_colours[0], snow_colours[1] - snow_colours[0]);
#endif
	ground_surface surface;
	surface.albedo = max(colour + apart * hue, 0.2 * colour) * (mix(grain.r, 0.25 + 0.5 * grain.r, part) * 4.0 * wide.r);
	surface.loose = 1.0 - 0.6 * stony;
#ifdef DETAIL
	vec2 broad = 2.0 * wide.ba - 1.0, fine = (2.0 * grain.ba - 1.0) * (1.0 - 0.5 * part);
	surface.tilt = vec2(2.0 * fine.x - fine.y, fine.x + 2.0 * fine.y) * 0.447 +
		       vec2(3.0 * broad.x - broad.y, broad.x + 3.0 * broad.y) * 0.316;
#endif
	return surface;
}
