/* Which facets of a body push on the soil, and how: src/soil/faces/push.c. */
#ifndef FURROW_SOIL_PUSH_H
#define FURROW_SOIL_PUSH_H

#include "soil/faces/faces.h"

/* Lists the facets that push into the arrays of `faces`, which have room for all, and sets faces->count. axes: forward, left and up of the body in the
 * frame. tangent: of the friction between soil and surface. */
void soil_push(const struct soil_body *body, const struct soil_form *form, const struct soil_facets *facets, const float axes[3][3], float tangent, struct soil_faces *faces);
/* Finds the forces of a block of facets for each pascal, their wedges, and what the soil's inertia does. Others need none of that: a facet that is not in soil pushes
 * nothing whatever they are. first: of the block. */
void soil_push_forces(const struct soil_form *form, struct soil_faces *faces, size_t first);
/* Gives how the forces of a block of facets, for each pascal, change as their places move on: rows force, columns motion; m2/m. first: of the block; by_modulus: 1/m. */
void soil_push_changes(const struct soil_form *form, const struct soil_faces *faces, size_t first, float by_modulus, float changes[3][3][POSTS_LANES]);

#endif
