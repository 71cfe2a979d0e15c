#version 450 core
// Darkens the ground in the shadow of an object. Writes the share of light that is left; blending multiplies the pixel by this
// share.
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

// Metres outside the form, less than 0 inside. About y it is round, or not; a ball is so in y too.
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
		discard; // nothing is there
	// Reversed depth without a far plane: the near plane's distance over how far ahead it is.
	vec2 corner = 2.0 * gl_FragCoord.xy / picture_size() - 1.0;
	vec3 place = (forward.xyz + corner.x * right.xyz + corner.y * up.xyz) * (project[3][2] / depth);
	vec3 within = abs(vec3(dot(volume_x.xyz, place) + volume_x.w, dot(volume_y.xyz, place) + volume_y.w,
			       dot(volume_z.xyz, place) + volume_z.w));
	if (max(within.x, max(within.y, within.z)) >= 1.0)
		discard;
	vec3 fade = min((1.0 - within) * vec3(6.0, 5.0, 5.0), 1.0);
	vec3 own = vec3(dot(own_x.xyz, place) + own_x.w, dot(own_y.xyz, place) + own_y.w, dot(own_z.xyz, place) + own_z.w);

	// Toward the sun the form is nearest where it is when scaled to a ball; the farther that is, the softer its edge.
	vec3 scaled = own / form.xyz, ahead = to_sun.xyz / form.xyz;
	float way = max(-dot(scaled, ahead) / dot(ahead, ahead), 0.0);
	float soft = 0.05 * form.w + 0.09 * way;
	float sunless = 1.0 - smoothstep(-soft, soft, outside(own + way * to_sun.xyz));
	float near = clamp(1.0 - outside(own) / (0.7 * form.w), 0.0, 1.0);
	float skyless = 0.5 * near * near;

	vec2 share = strength * (fade.x * fade.y * fade.z) * vec2(sunless, skyless);
	left = vec4((1.0 - share.x * of_sun) * (1.0 - share.y), 1.0);
}
