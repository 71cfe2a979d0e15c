/*
 * Sumner's rule, by which steep soil sheds: the same bits as shaders/deform/slide_shed.frag and slide_take.frag. In an iteration each post first
 * tells how much soil it sheds to each lower neighbour. Then each post takes what its neighbours shed. Both are loops over a row of heights;
 * soil/sliding makes the heights and knows which posts slide. Pure.
 */
#ifndef FURROW_SOIL_SHED_H
#define FURROW_SOIL_SHED_H

#include "soil/soil.h"

#define SHED_STILL INT32_MIN /* a height: the post gives no soil and takes none */

/* The limits of a soil: differences of heights between neighbours, fixed-point units. Index 0: along x or y; 1: diagonal. They include the
 * tolerance. */
struct soil_shed_class {
	int32_t critical[2]; /* soil moves above this */
	int32_t held[2];     /* the same if a body holds one of the two posts */
	int32_t stop[2];     /* a post sheds only if a difference exceeds this */
	uint32_t share[8];   /* 2^-32: of the sum of differences, what each of 1 .. 8 neighbours gets */
};

/* The rule. Classes that no soil has are zeros. */
struct soil_shed {
	struct soil_shed_class classes[SOIL_CLASSES];
	bool undisturbed_stable; /* soil moves only where the difference has grown by more than the tolerance since before all drives */
	int32_t tolerance;       /* fixed-point units */
};

/* Prepares the rule. count: of soils. tolerance: m. */
void soil_shed_begin(struct soil_shed *rule, const struct soil_numbers *soils, int count, double spacing, double tolerance, bool undisturbed_stable);
/* Prepares the limits of a soil. spacing: m between posts; tolerance: fixed-point units. */
void soil_shed_prepare(const struct soil_numbers *soil, double spacing, int32_t tolerance, struct soil_shed_class *to);

/* Finds the difference of heights, axial and diagonal, that some neighbour of a post exceeds before the post sheds anything. count: of soils. */
void soil_shed_least(const struct soil_shed *rule, int count, int32_t least[2]);
/* Returns true if soil beside a post that a body holds is stable up to the same difference as elsewhere, or a greater one. Otherwise a body can set
 * soil in motion by holding it. */
bool soil_shed_held_is_stable(const struct soil_shed *rule, int count);

/* Rows of posts: of the southern neighbours, the posts themselves, the northern neighbours. Index -1 and `count` are read too. */
struct soil_shed_rows {
	int32_t count;
	const int32_t *heights[3];   /* fixed-point units in 32 bits that wrap, or SHED_STILL */
	const uint8_t *contacts[3];  /* SOIL_HELD counts */
	const int32_t *grounds[3];   /* 4 base, in 32 bits that wrap; read if undisturbed_stable */
	const uint8_t *classes;      /* of the posts; NULL: all are of class 0 */
	const int32_t *rooms[3];     /* how much soil each post takes from a neighbour at most, fixed-point units; NULL: any */
};

/* Computes what each post sheds. Bits 0 to 22: soil for each neighbour that gets some. From bit 23 on: a bit for each of the eight. */
void soil_shed_row(const struct soil_shed *rule, const struct soil_shed_rows *rows, int32_t *shed);

/* Computes by how much each post's height changes. sheds, rooms: rows as in struct soil_shed_rows; rooms NULL: any. moves: 1 where the post gives or gets soil, even if both
 * are equal; NULL: not wanted. shares_count: a share that is rounded to 0 counts as soil: over windows it does, over blocks not. */
void soil_shed_take_row(int32_t count, const int32_t *const sheds[3], const int32_t *const rooms[3], bool shares_count, int32_t *change, uint8_t *moves);

#endif
