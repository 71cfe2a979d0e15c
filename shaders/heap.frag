#version 450 core
// The light and colour of soil that a body carries: those of ground that was dug.
#define HEAP
#include "lib/picture.glsl"
#include "lib/body.glsl"
#include "lib/tone.glsl"
flat in int heap_class;
#ifdef TEXTURE
#include "lib/ground.glsl"
#endif
#ifdef TERRAIN_SHADOW
#include "lib/shade.glsl"
#endif
#ifdef FOG
#include "lib/sky.glsl"
#include "lib/haze.glsl"
#endif

#ifdef TRUTH
#include "lib/truth.glsl"
#endif

in vec3 place;
in vec3 normal;
flat in vec2 along;
#ifdef TEXTURE
in vec4 squares;
in vec2 country;
#else
flat in float high;
#endif
#ifdef FOG
in vec2 air;
#endif
layout(location = 0) out vec4 colour;

void main()
{
	vec2 gradient = -normal.xy / max(normal.z, 0.05 * length(normal));
#ifdef TERRAIN_SHADOW
	vec3 broad = normalize(vec3(-gradient, 1.0));
#endif
#ifdef TEXTURE
	ground_surface surface = ground_at(vec2(0.0), squares, ground_pixel(place, gradient), country.x, country.y, 0.0, 1.0);
	vec3 albedo = surface.albedo;
#else
	vec3 albedo = mix(low_colour, high_colour, high);
#endif
	albedo *= 0.85; // fresh soil, as terrain.frag has it where it was raised
#if defined TEXTURE && defined DETAIL
	gradient += 1.6 * (surface.tilt.x * along + surface.tilt.y * vec2(-along.y, along.x));
#endif
#ifdef TRUTH
	gradient = slope_of_triangle(place, gradient);
#endif
	vec3 outward = normalize(vec3(-gradient, 1.0));
	float facing = max(dot(outward, sun.xyz), 0.0);
#ifdef TERRAIN_SHADOW
	if (facing > 0.0)
		facing *= sunlit(place, broad, sun.xyz);
#endif
	vec3 lit = albedo * (sunlight.rgb * facing + mix(groundlight, skylight, 0.5 + 0.5 * outward.z) * sunlight.w);
#ifdef FOG
	lit = through_haze(lit, air);
#endif
	colour = vec4(tone(lit), 1.0);
}
