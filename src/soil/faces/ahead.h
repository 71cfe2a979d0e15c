/* The surface of the soil from which the depth of a facet counts: src/soil/faces/ahead.c. */
#ifndef FURROW_SOIL_AHEAD_H
#define FURROW_SOIL_AHEAD_H

#include "soil/faces/faces.h"

/* Reads the surface as it is into faces->surface, m above the centre at `to`. faces->rect lies in the planes. */
void soil_ahead_read(const struct soil_planes *planes, int32_t reference, const struct soil_pose *to, struct soil_faces *faces);
/* Sets faces->ahead for the body raised by so much, m. */
void soil_ahead_put(const struct soil_planes *planes, const struct soil_body *body, const struct soil_form *form, const struct soil_posts *posts, float raised,
		    struct soil_faces *faces);

#endif
