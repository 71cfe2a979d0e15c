/*
 * What a tilted box covers of the cells of posts. Its soles are parallelograms in plan. A post below a sole bears the exact part of its cell below that
 * sole. Parts of cells whose post does not lie below the same sole are given to the nearest post that does, up to two posts away. So are the edges from
 * which walls rise.
 */
#ifndef FURROW_SOIL_COVER_BOX_H
#define FURROW_SOIL_COVER_BOX_H

#include "soil/law/posts.h"

/* Sets own, share, middle, half_line and edges of all posts. Before, they are those of a level box: as it begins to tilt it goes over from these. Pure. */
void soil_cover_box(const struct soil_body *body, const struct soil_form *form, struct soil_posts *posts);

#endif
