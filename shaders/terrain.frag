#version 450 core
// The light and colour of the ground at a pixel. The slope is computed from the posts around it, offsets included, and not from the
// mesh. So ruts show even where the mesh is coarse.
#include "lib/picture.glsl"
#include "lib/body.glsl"
#include "lib/slope.glsl"
#ifdef OFFSET
#include "lib/worn.glsl"
#endif
#ifdef TRUTH
#include "lib/truth.glsl"
#endif
#include "lib/pixel.glsl"
#include "lib/tone.glsl"
#ifdef FOG
#include "lib/sky.glsl"
#include "lib/haze.glsl"
#endif
#ifdef TEXTURE
#include "lib/ground.glsl"
#include "lib/walls.glsl"
#endif
#ifdef IMAGERY
#include "lib/imagery.glsl"
#endif
#ifdef TERRAIN_SHADOW
#include "lib/shade.glsl"
#endif

in vec2 post;
in vec3 place;
#if defined SKIRTS && (defined TERRAIN_SHADOW || defined TRUTH)
in float sunk; // metres below the ground's edge: more than 0 on skirts alone
#else
const float sunk = 0.0;
#endif
#ifdef LEVEL0
in vec2 broad; // slope of the ground without offsets
#endif
#ifdef TEXTURE
in vec4 squares;
in vec2 country;
#endif
#ifdef FOG
in vec2 air;
#endif
layout(location = 0) out vec4 colour;
#ifdef SHADOW
layout(location = 1) out vec4 umbra; // the colour without the sun's light
#endif
#ifdef LAYER
#include "lib/layer.glsl"
#endif

layout(binding = 0, r32i) readonly uniform iimage2D base_posts;
#define BASE_POST(at) imageLoad(base_posts, at).r
#ifdef OFFSET
layout(binding = 1, r32i) readonly uniform iimage2D offset_posts;
#define OFFSET_POST(at) imageLoad(offset_posts, at).r
#ifdef HEALS
layout(binding = 2, r32i) readonly uniform iimage2D healed_posts;
#define SHADES(at) mark_left(imageLoad(healed_posts, at).r, marks.y)
#elif defined DISTURBANCE
layout(binding = 2, r8ui) readonly uniform uimage2D disturbance_posts;
#define SHADES(at) (float(imageLoad(disturbance_posts, at).r) / 255.0)
#endif
#ifdef VEGETATION
layout(binding = 3, r32i) readonly uniform iimage2D risen_posts;
layout(binding = 4, r32i) readonly uniform iimage2D grown_posts;
#endif
#endif
#ifdef VEGETATION
#include "lib/plants.glsl"
#endif

#if defined HEALS || defined VEGETATION
// Returns what is left of a mark, 0 to 1.
float mark_left(int until, int whole)
{
	return clamp(float(until - marks.x) / float(max(whole, 1)), 0.0, 1.0);
}
#endif
#ifdef OFFSET
// Interpolates between the four posts around the pixel.
#define BETWEEN(of, at, part) mix(mix(of(at), of(at + ivec2(1, 0)), part.x), mix(of(at + ivec2(0, 1)), of(at + ivec2(1, 1)), part.x), part.y)
#define BENT(at) mark_left(imageLoad(risen_posts, at).r, marks.z)
#define TORN(at) mark_left(imageLoad(grown_posts, at).r, marks.w)
#endif

void main()
{
#ifdef LEVEL0
	vec2 gradient = broad;
#else
	vec2 gradient = slope_of_base(SLOPE_POSTS(BASE_POST, post, tile.x), post, tile.x) * (base_metre / origin.z);
#endif
	float shade = 1.0, steep = length(gradient), dug = 0.0;

#ifdef OFFSET
	slope_of_map offset = slope_of_offset(SLOPE_POSTS(OFFSET_POST, post, tile.x), post, tile.x);
	vec2 cut = offset.gradient * (offset_metre / origin.z);
	gradient += cut;
	float moved = offset.value * offset_metre;
	float sunken = smoothstep(0.004, 0.06, -moved);
	float risen = max(smoothstep(0.004, 0.03, moved), smoothstep(0.04, 0.25, length(cut)));
	dug = max(sunken, risen);
	shade = 1.0 - 0.35 * smoothstep(0.0, 0.35, -moved);
#ifdef DISTURBANCE
	ivec2 at = clamp(ivec2(floor(post)), ivec2(0), ivec2(tile.x - 1));
	vec2 part = post - vec2(at);
	float wet = BETWEEN(SHADES, at, part);
#endif
#endif

#ifdef IMAGERY
	vec4 seen = imagery_at(post, imagery_pixel(place, gradient));
#if defined OFFSET && defined DISTURBANCE
	seen *= imagery_left(wet);
#elif defined OFFSET
	seen *= 1.0 - dug;
#endif
#endif
#ifdef TEXTURE
#ifdef IMAGERY
	ground_surface surface = ground_surface(vec3(0.0), vec2(0.0), 1.0);
	if (seen.a < 1.0) // the soil's look shows through
#else
	ground_surface surface;
#endif
	{
		vec4 side = vec4(walls_squares(squares.xy, gradient, steep, place.z + relief.w), squares.zw);
		surface = ground_at(post, side, ground_pixel(place, gradient), country.x, country.y, steep, dug);
	}
	vec3 albedo = surface.albedo;
#else
	vec3 albedo = mix(low_colour, high_colour, clamp((place.z + relief.w - relief.x) * relief.y, 0.0, 1.0));
#endif
#ifdef IMAGERY
	albedo = seen.rgb + albedo * (1.0 - seen.a);
#ifdef TEXTURE
	surface.tilt *= 1.0 - seen.a; // the picture has light and shade of its own
#endif
#endif

#ifdef OFFSET
	// Raised soil is fresh and rough. Lowered soil is dark, and smooth if it is soft (surface.loose).
	albedo *= (1.0 - 0.15 * risen) * (1.0 - rut_dark * sunken);
#if defined TEXTURE && defined DETAIL
	surface.tilt *= 1.0 + 0.6 * risen - 0.55 * surface.loose * sunken;
#endif
#ifdef DISTURBANCE
	albedo = worn(albedo, wet);
#endif
#endif
#ifdef VEGETATION
	float bent = 0.0, torn = 0.0;
#ifdef OFFSET
	ivec2 stem = clamp(ivec2(floor(post)), ivec2(0), ivec2(tile.x - 1));
	vec2 beside = post - vec2(stem);
	bent = BETWEEN(BENT, stem, beside);
	torn = BETWEEN(TORN, stem, beside);
#endif
	albedo = overgrown(albedo, origin.xy + post * origin.z, plants_cover(post), bent, torn);
#endif
#ifdef TERRAIN_SHADOW
	vec3 broad_normal = normalize(vec3(-gradient, 1.0));
#endif
#if defined TEXTURE && defined DETAIL
	gradient += surface.tilt;
#endif
#ifdef TRUTH
	if (sunk == 0.0)
		gradient = slope_of_triangle(place, gradient);
#endif

#ifdef LAYER
	layer_values values = layer_values(0.0, 0.0, place.z + relief.w, length(gradient));
#ifdef OFFSET
	values.moved = moved;
#ifdef DISTURBANCE
	values.disturbance = wet;
#endif
#endif
	colour = layer_colour(values, max(dot(normalize(vec3(-gradient, 1.0)), sun.xyz), 0.0));
#ifdef SHADOW
	umbra = layer_colour(values, 0.0);
#endif
#else
	vec3 normal = normalize(vec3(-gradient, 1.0));
	float facing = max(dot(normal, sun.xyz), 0.0);
#ifdef TERRAIN_SHADOW
	// A skirt is as bright as the edge above it: below the ground it would be dark.
	vec3 triangle = cross(dFdx(place), dFdy(place));
	float area = length(triangle);
	triangle = sunk > 0.0 || area == 0.0 ? broad_normal : triangle / area;
	if (facing > 0.0)
		facing *= sunlit(vec3(place.xy, place.z + sunk), broad_normal, triangle);
#endif
	vec3 unlit = albedo * mix(groundlight, skylight, 0.5 + 0.5 * normal.z) * (shade * sunlight.w);
	vec3 lit = albedo * sunlight.rgb * facing + unlit;
#if defined OFFSET && defined DISTURBANCE
	// Wet soil shines: Blinn-Phong with the vector half-way between sun and eye, to the power of 24.
	vec3 between = sun.xyz - place * inversesqrt(dot(place, place));
	float along = max(dot(normal, between), 0.0), square = along * along / dot(between, between);
	float fourth = square * square, eighth = fourth * fourth;
	lit += water * wet * facing * eighth * eighth * eighth * 0.05 * sunlight.rgb;
#endif
#ifdef FOG
	lit = through_haze(lit, air);
#endif
	colour = vec4(tone(lit), 1.0);
#ifdef SHADOW
#ifdef FOG
	unlit = through_haze(unlit, air);
#endif
	umbra = vec4(tone(unlit), 1.0);
#endif
#endif
}
