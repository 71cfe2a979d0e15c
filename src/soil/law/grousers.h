/* How low a wheel's grousers are at posts. */
#ifndef FURROW_SOIL_GROUSERS_H
#define FURROW_SOIL_GROUSERS_H

#include "soil/law/posts.h"

/* Scratch memory. Zero it before the first use. */
struct soil_grousers_work {
	float *memory;
	size_t room;
};

/* Draws the bars of a wheel over posts that may be below it: sets form->grousers, which points into `work`. STATUS_MEMORY: no room. */
enum status soil_grousers_draw(const struct soil_body *body, const struct post_rect *below, struct soil_form *form, struct soil_grousers_work *work) FURROW_CHECKED;
void soil_grousers_finish(struct soil_grousers_work *work);

/* Lowers the wheel at posts to its bars: sets above, over, lowered and swept. Pure. */
void soil_grousers_cover(const struct soil_body *body, const struct soil_form *form, struct soil_posts *posts);

#endif
