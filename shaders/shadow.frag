#version 450 core
// Darkens the ground in the shadow of one object. The output is the share of light that still reaches the ground, for each colour.
// Blending multiplies the pixel by this share. The inputs are described in shadow.vert.
#include "lib/picture.glsl"
#include "lib/body.glsl"
#ifdef TERRAIN_SHADOW
#include "lib/shade.glsl"
#endif
flat in vec4 own_x, own_y, own_z, form, volume_x, volume_y, volume_z;
flat in vec4 to_sun;
flat in vec2 strength;
layout(location = 0) out vec4 left;

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

// Returns the way from the place of this pixel to that of a pixel beside it. Of the two neighbours it takes the one whose place is
// nearer, since that is likely to be on the same surface.
vec3 way_along(vec3 place, vec2 step)
{
	vec2 pixel = gl_FragCoord.xy, last = picture_size() - 1.0;
	vec2 next = min(pixel + step, last + 0.5), before = max(pixel - step, vec2(0.5));
	vec3 ahead = place_of(next, max(depth_at(ivec2(next)), 1e-9)) - place, back = place - place_of(before, max(depth_at(ivec2(before)), 1e-9));
	bool no_ahead = next == pixel, no_back = before == pixel;
	return no_back || (!no_ahead && dot(ahead, ahead) < dot(back, back)) ? ahead : back;
}

// Returns the share of the light on the ground that comes from the sun, for each colour. Where the ground is turned away from the
// sun, or in the shadow of other ground, there is none.
vec3 share_of_sun(vec3 place)
{
	vec3 normal = cross(way_along(place, vec2(1.0, 0.0)), way_along(place, vec2(0.0, 1.0)));
	normal = normalize(normal.z < 0.0 ? -normal : normal);
	float facing = max(dot(normal, sun.xyz), 0.0);
#ifdef TERRAIN_SHADOW
	if (facing > 0.0)
		facing *= sunlit(place, normal);
#endif
	vec3 direct = sunlight.rgb * facing;
	return direct / (direct + mix(groundlight, skylight, 0.5 + 0.5 * normal.z) * sunlight.w);
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
	vec3 of_sun = share.x > 0.0 ? share_of_sun(place) : vec3(0.0);
	left = vec4((1.0 - share.x * of_sun) * (1.0 - share.y), 1.0);
}
