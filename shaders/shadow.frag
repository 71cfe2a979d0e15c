#version 450 core
// Darkens the ground in the shadow of one object. The output is the share of light that still reaches the ground, for each colour.
// Blending multiplies the pixel by this share. The inputs are described in shadow.vert.
#include "lib/picture.glsl"
flat in vec4 own_x, own_y, own_z, form, volume_x, volume_y, volume_z;
flat in vec4 to_sun;
flat in vec3 of_sun;
flat in vec2 strength;
layout(location = 0) out vec4 left;

#ifdef SAMPLES
// With multisampling, the shader runs for each sample of a pixel and reads the depth of that sample. So at the edge of a hill,
// the ground behind the edge gets its own shadow.
layout(binding = 0) uniform sampler2DMS depth_map;
float depth_here()
{
	return texelFetch(depth_map, ivec2(gl_FragCoord.xy), gl_SampleID).r;
}
vec2 picture_size()
{
	return vec2(textureSize(depth_map));
}
#else
layout(binding = 0) uniform sampler2D depth_map;
float depth_here()
{
	return texelFetch(depth_map, ivec2(gl_FragCoord.xy), 0).r;
}
vec2 picture_size()
{
	return vec2(textureSize(depth_map, 0));
}
#endif

// Returns the distance of `at` from the surface of the object's simple form, in metres; negative inside. The form is a box, or a
// cylinder about the y axis (to_sun.w > 0), or a ball (to_sun.w == 2).
float outside(vec3 at)
{
	bool is_round = to_sun.w > 0.0, ball = to_sun.w == 2.0;
	vec3 over = abs(at) - form.xyz;
	over.x = is_round ? sqrt(at.x * at.x + at.z * at.z + (ball ? at.y * at.y : 0.0)) - form.x : over.x;
	over.y = ball ? -form.y : over.y;
	over.z = is_round ? -form.z : over.z;
	return length(max(over, 0.0)) + min(max(over.x, max(over.y, over.z)), 0.0);
}

void main()
{
	float depth = depth_here();
	if (depth == 0.0)
		discard; // nothing was drawn at this pixel
	// Depth is reversed and has no far plane: it is the distance of the near plane, divided by the distance of the place ahead.
	vec2 corner = 2.0 * gl_FragCoord.xy / picture_size() - 1.0;
	vec3 place = (forward.xyz + corner.x * right.xyz + corner.y * up.xyz) * (project[3][2] / depth);
	vec3 within = abs(vec3(dot(volume_x.xyz, place) + volume_x.w, dot(volume_y.xyz, place) + volume_y.w,
			       dot(volume_z.xyz, place) + volume_z.w));
	if (max(within.x, max(within.y, within.z)) >= 1.0)
		discard;
	vec3 fade = min((1.0 - within) * vec3(6.0, 5.0, 5.0), 1.0);
	vec3 own = vec3(dot(own_x.xyz, place) + own_x.w, dot(own_y.xyz, place) + own_y.w, dot(own_z.xyz, place) + own_z.w);

	// A ray goes from the place toward the sun. In space scaled so that the form is a ball, the ray comes nearest to the form after
	// `way` metres. The edge of the shadow is softer where this is farther.
	vec3 scaled = own / form.xyz, ahead = to_sun.xyz / form.xyz;
	float way = max(-dot(scaled, ahead) / dot(ahead, ahead), 0.0);
	float soft = 0.05 * form.w + 0.09 * way;
	float sunless = 1.0 - smoothstep(-soft, soft, outside(own + way * to_sun.xyz));
	float near = clamp(1.0 - outside(own) / (0.7 * form.w), 0.0, 1.0);
	float skyless = 0.5 * near * near;

	vec2 share = strength * (fade.x * fade.y * fade.z) * vec2(sunless, skyless);
	left = vec4((1.0 - share.x * of_sun) * (1.0 - share.y), 1.0);
}
