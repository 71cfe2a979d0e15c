#version 450 core
// The shadow of one object. Alpha is the share of the sun's light that still reaches the ground. Blending keeps the least alpha of all
// objects in the picture. umbra.frag then takes the sun's light away. The colour is the share of the sky's light beside the object. Blending
// multiplies the picture and the ground without the sun by it. The inputs are described in shadow.vert.
#include "lib/picture.glsl"
flat in vec4 own_x, own_y, own_z, form, volume_x, volume_y, volume_z;
flat in vec4 to_sun;
flat in vec2 strength;
layout(location = 0) out vec4 left;
layout(location = 1) out vec4 left_umbra;

#ifdef SAMPLES
// With multisampling, the shader runs for each sample of a pixel and reads the depth of that sample. So at the edge of a hill,
// the ground behind the edge gets its own shadow.
layout(binding = 0) uniform sampler2DMS depth_map;
float depth_at(ivec2 pixel)
{
	return texelFetch(depth_map, pixel, gl_SampleID).r;
}
vec2 picture_size()
{
	return vec2(textureSize(depth_map));
}
#else
layout(binding = 0) uniform sampler2D depth_map;
float depth_at(ivec2 pixel)
{
	return texelFetch(depth_map, pixel, 0).r;
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

// Returns how far from `at` toward the sun the middle of the way is that lies within the form. If the ray just touches the form, it
// does so there.
float way_through(vec3 at)
{
	vec3 sunward = mix(to_sun.xyz, vec3(1e-5), lessThan(abs(to_sun.xyz), vec3(1e-5)));
	vec3 one = (-form.xyz - at) / sunward, other = (form.xyz - at) / sunward;
	vec3 enters = min(one, other), leaves = max(one, other);
	if (to_sun.w > 0.0) { // round about the y axis
		float a = dot(sunward.xz, sunward.xz), b = dot(at.xz, sunward.xz), c = dot(at.xz, at.xz) - form.x * form.x;
		float root = sqrt(max(b * b - a * c, 0.0));
		enters.xz = vec2((-b - root) / a);
		leaves.xz = vec2((-b + root) / a);
	}
	return 0.5 * (max(enters.x, max(enters.y, enters.z)) + min(leaves.x, min(leaves.y, leaves.z)));
}

// Depth is reversed and has no far plane: it is the distance of the near plane, divided by the distance of the place ahead.
vec3 place_of(vec2 pixel, float depth)
{
	vec2 corner = 2.0 * pixel / picture_size() - 1.0;
	return (forward.xyz + corner.x * right.xyz + corner.y * up.xyz) * (project[3][2] / depth);
}

void main()
{
	float depth = depth_at(ivec2(gl_FragCoord.xy));
	if (depth == 0.0)
		discard; // nothing was drawn at this pixel
	vec3 place = place_of(gl_FragCoord.xy, depth);
	vec3 within = vec3(dot(volume_x.xyz, place) + volume_x.w, dot(volume_y.xyz, place) + volume_y.w, dot(volume_z.xyz, place) + volume_z.w);
	if (max(abs(within.x), max(abs(within.y), abs(within.z))) >= 1.0)
		discard;
	float fade = min((1.0 - within.x) * 10.0, 1.0); // toward the end of the volume
	vec3 own = vec3(dot(own_x.xyz, place) + own_x.w, dot(own_y.xyz, place) + own_y.w, dot(own_z.xyz, place) + own_z.w);

	// A ray goes from the place toward the sun. In space scaled so that the form is a ball, the ray comes nearest to the form after
	// `way` metres. A ray by a box's edge may be nearer at `through`. The edge of the shadow is softer where this is farther, by the
	// radius of the sun.
	vec3 scaled = own / form.xyz, ahead = to_sun.xyz / form.xyz;
	float way = max(-dot(scaled, ahead) / dot(ahead, ahead), 0.0), through = max(way_through(own), 0.0);
	float soft = 0.05 * form.w + 0.0047 * way;
	float beside = min(outside(own + way * to_sun.xyz), outside(own + through * to_sun.xyz));
	float sunless = 1.0 - smoothstep(-soft, soft, beside);
	float near = clamp(1.0 - outside(own) / (0.7 * form.w), 0.0, 1.0);
	float skyless = 0.5 * near * near;

	vec2 share = strength * fade * vec2(sunless, skyless);
	left = left_umbra = vec4(vec3(1.0 - share.y), 1.0 - share.x);
}
