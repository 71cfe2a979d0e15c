// Cells of the atlas: squares of posts that a pass draws or leaves out. They are marked in a texture (steep.frag).

const int CELL = 16;         // posts; REGION_ALIGN
const int CELLS_ACROSS = 16; // cells along a side of the atlas
