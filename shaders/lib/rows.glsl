// Passes with one invocation for each row, or line, of posts.

const int ROWS_ABREAST = 4; // they lie side by side in the pass's viewport, so that its blocks of pixels are full (DEFORM_ROWS_ABREAST)

// Returns the row of this invocation. It may lie beyond the last one. first: row of the pass
int row_of_pass(int first)
{
	ivec2 at = ivec2(gl_FragCoord.xy);
	return first + at.x + ROWS_ABREAST * at.y;
}
