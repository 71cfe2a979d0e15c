#version 450 core
// The ground's light and colour at a pixel: slope from the posts themselves, ruts included.
#include "lib/picture.glsl"
#include "lib/slope.glsl"
#include "lib/tone.glsl"
#ifdef FOG
#include "lib/sky.glsl"
#include "lib/haze.glsl"
#endif
#ifdef TEXTURE
#include "lib/ground.glsl"
#endif

in vec2 post;
in vec3 place;
#ifdef LEVEL0
in vec2 broad; // slope of the ground without offsets
#endif
#ifdef TEXTURE
in float region;
#endif
#ifdef FOG
in vec2 air;
#endif
layout(location = 0) out vec4 colour;
#ifdef LAYER
#include "lib/layer.glsl"
#endif

layout(binding = 0, r32i) readonly uniform iimage2D base_posts;
#ifdef OFFSET
layout(binding = 1, r32i) readonly uniform iimage2D offset_posts;
#ifdef DIRT
layout(binding = 2, r8ui) readonly uniform uimage2D dirt_posts;
#endif
#endif

const vec3 sunlight = vec3(1.0, 0.90, 0.75) * 2.6;
const vec3 skylight = vec3(0.40, 0.50, 0.64), groundlight = vec3(0.22, 0.19, 0.15);

void main()
{
#ifdef LEVEL0
	vec2 gradient = broad;
#else
	vec2 gradient = slope_of_base(base_posts, post, tile.x) * (base_metre / origin.z);
#endif
	float shade = 1.0;

#ifdef TEXTURE
	// How long a pixel is on the ground: more along a grazing view.
	float far = length(place), steep = length(gradient);
	float facing_eye = abs(dot(place, vec3(-gradient, 1.0))) * inversesqrt(1.0 + steep * steep) / far;
	float log_pixel = log2(far * right.w) - 0.4 * log2(max(facing_eye, 0.02));
	vec2 metres = pattern.xy + post * pattern.z;
	vec3 noise = noise_near(metres, log_pixel);
	ground_surface surface = ground_at(metres, region, noise.x, place.z + relief.w, steep);
	vec3 albedo = surface.albedo;
	float loose = surface.loose;
#else
	vec3 albedo = mix(vec3(0.130, 0.105, 0.075), vec3(0.270, 0.240, 0.200),
			  clamp((place.z + relief.w - relief.x) * relief.y, 0.0, 1.0));
	float loose = 1.0;
#endif

#ifdef OFFSET
	slope_of_map offset = slope_of_offset(offset_posts, post, tile.x);
	vec2 cut = offset.gradient * (offset_metre / origin.z);
	gradient += cut;
	float moved = offset.value * offset_metre;
	float pressed = smoothstep(0.004, 0.06, -moved);
	float heaped = max(smoothstep(0.004, 0.03, moved), smoothstep(0.04, 0.25, length(cut)));
	shade = 1.0 - 0.35 * smoothstep(0.0, 0.35, -moved);
#endif

#if defined TEXTURE && defined DETAIL
	gradient += surface.rough * noise.yz;
#endif

#ifdef OFFSET
	const vec3 dug = vec3(0.170, 0.125, 0.085), packed_soil = vec3(0.085, 0.062, 0.043);
	float grit = clamp(dot(albedo, vec3(3.0, 4.0, 2.0)), 0.3, 1.5);
	albedo = mix(albedo, dug * (0.5 + 0.5 * grit), 0.8 * loose * heaped);
	albedo = mix(albedo, packed_soil * (0.5 + 0.5 * grit), (0.45 + 0.45 * loose) * pressed);
#ifdef DIRT
	ivec2 at = clamp(ivec2(floor(post)), ivec2(0), ivec2(tile.x - 1));
	vec2 part = post - vec2(at);
	vec4 dirt = vec4(imageLoad(dirt_posts, at).r, imageLoad(dirt_posts, at + ivec2(1, 0)).r,
			 imageLoad(dirt_posts, at + ivec2(0, 1)).r, imageLoad(dirt_posts, at + ivec2(1, 1)).r);
	vec2 row = mix(dirt.xz, dirt.yw, part.x);
	float wet = mix(row.x, row.y, part.y) / 255.0;
	albedo *= 1.0 - 0.4 * wet;
#endif
#endif

#ifdef LAYER
	layer_values values = layer_values(0.0, 0.0, place.z + relief.w, length(gradient));
#ifdef OFFSET
	values.moved = moved;
#ifdef DIRT
	values.dirt = wet;
#endif
#endif
	colour = layer_colour(values, gradient);
#else
	vec3 normal = normalize(vec3(-gradient, 1.0));
	float facing = max(dot(normal, sun.xyz), 0.0);
	vec3 lit = albedo * (sunlight * facing + mix(groundlight, skylight, 0.5 + 0.5 * normal.z) * shade);
#if defined OFFSET && defined DIRT
	// Half-way between sun and eye, to the power of 24.
	vec3 between = sun.xyz - place * inversesqrt(dot(place, place));
	float along = max(dot(normal, between), 0.0), square = along * along / dot(between, between);
	float fourth = square * square, eighth = fourth * fourth;
	lit += wet * facing * eighth * eighth * eighth * 0.05 * sunlight;
#endif
#ifdef FOG
	lit = through_haze(lit, air);
#endif
	colour = vec4(tone(lit), 1.0);
#endif
}
