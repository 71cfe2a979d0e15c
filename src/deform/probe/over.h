/*
 * The lower envelope of a probed body over a batch of posts. It is what face.h and cover.c say of one place, at a place of each lane.
 *
 * Level wheels, and the sides of cylinders, have loops without branches of their own. x, y: places in the body's frame, m.
 * Results do not overlap with arguments.
 */
#ifndef FURROW_DEFORM_PROBE_OVER_H
#define FURROW_DEFORM_PROBE_OVER_H

#include "deform/probe/form.h"
#include "deform/probe/lanes.h"

/* For a level wheel: sets all that a batch says of the body at the posts. Posts whose part of the cell is surely above the ground get share 0. */
void deform_over_wheel(const struct probe_form *form, struct lanes *l);
/* The same of one lane, for bodies of other kinds. Returns false for such a post, and for one that the body does not cover. */
bool deform_over_post(const struct probe_form *form, struct lanes *l, int i);
/* Sets `passed`: when the body's surface came to the post. Needs `plastic`. */
void deform_over_passed(const struct probe_form *form, struct lanes *l);
/* Gives the lower envelope. */
void deform_over_faces(const struct probe_form *form, const struct lanes *l, const double x[LANES], const double y[LANES], struct lane_faces *faces);
/* Gives its height alone. */
void deform_over_heights(const struct probe_form *form, const struct lanes *l, const double x[LANES], const double y[LANES], double height[LANES]);
/* Gives how it bends, as probe_bends_at; ends: 1 where a flat end bears, as probe_bears_by_end. faces: at the places. */
void deform_over_bends(const struct probe_form *form, const struct lanes *l, const double x[LANES], const double y[LANES], const struct lane_faces *faces,
		       double bends[3][LANES], double ends[LANES]);
/* Gives how much lower than now the body was above the places in the contact, and how long ago, in contacts. Needs `lowered` and `back`. */
void deform_over_lowered(const struct probe_form *form, const struct lanes *l, const double x[LANES], const double y[LANES], double lowered[LANES],
			 double since[LANES]);

#endif
