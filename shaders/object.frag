#version 450 core
// An object's light: the ground's sun, sky and air on rubber, metal and paint.
#include "lib/picture.glsl"
#include "lib/tone.glsl"
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

const vec3 sunlight = vec3(1.0, 0.90, 0.75) * 2.6;
const vec3 skylight = vec3(0.40, 0.50, 0.64), groundlight = vec3(0.22, 0.19, 0.15);

void main()
{
	// Both sides of what is no closed surface are seen.
	vec3 outward = normalize(gl_FrontFacing ? normal : -normal);
	float facing = max(dot(outward, sun.xyz), 0.0);
	vec3 lit = surface.rgb * (sunlight * facing + mix(groundlight, skylight, 0.5 + 0.5 * outward.z) * open);
	vec3 toward_eye = -normalize(place), between = normalize(sun.xyz + toward_eye);
	lit += surface.a * facing * pow(max(dot(outward, between), 0.0), 40.0) * sunlight;
	lit += surface.a * 0.5 * pow(1.0 - max(dot(outward, toward_eye), 0.0), 4.0) * open * skylight;
#ifdef FOG
	lit = through_haze(lit, air);
#endif
	colour = vec4(tone(lit), 1.0);
}
