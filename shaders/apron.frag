#version 450 core
// The colour of the ground beyond the terrain, far from which the air alone is seen.
#define HEAP // soils of a map: the first one
#include "lib/picture.glsl"
#include "lib/body.glsl"
#include "lib/tone.glsl"
#include "lib/apron.glsl"
#ifdef TEXTURE
const int heap_class = 0;
#include "lib/ground.glsl"
#endif
#ifdef FOG
#include "lib/sky.glsl"
#include "lib/haze.glsl"
#endif

in vec3 place;
in vec2 gradient;
in vec2 metres;
#ifdef FOG
in vec2 air;
#endif
layout(location = 0) out vec4 colour;

void main()
{
	float rise = (place.z + relief.w - relief.x) * relief.y;
#ifdef TEXTURE
	vec3 albedo = ground_at(metres, ground_squares(metres), ground_pixel(place, gradient), ground_region(metres),
				min(rise, 0.3) + max(rise - 0.3, 0.0) * relief.z, length(gradient), 0.0).albedo;
#else
	vec3 albedo = mix(low_colour, high_colour, clamp(rise, 0.0, 1.0));
#endif
	vec3 lit = apron_light(albedo, gradient);
#ifdef FOG
	lit = through_haze(lit, air);
#endif
	colour = vec4(tone(lit), 1.0);
}
