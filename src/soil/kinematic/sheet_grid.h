/* The unknowns of an elastic sheet over a window, for sheet.c and sheet_relax.c. */
#ifndef FURROW_SOIL_SHEET_GRID_H
#define FURROW_SOIL_SHEET_GRID_H

#include "soil/kinematic/sheet.h"

#define SHEET_BITS 6 /* more binary digits of a deflection while it is computed */

/* Bits of a post. */
enum { SHEET_GROUND = 1, SHEET_OTHER = 2 /* another body holds it */, SHEET_OWN = 4, SHEET_INSIDE = 8 /* it may change */, SHEET_BESIDE = 16, SHEET_NEAR = 32 };

/* Pointers are at the first post. Each row has one element more on each side, and there is a row more above and below; there all is 0. */
struct sheet_grid {
	int32_t width, height; /* posts */
	size_t stride;         /* elements from one row to the next */
	int64_t x0, y0;        /* the first post's place in the world */
	int32_t *deflection;   /* fixed-point units with SHEET_BITS more digits, 0 or more */
	int32_t *least;        /* of the deflection: how deep the body holds; 0: it does not */
	int32_t *surface;      /* offset of the sheet's own surface, fixed-point units */
	uint32_t *relax;       /* 0: the post does not move */
	uint8_t *marks;
	int32_t *row;          /* room for a row, or for a number of each column */
	int32_t x[2], y[2];    /* columns and rows around the posts that move: first, one behind the last */
};

/* Marks posts within `reach` of held ones as SHEET_NEAR, and tells by `relax` which of them move. Others that may change become 0. */
void soil_sheet_begin(struct sheet_grid *grid, const struct soil_sheet *sheet);
/* Moves the sheet towards T lap(w) = k w, at least as deep as `least`. Always takes the same number of rounds. */
void soil_sheet_relax(const struct sheet_grid *grid, const struct soil_sheet *sheet);

/* Returns the force of the sheet on what holds it, over its tension: as finely as a deflection. *posts: how many posts the body holds. */
int64_t soil_sheet_force(const struct sheet_grid *grid, const struct soil_sheet *sheet, int64_t *posts);

#endif
