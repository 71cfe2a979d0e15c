/*
 * The run's record: what is committed with each epoch, so that a drive can go on from there to the same bits.
 *
 * Step, time and the scene's hash have columns of their own in the store (struct store_run); the rest is its
 * state, a JSON object whose numbers are texts, since JSON's do not hold 64 bits: whole ones in decimal, reals in
 * C's hexadecimal form, which is exact. A record that is read is a stranger's.
 */
#ifndef FURROW_RUN_RECORD_H
#define FURROW_RUN_RECORD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "deform/deform.h"
#include "scene/scene.h"
#include "store/store.h"

/* What the soil did to it, as it was last asked for; all zero: nothing. */
struct record_force {
	double force[3], moment[3]; /* N, N m */
	double sinkage, area;       /* m, m2 */
	int64_t z;                  /* 2^-20 m */
};

/* What an object carries from step to step. */
struct record_object {
	int64_t next;             /* station */
	bool in_contact;          /* at `last`, which the next station sweeps from */
	struct deform_pose last;
	double distance, sinkage; /* m */
	int64_t skipped;          /* stations without contact */
	struct record_force force;
};

/* What the drive changed the sums of offsets below and above zero by, and what it compacted: quanta. */
struct record_sums {
	int64_t below, above, compacted;
};

struct record {
	int64_t step;         /* done since the scene's start */
	double time;          /* s */
	int level;            /* the working level */
	bool ended;           /* the drive was complete with this step */
	struct record_sums sums; /* only of one that was read */
	size_t awake_count;   /* blocks where the ground may slide on */
	struct deform_block awake[DEFORM_BLOCKS_MAX];
	struct record_object objects[]; /* as many as the scene has, in its order */
};

size_t record_bytes(size_t objects);
/* The state, for mem_free; NULL: out of memory. Any thread. */
char *record_print(const struct record *record, const struct scene *scene, const struct record_sums *sums);
/* `record` has room for the scene's objects. STATUS_INPUT unless all is there and makes sense of itself; that it
 * fits the ground and the paths is the caller's to see. */
enum status record_parse(const struct store_run *run, const char *store, const struct scene *scene,
			 struct record *record) FURROW_CHECKED;
/* The record of the store at that path is not to be used: why. */
enum status record_damaged(const char *store, const char *why);

#endif
