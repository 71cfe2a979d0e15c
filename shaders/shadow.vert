#version 450 core
// Draws the volume that the shadow of one object may reach: a box along the sun's rays. Only its far sides are drawn. So each pixel of the volume is drawn
// once, also if the eye is inside.
#include "lib/picture.glsl"
#include "lib/body.glsl"
#ifdef FOG
#include "lib/sky.glsl"
#include "lib/haze.glsl"
#endif

// struct object_shadow in src/render/objects.h
struct caster {
	// affine maps of a place relative to the eye, one row for each axis: onto the axes of the object's simple form, metres
	vec4 to_own[3];
	vec4 form;         // xyz: half the size of the form along its axes, metres; w: its size as one number
	vec4 to_volume[3]; // onto the axes of the volume, -1 .. 1 inside
	vec4 kind;         // x: 0 a box, 1 a cylinder about its y axis, 2 a ball
};
layout(std430, binding = 0) readonly buffer casters {
	caster all[];
};

flat out vec4 own_x, own_y, own_z, form, volume_x, volume_y, volume_z;
flat out vec4 to_sun; // xyz: direction to the sun along the form's axes; w: kind of the form
flat out vec2 strength; // 0 .. 1: strength of the shadow from the sun, and from the sky; the latter is weaker in haze

// Returns the part along one axis of the place on the volume where that axis has the value `side`.
vec3 side_of(vec4 axis, float side)
{
	return axis.xyz * ((side - axis.w) / dot(axis.xyz, axis.xyz));
}

void main()
{
	caster it = all[gl_InstanceID];
	own_x = it.to_own[0];
	own_y = it.to_own[1];
	own_z = it.to_own[2];
	form = it.form;
	volume_x = it.to_volume[0];
	volume_y = it.to_volume[1];
	volume_z = it.to_volume[2];
	to_sun = vec4(dot(own_x.xyz, sun.xyz), dot(own_y.xyz, sun.xyz), dot(own_z.xyz, sun.xyz), it.kind.x);
	strength = vec2(smoothstep(0.0, 0.005, sun.z), 1.0);
#ifdef FOG
	strength.y *= haze_between(side_of(volume_x, 0.0) + side_of(volume_y, 0.0) + side_of(volume_z, 0.0)).x;
#endif
	vec3 side = vec3(gl_VertexID & 1, gl_VertexID >> 1 & 1, gl_VertexID >> 2 & 1) * 2.0 - 1.0;
	gl_Position = project * vec4(side_of(volume_x, side.x) + side_of(volume_y, side.y) + side_of(volume_z, side.z), 1.0);
}
