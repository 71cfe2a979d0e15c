#version 450 core
// Parts of the windows of a batch, in one draw: a strip of four vertices for each. It passes the numbers of the part on to the fragments, as
// passed.vert does.
// Defines:
// - PASSED: how many numbers, of 16 bytes each, from the third on
// - RECORD: how many numbers a part has
// - HULL: draws a quadrilateral around what the pass changes, instead of all posts of the part. It may reach beyond these

layout(std430, binding = 4) readonly buffer batch {
	ivec4 records[]; // RECORD for each part: struct record in src/deform/batch.h
};

layout(std140, binding = 0) uniform batch_params {
	ivec4 draw; // the first part of this draw; posts along a side of the layer
};

flat out ivec4 passed[PASSED];

void main()
{
	int record = (draw.x + gl_InstanceID) * RECORD;
	for (int i = 0; i < PASSED; i++)
		passed[i] = records[record + 2 + i];
#ifdef HULL
	vec4 corners = intBitsToFloat(records[record + (gl_VertexID >> 1 & 1)]);
	vec2 corner = (gl_VertexID & 1) == 0 ? corners.xy : corners.zw;
#else
	ivec4 posts = records[record + 2];
	vec2 corner = vec2(mix(posts.xy, posts.zw, bvec2(gl_VertexID & 1, gl_VertexID >> 1 & 1)));
#endif
	gl_Position = vec4(corner * (2.0 / float(draw.y)) - 1.0, 0.0, 1.0);
}
