/* Where a form is above a place, and which part of a post's cell it bears. Read by cover.c, and by meet.c for several bodies. */
#ifndef FURROW_SOIL_PARTS_H
#define FURROW_SOIL_PARTS_H

#include "soil/law/form.h"

#define BESIDE 2e-6f /* m: a post nearer to a side lies below it */

/* What a post bears across a body with straight sides: from low to high, in posts from this post. */
struct part {
	float low, high;
	float begins, ends; /* 1: at that side the body ends */
};

/* here: the post's place across the strip; lower, upper: of the posts next to it; size: half the strip's width; m. A part goes half way to the next
 * post that the body covers too, or to the strip's side, but no farther than that post. */
SOIL_INLINED struct part part_of(float lower, float here, float upper, float size, float step)
{
	const float closest = 0.25f * step;
	const bool begins = !(fabsf(lower) <= size + BESIDE), ends = !(fabsf(upper) <= size + BESIDE);
	const float low = most((-size - here) / most(here - lower, closest), -1), high = least((size - here) / most(upper - here, closest), 1);
	return (struct part){either(begins, low, -0.5f), either(ends, high, 0.5f), either(begins, 1, 0), either(ends, 1, 0)};
}

/* Returns `own` of face.h. It is the same for all posts of a form. */
SOIL_INLINED float own_of(const struct soil_form *f, enum soil_form_kind kind)
{
	return kind == FORM_END ? (2 * f->half_axis * f->level < 0.25f * f->spacing ? 1 : 2) : 0;
}

/* Returns true if a form is above a place, in plan. */
SOIL_INLINED bool is_above(const struct soil_form *f, enum soil_form_kind kind, float x, float y)
{
	if (kind == FORM_CAPSULE) {
		const float axial = f->along[0] * x + f->along[1] * y, aside = f->along[0] * y - f->along[1] * x, straight = f->half_axis * f->level;
		const float beyond = most(fabsf(axial) - straight, 0), far = f->radius + BESIDE;
		return aside * aside + beyond * beyond <= far * far;
	}
	if (kind == FORM_END) {
		const float disc = fabsf(f->lean) * half_strip(f, x) + f->half_axis * f->level;
		return (fabsf(x) <= f->radius + BESIDE) & (fabsf(y) <= disc + BESIDE);
	}
	bool is = true;
	for (int k = 0; k < 3; k++)
		is = is & (fabsf(f->slabs[k][0] * x + f->slabs[k][1] * y) <= f->slabs[k][2] + BESIDE);
	return is;
}

#endif
