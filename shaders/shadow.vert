#version 450 core
// The volume that an object shades, a box: its far sides are drawn, so that each pixel is, once, wherever the eye is.
#include "lib/picture.glsl"
#include "lib/body.glsl"
#ifdef FOG
#include "lib/sky.glsl"
#include "lib/haze.glsl"
#endif

// struct object_shadow in src/render/objects.h
struct caster {
	vec4 to_own[3];    // from a place relative to the eye to the form's own axes, metres
	vec4 form;         // half its size along them; its size, of one number
	vec4 to_volume[3]; // to the volume, -1 .. 1 each way
	vec4 kind;         // 0 a box, 1 a cylinder about its y, 2 a ball
};
layout(std430, binding = 0) readonly buffer casters {
	caster all[];
};

flat out vec4 own_x, own_y, own_z, form, volume_x, volume_y, volume_z;
flat out vec4 to_sun; // along the form's axes; its kind
flat out vec3 of_sun; // the sun's part of the light on level ground
flat out vec2 strength; // by the air between, of the sun's shadow and of the sky's

// Along a volume's axis, from its middle to its side.
vec3 side_of(vec4 axis, float side)
{
	return axis.xyz * ((side - axis.w) / dot(axis.xyz, axis.xyz));
}

void main()
{
	caster it = all[gl_InstanceID];
	vec3 direct = sunlight.rgb * max(sun.z, 0.05);
	of_sun = direct / (direct + skylight * sunlight.w);
	own_x = it.to_own[0];
	own_y = it.to_own[1];
	own_z = it.to_own[2];
	form = it.form;
	volume_x = it.to_volume[0];
	volume_y = it.to_volume[1];
	volume_z = it.to_volume[2];
	to_sun = vec4(dot(own_x.xyz, sun.xyz), dot(own_y.xyz, sun.xyz), dot(own_z.xyz, sun.xyz), it.kind.x);
	strength = vec2(smoothstep(0.0, 0.1, sun.z), 1.0);
#ifdef FOG
	strength *= haze_between(side_of(volume_x, 0.0) + side_of(volume_y, 0.0) + side_of(volume_z, 0.0)).x;
#endif
	vec3 side = vec3(gl_VertexID & 1, gl_VertexID >> 1 & 1, gl_VertexID >> 2 & 1) * 2.0 - 1.0;
	gl_Position = project * vec4(side_of(volume_x, side.x) + side_of(volume_y, side.y) + side_of(volume_z, side.z), 1.0);
}
