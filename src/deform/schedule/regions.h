/*
 * Cuts active blocks into regions. A region is a rectangle of blocks that is computed as one, in one rectangle of an atlas with one rim
 * around it. So blocks beside each other share their rims. It need not be full: other blocks in it are not active, or belong to
 * another region. What is computed for a post does not depend on its region.
 *
 * A run is a row of blocks of one region that lie side by side. Runs are copied as one.
 *
 * One thread at a time uses it. It starts as {0}.
 */
#ifndef FURROW_DEFORM_REGIONS_H
#define FURROW_DEFORM_REGIONS_H

#include "deform/deform.h"

struct region {
	int64_t x, y;           /* the block in the south-west corner */
	uint32_t columns, rows; /* blocks */
	uint32_t number;        /* its place in the list of regions, from 0 */
	uint32_t atlas;         /* number of the atlas that holds it */
	uint32_t at_x, at_y;    /* place of the first post of the first block in the atlas; multiples of REGION_ALIGN */
	uint32_t first_run, run_count;
};

struct run {
	struct soil_block first;
	uint32_t count;  /* blocks */
	uint32_t region;
	uint32_t slot;   /* number of its first block: blocks are counted in the order of the runs */
};

/* A row of regions in an atlas. */
struct shelf {
	uint32_t atlas, y, height, x; /* its first row of posts, its rows, and the first column that is free */
};

struct regions {
	struct region *regions; /* in the order of their atlases */
	struct run *runs;       /* in the order of their regions */
	size_t region_count, run_count, atlas_count;
	uint32_t *owners;       /* only while cutting: for each block of the set, 1 + number of its region; 0: none yet */
	struct shelf *shelves;  /* only while cutting */
	size_t room;            /* blocks for which there is memory */
};

#define REGION_ALIGN 16

/* What the cut depends on, beside the blocks. */
struct region_limits {
	uint32_t side;    /* posts along a side of the atlas */
	uint32_t rim;     /* posts around a block that are read; less than a block */
	int64_t cells;    /* of a tile: no run lies on blocks that begin in different tiles */
	uint32_t in_row;  /* slots in a row: no run goes beyond the end of a row */
};

void deform_regions_finish(struct regions *regions);
/* Cuts all blocks of a set. Each belongs to exactly one region, and to one run of it. */
enum status deform_regions_cut(const struct soil_block_set *set, const struct region_limits *limits, struct regions *regions) FURROW_CHECKED;
/* Makes one region of one block that need not be in a set. */
enum status deform_regions_one(struct soil_block block, const struct region_limits *limits, struct regions *regions) FURROW_CHECKED;
/* Returns how many blocks lie side by side in an atlas at most. Pure. */
uint32_t deform_region_blocks(const struct region_limits *limits);

#endif
