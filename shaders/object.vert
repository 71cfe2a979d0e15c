#version 450 core
// Places the corners of an object's triangles relative to the eye. All objects of one shape are instances of one draw.
#include "lib/picture.glsl"
#if defined FOG || defined GRAINS
#include "lib/body.glsl"
#endif
#ifdef FOG
#include "lib/sky.glsl"
#include "lib/haze.glsl"
#endif

// The corners of the object's triangles. xyz: bits of three floats: the place in the object's own axes, metres. w: the normal's three
// components, 10 bits each; above them the material, 2 bits.
layout(std430, binding = 0) readonly buffer corners {
	uvec4 corner[];
};
struct posed {
	vec4 forward, left, up; // xyz: the object's axes; the three w: its centre relative to the eye, metres
	vec4 size;              // x: radius of a ball that contains it, metres; y: its number
	vec4 paint;             // rgb: albedo; w says where it goes. 0: nowhere, materials keep their colours. 1: on all parts. 2: on all but metal and dark ones
};
layout(std430, binding = 1) readonly buffer objects {
	posed object[];
};

out vec3 place;  // metres relative to the eye
out vec3 normal;
out float open;  // share of the sky that the ground does not hide; less at the object's lower side
flat out vec4 surface; // rgb: albedo; w: how much it shines
flat out float number; // of the body, for pictures of instances
#ifdef FOG
out vec2 air;
#endif

// The materials: rubber with dust on it, metal, paint, and a dark one.
const vec4 surfaces[4] = vec4[](vec4(0.045, 0.042, 0.039, 0.04), vec4(0.27, 0.275, 0.28, 0.5),
				vec4(0.30, 0.285, 0.25, 0.15), vec4(0.075, 0.078, 0.085, 0.1));

void main()
{
	uvec4 which = corner[gl_VertexID];
	posed at = object[tile.y + gl_InstanceID];
	vec3 own = uintBitsToFloat(which.xyz);
	ivec3 steps = ivec3(which.www << uvec3(22, 12, 2)) >> 22;
	vec3 centre = vec3(at.forward.w, at.left.w, at.up.w);
	vec3 from_centre = at.forward.xyz * own.x + at.left.xyz * own.y + at.up.xyz * own.z;
	number = at.size.y;
	normal = at.forward.xyz * float(steps.x) + at.left.xyz * float(steps.y) + at.up.xyz * float(steps.z);
	place = centre + from_centre;
	open = 0.45 + 0.55 * smoothstep(-1.0, 0.4, from_centre.z / at.size.x);
#ifdef GRAINS
	surface = vec4(mix(soil_colours[0], soil_colours[1], fract(dot(at.forward.xyz, vec3(1e4, 3e4, 7e4)))), 0.0);
#else
	uint material = which.w >> 30;
	surface = surfaces[material];
	if (at.paint.w > 0.0 && (at.paint.w < 2.0 || (material & 1u) == 0u))
		surface = vec4(at.paint.rgb, 0.15);
#endif
#ifdef FOG
	air = haze_between(place);
#endif
	gl_Position = project * vec4(place, 1.0);
}
