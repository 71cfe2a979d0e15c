/* What the surface of a mesh is made of: smooth pieces, and whether it is a drum or a block. Computed once for each mesh. */
#ifndef FURROW_SOIL_PIECES_H
#define FURROW_SOIL_PIECES_H

#include "soil/law/surface.h"

/* Fills what struct soil_surface tells of pieces, from its triangles and what lies across their edges. stack: room for an index of each triangle. */
void soil_surface_pieces(struct soil_surface *surface, uint32_t *stack);

#endif
