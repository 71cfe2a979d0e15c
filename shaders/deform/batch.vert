#version 450 core
// The windows of a batch, in one draw: a strip of four vertices for each. It passes the numbers of the window on to the fragments, as
// passed.vert does.
// Defines:
// - PASSED: how many numbers, of 16 bytes each
// - FIRST: the first of them, among the numbers of a window
// - RECORD: how many numbers a window has

layout(std430, binding = 4) readonly buffer batch {
	ivec4 records[]; // RECORD for each window. The first: its posts in the layer: first, one behind the last
};

layout(std140, binding = 0) uniform batch_params {
	ivec4 first; // x: the first window of this draw
};

#define LAYER_POSTS 256.0 /* DEFORM_WINDOW_POSTS */

flat out ivec4 passed[PASSED];

void main()
{
	int record = (first.x + gl_InstanceID) * RECORD;
	for (int i = 0; i < PASSED; i++)
		passed[i] = records[record + FIRST + i];
	ivec4 posts = records[record];
	ivec2 corner = mix(posts.xy, posts.zw, bvec2(gl_VertexID & 1, gl_VertexID >> 1 & 1));
	gl_Position = vec4(vec2(corner) * (2.0 / LAYER_POSTS) - 1.0, 0.0, 1.0);
}
