#version 450 core
// The light and colour of an object at a pixel, with the same sun, sky and haze as the ground.
#include "lib/picture.glsl"
#include "lib/body.glsl"
#include "lib/tone.glsl"
#ifdef TERRAIN_SHADOW
#include "lib/shade.glsl"
#endif
#ifdef FOG
#include "lib/sky.glsl"
#include "lib/haze.glsl"
#endif

in vec3 place;
in vec3 normal;
in float open;
flat in vec4 surface;
#ifdef FOG
in vec2 air;
#endif
layout(location = 0) out vec4 colour;

void main()
{
	// A surface that is not closed is seen from both sides.
	vec3 outward = normalize(gl_FrontFacing ? normal : -normal);
	float facing = max(dot(outward, sun.xyz), 0.0);
#ifdef TERRAIN_SHADOW
	facing *= sunlit(place, outward, sun.xyz);
#endif
	vec3 lit = surface.rgb * (sunlight.rgb * facing + mix(groundlight, skylight, 0.5 + 0.5 * outward.z) * (open * sunlight.w));
	vec3 toward_eye = -normalize(place), between = normalize(sun.xyz + toward_eye);
	lit += surface.a * facing * pow(max(dot(outward, between), 0.0), 40.0) * sunlight.rgb;
	lit += surface.a * 0.5 * pow(1.0 - max(dot(outward, toward_eye), 0.0), 4.0) * (open * sunlight.w) * skylight;
#ifdef FOG
	lit = through_haze(lit, air);
#endif
	colour = vec4(tone(lit), 1.0);
}
