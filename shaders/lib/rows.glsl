// Passes with one invocation for each row, or line, of posts.
// Define: BATCH: over all windows of a batch (windows.vert). Posts are counted from the first of the layer in which the windows lie

const int ROWS_ABREAST = 4; // they lie side by side in the pass's viewport, so that its blocks of pixels are full (DEFORM_ROWS_ABREAST)

#ifdef BATCH
flat in ivec4 passed[PASSED];
ivec4 of_window = passed[PASSED - 1]; // the window's number in the batch; x, y of its rows in the viewport
#define WINDOW of_window.x
#define NUMBER(i) passed[i]
#else
#define WINDOW 0
#endif

// Returns the row of this invocation. It may lie beyond the last one. first: row of the pass
int row_of_pass(int first)
{
	ivec2 at = ivec2(gl_FragCoord.xy);
#ifdef BATCH
	at -= of_window.yz;
#endif
	return first + at.x + ROWS_ABREAST * at.y;
}
