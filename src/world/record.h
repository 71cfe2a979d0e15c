/*
 * The run's record: what is committed with each epoch, so that a drive can go on from there to the same bits.
 *
 * Step, time and the scene's hash have columns of their own in the store (struct store_run); the rest is its
 * state, a JSON object whose numbers are texts, since JSON's do not hold 64 bits: whole ones in decimal, reals in
 * C's hexadecimal form, which is exact. A record that is read is a stranger's.
 */
#ifndef FURROW_WORLD_RECORD_H
#define FURROW_WORLD_RECORD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "deform/deform.h"
#include "scene/scene.h"
#include "store/store.h"
#include "world/world.h"

/* What an object carries from step to step. */
struct record_object {
	int64_t next;             /* station */
	bool in_contact;          /* at `last`, which the next station sweeps from */
	struct deform_pose last;
	double distance, sinkage; /* m */
	int64_t skipped;          /* stations without contact */
	struct world_force force;
};

struct record {
	int64_t step;         /* done since the scene's start */
	double time;          /* s */
	int level;            /* the working level */
	bool ended;           /* the drive was complete with this step */
	struct pages_sums sums; /* only of one that was read */
	size_t awake_count;   /* blocks where the ground may slide on */
	struct deform_block awake[DEFORM_BLOCKS_MAX];
	struct record_object objects[]; /* as many as the scene has, in its order */
};

size_t world_record_bytes(size_t objects);
/* How pages commit the records of a scene, which must outlive it. */
struct pages_record world_record_pages(const struct scene *scene);
/* The state, for mem_free; NULL: out of memory. Any thread. */
char *world_record_print(const struct record *record, const struct scene *scene, const struct pages_sums *sums);
/* `record` has room for the scene's objects. STATUS_INPUT unless all is there and makes sense of itself; that it
 * fits the ground and the paths is the caller's to see. */
enum status world_record_parse(const struct store_run *run, const char *store, const struct scene *scene,
			 struct record *record) FURROW_CHECKED;
/* The record of the store at that path is not to be used: why. */
enum status world_record_damaged(const char *store, const char *why);

#endif
