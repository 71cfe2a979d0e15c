/* What the files ground*.c share. */
#ifndef FURROW_RESIDENT_GROUND_INTERNAL_H
#define FURROW_RESIDENT_GROUND_INTERNAL_H

#include "base/key_map.h"
#include "base/recent.h"
#include "resident/resident.h"

struct ground {
	struct store_reader *reader; /* used by the owner */
	const struct store_meta *meta;
	const struct relief *relief; /* of the store; NULL: none */
	const struct rocks *rocks;   /* the same */
	int32_t reference;
	int finest; /* the finest level with base tiles, at most 0 */
	struct mutex mutex; /* guards the rest */
	struct recent recent;
	int32_t **posts; /* by place number in `recent`; NULL: never used */
	uint32_t latest;
	int32_t *spare;  /* an unused tile buffer; may be NULL */
	struct resident_ground_figures figures;
	/* ground_ranges.c */
	struct key_cache bases;   /* a: lowest, b: highest base in metres; NaN: all is nodata */
	struct key_cache errors;  /* a: metres */
	struct key_cache bends;   /* ground_bend.c. a: metres */
	/* as in the store. a: lowest, b: highest, in metres; NaN: no offsets. All are kept, unless `most` is set lower */
	struct key_cache offsets;
	struct key_cache stored; /* of levels below 0. a: 1: the store has this base tile; 0: it has not */
	uint64_t forgotten; /* how often all of `offsets` were forgotten */
};

/* Gives the stored posts of a tile that the store has, for the owner. They are valid while the mutex is held. */
enum status resident_ground_posts_locked(struct ground *ground, struct tile tile, const int32_t **posts) FURROW_CHECKED;
/* Widens low .. high by all posts of a rectangle that are not nodata. Rows are `stride` posts apart. Returns true if all have data. */
bool resident_ground_widen(const int32_t *posts, uint32_t width, uint32_t height, uint32_t stride, int32_t *low, int32_t *high);

#endif
