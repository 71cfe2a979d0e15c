/* How much a flat sole bears while it slides: footing.c. */
#ifndef FURROW_SOIL_FOOTING_H
#define FURROW_SOIL_FOOTING_H

#include "soil/faces/faces.h"

/* Tells whether a body has flat soles: it is no rim, and no ball. */
SOIL_INLINED bool soil_footing_is(const struct soil_form *form)
{
	return form->kind == FORM_BOX || form->kind == FORM_END || (form->kind == FORM_RASTER && form->rolls_about != ROLLS_ABOUT_AXIS);
}

/* Finds the numbers of a soil. cohesion: that faces feel, Pa; along: the tangent of the friction along the sole; level: the part of its motion that is level, 0 .. 1. */
void soil_footing_of(const struct soil_numbers *soil, double cohesion, double along, double level, struct soil_footing *footing);
/* Returns the share of what is slid that the law of the lower envelope bears, 0 .. 1. way: the direction in which the body slides, in the frame, a unit vector.
 * Reads the depths and pressures of facets. */
float soil_footing_share(const struct soil_form *form, const struct soil_faces *faces, const float way[2]);

#endif
