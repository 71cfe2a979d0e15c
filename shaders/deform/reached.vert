#version 450 core
// A rectangle of posts of a window: those in which soil can slide after a contact (lib/reached.glsl). It passes the parameters on, with
// what follows from that rectangle.
// Defines: PASSED: as in passed.vert; LAST: this is the last pass of sliding.

layout(std140, binding = 0) uniform params {
	ivec4 parameters[PASSED]; // struct slide_params
};

#include "lib/reached.glsl"

flat out ivec4 passed[PASSED];

void main()
{
	ivec4 written = parameters[2], sides = parameters[3], view = parameters[4];
	ivec4 posts = reached_posts(written, view.z);
	// At the border of the posts not all neighbours are looked at. Beyond the world there are none.
	ivec4 beside = mix(ivec4(view.w), sides, equal(posts, written));
	passed = parameters;
	passed[2] = posts;
	passed[3] = posts + ivec4(beside.xy, -beside.zw);
	// The posts around them are still, and passes that read them compute them too.
#ifdef LAST
	const int around = 0;
#else
	const int around = 1;
#endif
	int more = posts.x < posts.z ? around : 0;
	ivec2 corner = mix(posts.xy - more, posts.zw + more, bvec2(gl_VertexID & 1, gl_VertexID >> 1));
	gl_Position = vec4(vec2(corner) * (2.0 / vec2(view.xy)) - 1.0, 0.0, 1.0);
}
