#version 450 core
// Draws the sky: one triangle that covers the whole picture, behind everything else. Depth is reversed, and 0 where nothing was drawn.
// The triangle's depth is just above 0, so it shows only at those pixels.
out vec2 corner; // place in the picture: -1 .. 1, x to the right, y upward

void main()
{
	corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
	gl_Position = vec4(corner, 1e-30, 1.0);
}
