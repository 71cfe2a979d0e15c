/* What a mesh covers of the cells of posts, from its raster. */
#ifndef FURROW_SOIL_COVER_FINE_H
#define FURROW_SOIL_COVER_FINE_H

#include "soil/law/posts.h"

/* As soil_cover, but without `room`, of a form of kind FORM_RASTER. Pure. */
void soil_cover_fine(const struct soil_form *form, struct soil_posts *posts);
/* Returns the lowest height of the mesh during its motion over a post's cell and those beside it, m above the centre. FINE_NONE: it is not there. */
float soil_cover_fine_low(const struct soil_form *form, float x, float y);

#endif
