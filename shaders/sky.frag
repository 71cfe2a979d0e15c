#version 450 core
// The sky where no ground was drawn.
#include "lib/picture.glsl"
#include "lib/sky.glsl"
#include "lib/tone.glsl"

in vec2 corner;
layout(location = 0) out vec4 colour;

void main()
{
	vec3 direction = normalize(forward.xyz + corner.x * right.xyz + corner.y * up.xyz);
	colour = vec4(tone(sky_with_sun(direction)), 1.0);
}
