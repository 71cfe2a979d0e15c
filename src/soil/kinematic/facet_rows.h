/* Draws a facet over rows of posts, in whole numbers: the same bits as shaders/lib/facet.glsl and facet.frag compute. Pure. */
#ifndef FURROW_SOIL_FACET_ROWS_H
#define FURROW_SOIL_FACET_ROWS_H

#include <stddef.h>

#include "soil/shape/facet.h"

/* Lowers `under`, and where the facet rests at the end `rest`, to the facet: heights above the window's zero, fixed-point units. Both begin at
 * the first post of the facet's window. `stride`: elements from one row to the next, a multiple of LANES (rows.h). */
void soil_facet_rows(const struct facet *facet, size_t stride, int32_t *under, int32_t *rest);

#endif
