/* A body sinks into the ground: src/soil/sink.c. */
#ifndef FURROW_SOIL_SINK_H
#define FURROW_SOIL_SINK_H

#include "soil/laying/laying.h"
#include "soil/soil.h"

/* What soil_sink_body needs beside law, planes and motion. */
struct soil_sink {
	const struct soil_laying *laying;
	const struct soil_laid *soils; /* SOIL_CLASSES: how each soil is laid */
	int32_t *carried;              /* a plane of its planes' posts: what those that it touches give away, and how far it is above others. Filled if laying->front. NULL: nothing will be laid */
	bool notes;                    /* `carried` is filled whatever the laying is */
	int32_t throws;                /* share of what slip digs that is thrown, 2^-16: it is not laid. 0: none */
	int32_t start;                 /* with a load: where the search begins, fixed-point units above motion->to.z */
};

/* What soil_sink_body found and did. */
struct soil_imprint {
	struct soil_forces forces;
	struct soil_measured measured; /* for soil_lay */
	struct post_rect reached;      /* around the posts that it changed, and those that it may have freed */
	int64_t compacted;             /* fixed-point units, summed over posts */
	int64_t thrown;                /* the same: what is to fly off, of what posts gave away */
	uint64_t refused;              /* posts whose change would leave the range of an offset */
	int32_t raised;                /* with a load: the equilibrium height above motion->to.z, fixed-point units */
	int tries;                     /* evaluations of the search */
};

/* Finds the height of a body if it has a load, computes the forces on it, and changes the posts that it touches. planes: of a rectangle that has all
 * posts below the body with their neighbours. Adds to planes->contact. STATUS_MEMORY: nothing was changed. Any thread; `work` belongs to one. */
enum status soil_sink_body(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, const struct soil_sink *sink,
			    struct soil_work *work, struct soil_imprint *out) FURROW_CHECKED;

/*
 * Several bodies that meet the ground together. Each has a soil_work of its own. Call soil_sink_begin for each of them, and for those that are over
 * the same ground and stay as they are. Then call soil_sink_meet and soil_sink_find for each. When all have been found, call soil_sink_claim and
 * soil_sink_commit. So each finds the ground as it was before, and their order does not show. `motion` and `planes` must live until then. Planes of different bodies may be
 * parts of one window, so with rows of equal width. Any thread, one at a time for bodies that meet.
 */
/* start: as in struct soil_sink. STATUS_MEMORY. */
enum status soil_sink_begin(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, int32_t start,
			     struct soil_work *work) FURROW_CHECKED;
/* Tells a body which others may be over the same ground, at the heights that were found last. STATUS_MEMORY. */
enum status soil_sink_meet(struct soil_work *work, const struct soil_work *const *others, size_t count) FURROW_CHECKED;
/* Finds its height and the forces on it. Changes nothing. Fills forces, raised and tries. It may be called again after another soil_sink_meet. */
void soil_sink_find(struct soil_work *work, struct soil_imprint *out);
/* Returns true if other number `index` of the last soil_sink_meet abuts it and goes where it goes, so that both are parts of one body. */
bool soil_sink_is_part(const struct soil_work *work, size_t index, const struct soil_work *other);
/* Widens how its soil is laid to that of the whole that it makes with those that abut it. */
void soil_sink_widen(const struct soil_work *work, struct soil_laying *laying);
/* Returns true if others bore part of the ground under it. */
bool soil_sink_shares(const struct soil_work *work);

/* Which body changes a post. */
struct soil_claim {
	int32_t sinkage, offset; /* what it changes it to */
	uint8_t rank;            /* 2: it holds the post; 1: it touched the post; 0: it left the post */
	uint8_t owner;           /* its number; 0: none */
};
/* Claims the posts that a body changes, if no other claimed them with more right. claims: of all posts of its planes, zeros at first. number: from 1. */
void soil_sink_claim(const struct soil_work *work, uint8_t number, struct soil_claim *claims);

struct soil_sink_shared {
	const struct soil_claim *claims; /* NULL: no other body changes posts of this one */
	uint8_t *owners;                 /* of all posts of its planes: `number` where it touched them */
	uint8_t number;
};
/* Changes the posts that a body touches. shared: NULL for one body alone. Fills all other numbers of the imprint. */
void soil_sink_commit(const struct soil_work *work, const struct soil_sink *sink, const struct soil_sink_shared *shared, struct soil_imprint *out);

#endif
