#version 450 core
// What an object is at a pixel, as numbers: see measure.frag. An object has no soil.
in vec3 place;
in vec3 normal;
flat in float number; // of the body; 0: a grain
// x, y: of the unit normal; z: m, of the place; w: -1 - 2 * number, or -2 - 2 * number where the normal points down.
layout(location = 0) out vec4 measured;

void main()
{
	vec3 outward = normalize(gl_FrontFacing ? normal : -normal);
	measured = vec4(outward.xy, place.z, (outward.z < 0.0 ? -2.0 : -1.0) - 2.0 * number);
}
