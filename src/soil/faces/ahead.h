/* The ground from which the depth of a facet counts: src/soil/faces/ahead.c. */
#ifndef FURROW_SOIL_AHEAD_H
#define FURROW_SOIL_AHEAD_H

#include "soil/faces/faces.h"

/* Reads the ground around the body, m above its centre at `to`. faces->rect lies in the planes. knows: where they have what slip dug. */
void soil_ahead_read(const struct soil_planes *planes, int32_t reference, const struct soil_pose *to, struct post_rect knows, struct soil_faces *faces);
/* Sets the ground as the body finds it. within: part of the planes that is read, whatever more they have; spacing: m. */
void soil_ahead_find(const struct soil_planes *planes, const struct post_rect *within, float spacing, struct soil_faces *faces);
/* Sets the body's lower envelope over the posts, m above its centre. */
void soil_ahead_body(const struct soil_body *body, const struct soil_form *form, struct soil_faces *faces);
/* Carries the ground ahead below the body raised by so much, m, and sets posts->heap. wedge: m, the length of the wedge ahead. */
void soil_ahead_put(const struct soil_planes *planes, const struct soil_body *body, const struct soil_form *form, struct soil_posts *posts, float raised, float wedge,
		    struct soil_faces *faces);

#endif
