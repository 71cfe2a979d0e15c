/* The upper envelope below the cells of a body that carries soil. It tells how much of each cell is above the body, and over which sills soil passes. Pure. */
#ifndef FURROW_SOIL_CARRIED_TOPS_H
#define FURROW_SOIL_CARRIED_TOPS_H

#include "soil/carried.h"

#define CARRIED_SHARES 64      /* of a cell: the whole of it */
#define CARRIED_MOST (1 << 29)  /* fixed-point units: the most soil above a cell */

/* What is known of cells beside their tops, which are means: `scratch` of struct soil_carried. */
struct soil_carried_cells {
	uint8_t *shares;  /* how much of a cell is above the body, 1 .. CARRIED_SHARES; of CARRIED_OPEN any */
	uint8_t *rough;   /* walls pass through it, or it is steep */
	int32_t *lips;    /* where soil leaves it to beside the body, as tops; CARRIED_OPEN: nowhere */
	int32_t *sills[4]; /* above which soil passes to the next cell along (1, 0), (0, 1), (1, 1), (-1, 1); CARRIED_OPEN: at any height */
	void *raster;
};

/* Makes and frees it: STATUS_MEMORY; NULL is freed, too. */
enum status soil_carried_cells_make(const struct soil_shape *shape, int side, struct soil_carried_cells **out) FURROW_CHECKED;
void soil_carried_cells_free(struct soil_carried_cells *cells);
/* Computes tops, shares, lips and sills in the attitude of a pose. */
void soil_carried_find_tops(struct soil_carried *carried, const struct soil_pose *pose);

/* Finds the cell nearest to a place, 2^-20 m. Returns false if it has none. */
bool soil_carried_cell(const struct soil_carried *carried, const struct soil_pose *pose, int64_t x, int64_t y, size_t *cell);

/* Returns the height of the soil in a cell above the body's centre. */
static inline int64_t soil_carried_height(const struct soil_carried *carried, size_t cell)
{
	const struct soil_carried_cells *cells = carried->scratch;
	return carried->tops[cell] + (int64_t)carried->amounts[cell] * CARRIED_SHARES / cells->shares[cell];
}

#endif
