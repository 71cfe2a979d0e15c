#version 450 core
// The windows of a batch under a model that conserves soil, in one draw: a strip of four vertices for each. It passes numbers of the window
// on to the fragments, as passed.vert does.
// Defines:
// - PASSED: how many numbers, of 16 bytes each, are passed on
// - ROWS: the pass has one invocation for each row of posts (lib/rows.glsl). Otherwise it has one fragment for each post
// - REACHED: the posts are those in which soil can slide, as in reached.vert. With ROWS, the second number passed on becomes these posts
// - LAST: this is the last pass of sliding

const int RECORD = 81; // numbers of a window

layout(std430, binding = 5) readonly buffer batch {
	ivec4 records[]; // RECORD for each window: struct record in src/deform/together.c
};

layout(std140, binding = 0) uniform batch_params {
	ivec4 draw; // the first window; in its record: the first number that is passed on, and where it is drawn; posts along a side of the layer
};

#ifdef REACHED
layout(std430, binding = 4) readonly buffer laying {
	uint words[]; // LAYING_WORDS for each window: lib/laying.glsl
};
const int LAYING_WORDS = 47;
#endif

flat out ivec4 passed[PASSED];

#include "lib/reached.glsl"

void main()
{
	int window = draw.x + gl_InstanceID, record = window * RECORD;
	for (int i = 0; i < PASSED; i++)
		passed[i] = records[record + draw.y + i];
	ivec4 at = records[record + draw.z]; // with ROWS: x, y, posts in the viewport; otherwise posts: first, one behind the last
#ifdef REACHED
	int word = window * LAYING_WORDS;
	uvec4 reached = uvec4(words[word], words[word + 1], words[word + 2], words[word + 3]);
#endif
#if defined(REACHED) && defined(ROWS)
	passed[1] = posts_reached(reached, passed[1], passed[2].w);
#elif defined(REACHED)
	ivec4 written = passed[2], posts = posts_reached(reached, written, passed[4].z);
	ivec4 beside = mix(ivec4(passed[4].w), passed[3], equal(posts, written));
	passed[2] = posts;
	passed[3] = posts + ivec4(beside.xy, -beside.zw);
#ifdef LAST
	const int around = 0;
#else
	const int around = 1;
#endif
	int more = posts.x < posts.z ? around : 0;
	at = ivec4(posts.xy - more, posts.zw + more);
#endif
	vec2 corner = vec2(mix(at.xy, at.zw, bvec2(gl_VertexID & 1, gl_VertexID >> 1 & 1)));
	gl_Position = vec4(corner * (2.0 / float(draw.w)) - 1.0, 0.0, 1.0);
}
