/*
 * The soil's law over the posts of a body: what they bear in one pose. A contact, its search for the equilibrium height and a probe evaluate it;
 * SOIL.md describes its steps. Stresses are summed as whole numbers, so no order of posts shows.
 */
#ifndef FURROW_SOIL_BEAR_H
#define FURROW_SOIL_BEAR_H

#include "soil/law/posts.h"

#define BEAR_UNITS_A_PASCAL 16.0f /* of the whole numbers */
#define BEAR_MOST 2147483000.0f   /* the largest of them */
#define BEAR_AREA_UNITS 65536.0f   /* a post's area */

/* Sums in the body's frame: x forwards, y to its left. */
struct soil_sums {
	int64_t force[3], moment[3], pull; /* units of Pa / 16 times a post's area; moments: times `arm` of the form */
	int64_t area;                      /* of the ground that bears, in 1 / BEAR_AREA_UNITS of a post */
	int64_t held;                      /* posts on which the body lies */
	int64_t saturated;                 /* posts with a larger stress than can be counted */
	int32_t deepest;                   /* fixed-point units: of the lower envelope below the base, where it bears */
	double grows;                      /* of the vertical force as the body sinks, units for each m. Without `kept` and `changes` alone; else 0 */
};

/* What a probe adds up beside these: the body's frame; forces come before moments, translations before rotations. N, m, rad. */
struct soil_matrix {
	double at[6][6];
};
struct soil_changes {
	double normal[3], normal_force, shear_limit, sheared[3];
	struct soil_matrix stiffness, damping;
};

/* What a contact keeps of each post for its new state. Arrays of the posts' length. */
struct soil_kept {
	float *more;              /* m: what slip digs */
	float *shear_x, *shear_y; /* mobilised shear after, in the frame */
	float *flat, *flattest;   /* m: by how much a tyre's surface is above its rim there, in its pose and in its deepest pose. Of a tyre alone */
};

/* Evaluates the law with the centre raised by so many fixed-point units. share: stresses are divided by it. kept, changes: NULL, or what is asked. */
void soil_bear(const struct soil_form *form, const struct soil_posts *posts, int32_t raised, float share, struct soil_sums *sums, struct soil_kept *kept,
	       struct soil_changes *changes);
#if !SOIL_LAYERED
/* The same of posts with layers: bear_layered.c. */
void soil_bear_layered(const struct soil_form *form, const struct soil_posts *posts, int32_t raised, float share, struct soil_sums *sums, struct soil_kept *kept,
		       struct soil_changes *changes);
#endif

#endif
