/* What a body covers of the cells of posts, and how low it is there: src/soil/law/cover.c. */
#ifndef FURROW_SOIL_COVER_H
#define FURROW_SOIL_COVER_H

#include "soil/law/posts.h"

/* Sets over, own, height, slope, above, lowered, swept, print, share, middle, sides and room of all posts. Pure. */
void soil_cover(const struct soil_body *body, const struct soil_form *form, struct soil_posts *posts);

#endif
