/*
 * The run's record. Each commit has one, so that a drive can be resumed with the same bits.
 *
 * Step, time and the scene's hash have columns of their own in the store (struct store_run). The rest is the state, a JSON
 * object. Its numbers are texts, since numbers of JSON do not hold 64 bits. Whole numbers are decimal; reals are in C's
 * hexadecimal form, which is exact. A record that is read is untrusted input.
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

/* The state of an object between steps. */
struct record_object {
	int64_t next;             /* path sample */
	bool in_contact;          /* `last` was in contact: the next contact is swept from it */
	struct deform_pose last;
	double distance, sinkage; /* m */
	int64_t skipped;          /* path samples without contact */
	struct world_force force;
};

struct record {
	int64_t step;         /* steps done since the scene's start */
	double time;          /* s */
	int level;            /* the working level */
	bool ended;           /* the drive was complete with this step */
	struct pages_sums sums; /* only in a record that was read from the store */
	size_t active_count;  /* active blocks: soil may still relax there */
	struct deform_block active[DEFORM_BLOCKS_MAX];
	struct record_object objects[]; /* as many as the scene has, in its order */
};

size_t world_record_bytes(size_t objects);
/* Returns how pages commit the records of a scene. The scene must outlive it. */
struct pages_record world_record_pages(const struct scene *scene);
/* Returns the state's text, to free with mem_free; NULL: out of memory. Any thread. */
char *world_record_print(const struct record *record, const struct scene *scene, const struct pages_sums *sums);
/* Reads a record. `record` has room for the scene's objects. STATUS_INPUT: something is missing or contradicts itself. The
 * caller must check that it fits the ground and the paths. */
enum status world_record_parse(const struct store_run *run, const char *store, const struct scene *scene,
			 struct record *record) FURROW_CHECKED;
/* Fails with the reason why the record of the store at that path cannot be used. */
enum status world_record_damaged(const char *store, const char *why);

#endif
