// The first parameters of every iteration of relaxation (struct slide_params), as regions.vert or reached.vert passes them on.

flat in ivec4 passed[PASSED]; // passed.vert says why
// Over blocks: z: the least critical difference in a slope. Over a window: its first post from its first block; blocks in a row; first word.
ivec4 region = passed[0];
ivec4 place = passed[1];   // the layer; a post this near a block's side concerns the neighbour too
ivec4 looked = passed[3];  // over a window: posts whose neighbours were all looked at: first, one behind the last
