/*
 * Laying: where the soil goes that a contact displaces, in bands beside the patch that the body touches (SOIL.md, "Laying").
 *
 * A contact is laid in three steps. soil_laying_of tells to which sides of the body its soil goes, from shape and motion alone. The contact
 * adds what it displaces, row by row, to a struct soil_measured. soil_lay then computes the weight of each free post in the bands, and gives
 * each its soil.
 *
 * Invariants: (1) What is laid, and what is compacted, is together what was carried, to the unit. (2) The result does not depend on the
 * window, nor on the order of the bodies whose soil is laid into the same posts. (3) A post that a body touches, or that has no data, gets
 * nothing.
 *
 * All of it is pure, allocates nothing, and may be called by any thread. Places in the body's frame are in 2^-16 post; x points where the body
 * heads, y to its left. Amounts of soil are in fixed-point units.
 */
#ifndef FURROW_SOIL_LAYING_H
#define FURROW_SOIL_LAYING_H

#include "soil/soil.h"

#define SOIL_HOLLOW_MOST (1 << 23) /* fixed-point units: a deeper hollow counts as this */
enum { SOIL_AHEAD, SOIL_BEHIND, SOIL_LEFT, SOIL_RIGHT, SOIL_FACES }; /* faces of the rectangle around the patch */

/* How one soil is laid. Computed once for a drive. */
struct soil_laid {
	int32_t factor; /* in the square of a band's width, 2^-24: soil_lay */
	int32_t share;  /* of the depth of the hollow that is laid, 2^-16 */
	int32_t fall;   /* of its surface where it is laid, fixed-point units for each post */
};
/* angle: at which displaced soil is laid, rad. share: of the displaced soil, 0 .. 1. spacing: metres. */
struct soil_laid soil_laid_of(double angle, double share, double spacing);

/* How a contact lays soil. */
struct soil_laying {
	bool around;       /* all around the patch; false: beside the faces of a rectangle around the patch, which heads as the body does */
	bool ends, sides;  /* false: nothing is laid ahead and behind; to the left and right */
	double heading;    /* rad: of the frame */
	double behind;     /* m: a wheel that goes on, or another body that rolls, lays over this length, from `beside` behind its axle on. Below 0: it rolls backwards.
			    * 0: all along its patch */
	int32_t axis[2];   /* x axis of the frame, 2^-16 */
	int64_t x, y;      /* the post south-west of the body's centre */
	double post[2];    /* its place from the centre, posts east and north */
	int32_t at[2];     /* its place in the frame */
	int32_t widest;    /* of a band, 2^-6 post */
	int32_t half_width; /* of a wheel, 2^-16 post; 0: the width of the patch is used */
	int32_t along;     /* how much the patch's length counts beside its width for the width of a band, 2^-16 */
	int32_t rolls;     /* share of the soil that is not pushed, 2^-16 */
	int32_t beside;    /* beside the patch soil is laid up to this |x|; INT32_MAX: all along */
	int32_t goes_on;   /* `behind` in 2^-16 post */
	int32_t shares[SOIL_FACES]; /* of the soil for each face, 2^-16 */
	double push[2];    /* unit vector in which the body pushes, east and north; 0: it pushes nowhere */
	double slides;     /* share of its motion by which it slides level and pushes, 0 .. 1: what it displaces by that is carried whole */
	bool front;        /* the part `pushed` of the soil is laid ahead of the front that pushes; false: all of it by `shares` */
	int32_t pushed;    /* 2^-16 */
	int64_t tall;      /* fixed-point units: of the body. What is pushed is laid no higher */
};
/* Tells how a contact from one pose to the other lays soil. turned: how far a wheel turned about its axis, rad, or a belt ran, m. rotated: how far another
 * body turned about local axes, rad; NULL: not. */
struct soil_laying soil_laying_of(const struct soil_shape *shape, const struct soil_pose *from, const struct soil_pose *to, double turned,
				  const double rotated[3], double spacing);
/* Lets what a body pushes be laid ahead of the front that pushes it. */
void soil_laying_ahead(struct soil_laying *laying);
/* Returns the frame with another x axis: a unit vector, east and north. */
struct soil_laying soil_laying_turned(const struct soil_laying *laying, const double ahead[2]);
/* Returns the widest band of a body, in posts. */
double soil_laying_band(const struct soil_shape *shape, double spacing);
/* Returns the shadow of a body and all posts on which it may lay soil. shadow: the posts that the body can be above in the contact. */
struct post_rect soil_laying_posts(const struct soil_laying *laying, const struct soil_shape *shape, const struct soil_pose *to, double spacing,
				   struct post_rect shadow);

/* Returns the place of a post in the frame: x, or y if `axis` is 1. The post lies less than 2^13 posts from the body. */
static inline int32_t soil_laying_place(const struct soil_laying *laying, int64_t x, int64_t y, int axis)
{
	const int64_t by_x = x - laying->x, by_y = y - laying->y;
	return (int32_t)(axis == 0 ? laying->at[0] + by_x * laying->axis[0] + by_y * laying->axis[1]
				   : laying->at[1] + by_y * laying->axis[0] - by_x * laying->axis[1]);
}

/* What a contact adds up for the laying of its soil. */
struct soil_measured {
	int64_t carried;         /* the soil that it displaced */
	uint32_t givers;         /* posts that carry soil */
	uint32_t classes;        /* of these posts: a bit for each class of soil */
	int32_t deep;            /* depth of the hollow: the most of soil_depth_of */
	int32_t least[2], most[2]; /* the outermost places of the patch in the frame, x and y */
	struct post_rect patch;  /* around the posts that the body touches */
	struct post_rect hollows; /* around the posts below the body that it does not touch. Only if laying->front */
	int64_t highest;       /* fixed-point units: the highest place of the lower envelope where the body holds a post. Only if laying->front */
	int64_t moments[6];      /* of the carried soil about the frame's post: 1, x, y, x x, x y, y y; posts east and north, 2^-16 m. Only if laying->front */
};
void soil_measured_begin(struct soil_measured *measured);

/* Returns how deep the hollow counts at a post. carried: soil that the post gives away; offset: after the contact; dug: all that slip has
 * dug there. of_dug, share: of that, and of the rest of the depth, that is laid, 2^-16. */
static inline int32_t soil_depth_of(int32_t carried, int32_t offset, int32_t dug, int32_t of_dug, int32_t share)
{
	const int32_t down = offset > 0 ? 0 : offset < -SOIL_HOLLOW_MOST ? SOIL_HOLLOW_MOST : -offset;
	const int32_t part = dug < 0 ? 0 : dug > down ? down : dug;
	const int32_t counted = (int32_t)(((uint32_t)(part >> 8) * (uint32_t)of_dug) >> 8);
	const int32_t depth = (int32_t)(((uint32_t)((down - counted) >> 8) * (uint32_t)share) >> 8) + counted;
	return carried > depth ? carried : depth;
}

/* Adds a row of the patch: post (first, y), the first that the body touches, to (last, y), the last. */
static inline void soil_measured_add(struct soil_measured *measured, const struct soil_laying *laying, int64_t y, int64_t first, int64_t last,
				     int64_t carried, uint32_t givers, uint32_t classes, int32_t deep)
{
	measured->carried += carried;
	measured->givers += givers;
	measured->classes |= classes;
	measured->deep = deep > measured->deep ? deep : measured->deep;
	for (int k = 0; k < 2; k++) {
		const int32_t a = soil_laying_place(laying, first, y, k), b = soil_laying_place(laying, last, y, k);
		const int32_t least = a < b ? a : b, most = a < b ? b : a;
		measured->least[k] = least < measured->least[k] ? least : measured->least[k];
		measured->most[k] = most > measured->most[k] ? most : measured->most[k];
	}
	measured->patch = post_rect_around(measured->patch, (struct post_rect){first, y, last + 1, y + 1});
}

/* Adds what a post gives away to the moments. */
static inline void soil_measured_moments(struct soil_measured *measured, const struct soil_laying *laying, int64_t x, int64_t y, int32_t carried)
{
	const int64_t weight = (carried + 15) >> 4, east = x - laying->x, north = y - laying->y;
	const int64_t parts[6] = {1, east, north, east * east, east * north, north * north};
	for (int k = 0; k < 6; k++)
		measured->moments[k] += weight * parts[k];
}

/* Adds what another part of the body added up with the same laying. */
static inline void soil_measured_join(struct soil_measured *measured, const struct soil_measured *part)
{
	measured->carried += part->carried;
	measured->givers += part->givers;
	measured->classes |= part->classes;
	measured->deep = part->deep > measured->deep ? part->deep : measured->deep;
	for (int k = 0; k < 2; k++) {
		measured->least[k] = part->least[k] < measured->least[k] ? part->least[k] : measured->least[k];
		measured->most[k] = part->most[k] > measured->most[k] ? part->most[k] : measured->most[k];
	}
	measured->patch = post_rect_joined(measured->patch, part->patch);
	measured->hollows = post_rect_joined(measured->hollows, part->hollows);
	measured->highest = part->highest > measured->highest ? part->highest : measured->highest;
	for (int k = 0; k < 6; k++)
		measured->moments[k] += part->moments[k];
}

/* A row of posts after a contact. dug and classes may be NULL: then they count as zeros. */
struct soil_row {
	int64_t x, y; /* its first post */
	int count;
	const uint8_t *contact;                /* SOIL_LOWERED, SOIL_HELD */
	const int32_t *carried, *offset, *dug; /* what the body does not touch does not count */
	const uint8_t *classes;                /* below SOIL_CLASSES, or counts as the last one */
};
/* Adds a row of posts, of which the body touches some or none. */
void soil_measure_row(struct soil_measured *measured, const struct soil_laying *laying, const struct soil_laid soils[SOIL_CLASSES],
		      const struct soil_row *row);

/* What soil_lay did. */
struct soil_lay_result {
	int64_t compacted;  /* soil that found no place */
	uint64_t confined;  /* posts whose soil found none, since no post of the bands is free */
	uint64_t refused;   /* remainders that one post cannot hold */
	struct post_rect posts; /* around the posts of the bands that could take soil; empty: none */
};
/* Returns the bytes of scratch memory that soil_lay needs for so many posts in x and y. */
size_t soil_lay_scratch(size_t width, size_t height);
/*
 * Lays the soil of one contact: adds to `deposits`, a plane of planes->width posts in a row. Of the planes it reads base and contact. Soil is
 * laid on posts of `written` alone, a part of planes->rect. A post whose contact has SOIL_LOWERED or SOIL_HELD gets nothing, whichever body
 * touches it. carried: a plane of what each post that this body touches gives away; read if laying->front, else it may be NULL. patch: a plane in which only the posts that this body touches have one of these bits; it is read if laying->around or laying->front. With a
 * single body it is planes->contact. scratch: aligned to 8 bytes. The calls for several bodies may come in any order.
 */
void soil_lay(const struct soil_laying *laying, const struct soil_measured *measured, const struct soil_laid soils[SOIL_CLASSES],
	      const struct soil_planes *planes, const uint8_t *patch, const int32_t *carried, struct post_rect written, void *scratch, int32_t *deposits,
	      struct soil_lay_result *result);

#endif
