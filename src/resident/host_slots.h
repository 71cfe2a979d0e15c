/*
 * Shared by the files host_*.c and pages_host.c: tiles in host memory.
 *
 * A tile has its own base, classes and levels. It may share its planes with other tiles: with the image of a commit, or of a load. A shared
 * plane is never written. The thread that wants to write it takes a copy first (resident_host_tile_write). So a commit and an eviction copy
 * nothing, and the writer thread reads planes while the owner goes on.
 *
 *     a plane:  free -> held by one tile, which may write it <-> shared by several, which only read it -> free
 *
 * Invariants:
 *   1. plane->refs counts the tiles that hold it. Only a tile that holds the plane shares it with another one. So refs stays 1 until the
 *      thread to which that tile belongs shares it.
 *   2. A plane is written only while one tile holds it, and by the thread to which this tile belongs. A tile in a slot belongs to the owner.
 *   3. A plane is in the list of free planes of its kind, or refs > 0. The zeros are never free, and never written.
 *   4. The memory of planes, bases, classes and levels is made when it is first needed, and freed with the slots.
 */
#ifndef FURROW_RESIDENT_HOST_SLOTS_H
#define FURROW_RESIDENT_HOST_SLOTS_H

#include <assert.h>
#include <stdatomic.h>

#include "resident/resident.h"

struct host_plane {
	_Atomic uint32_t refs;
	struct host_plane *next; /* in a list of free ones */
	_Alignas(16) unsigned char posts[];
};

struct host_tile {
	int32_t *base;             /* NULL: never needed; the same of classes and levels */
	uint8_t *classes, *levels;
	struct host_plane *planes[PLANES]; /* NULL: zeros */
};

struct host_entry {
	struct host_tile tile;
	bool shown_base, shown_planes;  /* the mirror has the base, the planes; planes but for `changed` */
	bool classed;                   /* the classes are those of this tile */
	struct gpu_rect changed;        /* posts of the tile */
};

struct host_slots {
	uint32_t cells, count;
	size_t posts;              /* of a tile */
	unsigned planes;
	struct host_entry *entries;
	struct host_plane *zeros;  /* of the widest plane; shared by images that must tell that a plane is zero */
	struct mutex mutex;        /* guards the rest */
	struct host_plane *free[PLANES];
	struct resident_host_figures figures;
};

/* host_planes.c. Any thread that a tile belongs to. */
/* Give the memory of a tile's base, classes or levels. Its content is undefined at first. */
enum status resident_host_tile_base(struct host_slots *slots, struct host_tile *tile, int32_t **base) FURROW_CHECKED;
enum status resident_host_tile_classes(struct host_slots *slots, struct host_tile *tile, uint8_t **classes) FURROW_CHECKED;
enum status resident_host_tile_levels(struct host_slots *slots, struct host_tile *tile, uint8_t **levels) FURROW_CHECKED;
/* Makes planes of the mask ready to be written: those that the tile lacks, with zeros, and copies of shared ones. On failure some are. */
enum status resident_host_tile_write(struct host_slots *slots, struct host_tile *tile, unsigned planes) FURROW_CHECKED;
/* Takes planes of the mask from the tile, so that they are zeros. */
void resident_host_tile_drop(struct host_slots *slots, struct host_tile *tile, unsigned planes);
/* Gives `to` the planes of `from`, shared, in place of its own. Planes of the mask that `from` lacks become the zeros; 0: they stay missing. */
void resident_host_tile_share(struct host_slots *slots, const struct host_tile *from, struct host_tile *to, unsigned zeros);
void resident_host_tile_finish(struct host_slots *slots, struct host_tile *tile); /* frees the tile's memory */
void resident_host_planes_finish(struct host_slots *slots);                       /* frees the planes; no tile has one any more */

static inline struct host_entry *host_entry(const struct host_slots *slots, uint32_t slot)
{
	assert(slot < slots->count);
	return &slots->entries[slot];
}

/* Returns the posts of a plane of a tile; NULL: it has none, or the zeros. */
static inline const void *host_tile_plane(const struct host_slots *slots, const struct host_tile *tile, int plane)
{
	const struct host_plane *held = tile->planes[plane];
	return held != NULL && held != slots->zeros ? held->posts : NULL;
}

/* Decimates where the pages' home is. host NULL: in slots of the GPU. */
static inline enum status host_or_gpu_decimate(struct host_slots *host, struct gpu_slots *slots, uint32_t fine, struct gpu_rect rect, int steps,
					       uint32_t coarse, uint32_t to_x, uint32_t to_y)
{
	return host != NULL ? resident_host_decimate(host, fine, rect, steps, coarse, to_x, to_y)
			    : gpu_slots_decimate(slots, fine, rect, steps, coarse, to_x, to_y);
}

#endif
