/*
 * The elastic sheet: a membrane under tension T (N/m) on a bed of springs k (Pa/m), after Chanclou, Luciani and Habibi (1996). Its deflection w
 * obeys T lap(w) - k w = -p. A body holds it down to the body's lower envelope, which is an obstacle: the sheet lies on it or below it. Beyond the
 * yield a share of what the sheet went down stays, as a rut. The rest comes back when the body goes, to the unit.
 *
 * A post's deflection is how far it is below the sheet's own surface, which is where it would be if nothing held. The plane keeps both the
 * deflection and whether a body holds the post (struct soil_planes, `floor`). Its invariant: a deflection that is not 0 has a held
 * post within `reach` posts, along x and along y. So what is left when the last body went is 0, however exact the solution was.
 *
 * All is whole numbers, and the number of rounds is fixed. So the bits do not depend on threads, tiles or instruction sets. Pure.
 */
#ifndef FURROW_SOIL_SHEET_H
#define FURROW_SOIL_SHEET_H

#include "soil/kinematic/kinematic.h"

#define SOIL_SHEET_POSTS 16  /* the longest characteristic length, posts */
#define SOIL_SHEET_MOST (1 << 23) /* fixed-point units: the greatest deflection, 8 m */

/* A sheet over posts of one spacing. */
struct soil_sheet {
	uint32_t relax[5];   /* 2^-31: over-relaxation times the weight of the neighbours' sum, by how many of them have ground */
	uint32_t over;       /* 2^-31: over-relaxation less 1 */
	int rounds;
	int32_t reach;       /* posts around a held one that the sheet's deflection reaches */
	int32_t yield;       /* fixed-point units; SOIL_SHEET_MOST: it does not yield */
	uint32_t share;      /* 2^-31: of what is beyond the yield, what stays */
	uint32_t spring;     /* (spacing / length)^2 = spring x 2^-spring_bits; at least 2^30 */
	int spring_bits;
};

/* Prepares a sheet. length: sqrt(T / k), m, at most SOIL_SHEET_POSTS spacings. yield: m, may be INFINITY. share: 0 .. 1. spacing: m between posts. */
void soil_sheet_prepare(struct soil_sheet *sheet, double length, double yield, double share, double spacing);
/* Returns how many posts around a held post are deflected. */
int64_t soil_sheet_reach(double length, double spacing);

/* A post of the plane. */
static inline int32_t soil_sheet_deflection(int32_t post)
{
	return post >> 1; /* fixed-point units */
}

static inline bool soil_sheet_held(int32_t post)
{
	return (post & 1) != 0;
}

/* A body over a sheet. */
struct soil_sheet_contact {
	struct soil_kinematic_contact body; /* from: where the body held the sheet until now */
	bool leaves;                        /* it is taken away from `from`; `to` is not read */
};

/* Returns all posts that a contact may read or change, and more if the body turns. reach: of the sheet. */
struct post_rect soil_sheet_posts(const struct soil_sheet_contact *contact, int64_t reach, double spacing);

/* Returns the bytes of scratch memory for a window of so many posts. loaded: soil_sheet_rest is called. */
size_t soil_sheet_room(const struct soil_shape *shape, size_t width, size_t height, bool loaded);

/* Where a body with a load rests on a sheet. */
struct soil_sheet_rest {
	int64_t z;       /* 2^-20 m: height of its origin */
	int64_t sinkage; /* fixed-point units: its greatest depth below the base, where the sheet bears it; 0: it is above the base */
	int64_t posts;   /* that it holds; 0: no post is below it */
	bool sunk;       /* a sheet that it deflects by 8 m does not bear it */
};
/*
 * Finds the height at which a sheet bears a body. There k w - T lap(w), summed over the posts that it holds, is its load, within 1/4000. contact->body.to.z is
 * where the search begins. load: N; tension: N/m. Takes some solutions, 6 to 30. Changes no offset and no floor. `planes` and `scratch` as for soil_sheet_run.
 */
struct soil_sheet_rest soil_sheet_rest(const struct soil_sheet *sheet, const struct soil_kinematic *kinematic, const struct soil_sheet_contact *contact,
					    double load, double tension, const struct soil_planes *planes, void *scratch);

/*
 * Computes a contact over a window. planes: base, offset, floor and contact must be there, over soil_sheet_posts() where the world has posts.
 * Changes offset, floor and contact. Posts that other bodies hold stay as they are, unless this one holds them deeper. What the sheet went down
 * counts as compacted; what it comes back is taken off that. *changed: a rectangle around the posts whose offset or floor changed; empty: none.
 * scratch: soil_sheet_room() bytes, aligned to 8.
 */
void soil_sheet_run(const struct soil_sheet *sheet, const struct soil_kinematic *kinematic, const struct soil_sheet_contact *contact,
		    const struct soil_planes *planes, void *scratch, struct soil_kinematic_tally *tally, struct post_rect *changed);

#endif
