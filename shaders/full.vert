#version 450 core
// One triangle that covers the viewport, from gl_VertexID alone: 0, 1, 2.

void main()
{
	vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
	gl_Position = vec4(corner * 4.0 - 1.0, 0.0, 1.0);
}
