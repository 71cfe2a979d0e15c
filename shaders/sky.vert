#version 450 core
// One triangle over the picture, behind everything: its depth is nearer than the cleared one only.
out vec2 corner; // -1 .. 1 across the picture

void main()
{
	corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
	gl_Position = vec4(corner, 1e-12, 1.0);
}
