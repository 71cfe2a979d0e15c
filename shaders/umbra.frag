#version 450 core
// The ground without the sun's light. Blending puts it into the picture where the picture's alpha is below 1, and makes that 1 (shadow.frag).
layout(location = 0) out vec4 colour;

#ifdef SAMPLES
layout(binding = 0) uniform sampler2DMS umbra;
#define OWN gl_SampleID
#else
layout(binding = 0) uniform sampler2D umbra;
#define OWN 0
#endif

void main()
{
	colour = vec4(texelFetch(umbra, ivec2(gl_FragCoord.xy), OWN).rgb, 1.0);
}
