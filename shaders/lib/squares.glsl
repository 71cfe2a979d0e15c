// Over blocks (BLOCKS) the parameters of a pass begin with the rectangles that it draws (regions.vert). Only the vertex shader reads them.

#define SQUARES 49 /* ATLAS_MOST */
#ifdef BLOCKS
#define SQUARES_FIRST ivec4 not_read[SQUARES];
#else
#define SQUARES_FIRST
#endif
