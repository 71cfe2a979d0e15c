/*
 * Bodies over the same ground: at each place the lowest of them bears, and those that are equally low share the place. So two halves of a wheel, four
 * parts of a plate, and two bodies in one place bear as one body.
 */
#ifndef FURROW_SOIL_MEET_H
#define FURROW_SOIL_MEET_H

#include "soil/law/posts.h"

/* A body that may be over the same ground. */
struct soil_met {
	const struct soil_body *body;
	const struct soil_form *form;
	int32_t raised; /* fixed-point units: its centre is so much above the end of its motion */
};

/* The same, as seen from the frame of another body's posts. */
struct soil_seen {
	const struct soil_form *form;
	float own;                 /* face.h */
	float turn[2], at[2];      /* from a place in that frame to one in its own */
	float above;               /* m: its centre above that of the posts */
	float middle[2], reach[2]; /* m, in that frame: it lies within these */
	float lowest;              /* m: no place of it is lower */
};
/* Gives others as they are seen from the frame of `self`. Pure. */
void soil_meet_see(const struct soil_met *self, const struct soil_met *others, size_t count, struct soil_seen *seen);

/* Takes from each post's share what others bear of it. form: of the posts. Returns true if they took anything. Pure. */
bool soil_meet_share(const struct soil_form *form, const struct soil_seen *seen, size_t count, struct soil_posts *posts);

/* A body together with those that abut it: there is no gap between them in plan, and their lowest places are about equally high. */
struct soil_whole {
	double more[2][2];      /* m: how much farther than itself it reaches behind and ahead, right and left */
	double wider;           /* than its own: the width of the patch that they have together */
};
/* Finds it. across: the width counts across the frame's x axis alone. own: m along the frame's axes, of which the lesser is the width; 0: the width is
 * that of the patch's area. abuts: which of the others belong to it. Pure. */
void soil_meet_whole(const struct soil_met *self, const struct soil_met *others, size_t count, bool across, const double own[2], bool *abuts,
		     struct soil_whole *whole);

#endif
