#version 450 core
// An object: its corners in the world, as seen from the eye. Instances are objects of one shape.
#include "lib/picture.glsl"
#ifdef FOG
#include "lib/sky.glsl"
#include "lib/haze.glsl"
#endif

// Place along its own axes, metres; a normal of 10 bits each, what it is of (2 bits)
layout(std430, binding = 0) readonly buffer corners {
	uvec4 corner[];
};
struct posed {
	vec4 forward, left, up; // its axes; w: its centre, metres relative to the eye
	vec4 size;              // of the ball around it, metres
};
layout(std430, binding = 1) readonly buffer objects {
	posed object[];
};

out vec3 place;  // metres relative to the eye
out vec3 normal;
out float open;  // how much of the sky the ground under the object leaves
flat out vec4 surface; // albedo, how much it shines
#ifdef FOG
out vec2 air;
#endif

// Rubber with dust on it, metal, paint, and what is dark.
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
	normal = at.forward.xyz * float(steps.x) + at.left.xyz * float(steps.y) + at.up.xyz * float(steps.z);
	place = centre + from_centre;
	open = 0.45 + 0.55 * smoothstep(-1.0, 0.4, from_centre.z / at.size.x);
	surface = surfaces[which.w >> 30];
#ifdef FOG
	air = haze_between(place);
#endif
	gl_Position = project * vec4(place, 1.0);
}
