#version 450 core
// Turns a frame's light into colours, by its exposure.
#define EXPOSE
#include "lib/tone.glsl"

layout(binding = 0) uniform sampler2D light;
layout(std140, binding = 0) uniform params {
	vec4 exposure; // x: factor
};
layout(location = 0) out vec4 colour;

void main()
{
	colour = vec4(film_of(texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb * exposure.x), 1.0);
}
