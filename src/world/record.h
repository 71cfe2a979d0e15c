/*
 * The run's record. It is written with each commit, so that a drive can be resumed with the same bits.
 *
 * Step, time and the scene's hash have their own columns in the store (struct store_run). Everything else is the state, a JSON
 * object. Its numbers are strings, since JSON numbers cannot hold 64 bits. Whole numbers are decimal; reals are in C's
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

struct bearing_grain; /* bearing/throws.h */

/* The state of an object between steps. */
struct record_object {
	int64_t next;             /* path sample */
	bool has_last;          /* there was ground below `last`, so the next contact is swept from it. The body may be in the air there */
	struct soil_pose last;
	struct soil_trend trend;
	double distance, sinkage; /* m */
	int64_t skipped;          /* number of path samples without contact */
	struct world_force force;
	size_t carried;           /* numbers of soil aboard, in the record's last part; 0: it carries none */
};

/* Thrown soil, fixed-point units. thrown: by the class of the soil. */
struct record_thrown {
	size_t room, count;  /* grains in flight: room in the record, and how many there are. They follow the attached numbers */
	int64_t thrown[SOIL_CLASSES], landed, lost;
};

struct record {
	int64_t step;         /* steps done since the scene's start */
	double time;          /* s */
	int level;            /* the working level */
	int law;              /* by which soil bore: SOIL_LAW; 0: it did not, or a furrow before the first number made it */
	bool ended;           /* the drive ended with this step */
	struct store_marks marks; /* the store's time; its `time` is that of `time` above */
	struct pages_sums sums; /* read from the store; not used for writing */
	int64_t added;        /* soil that was brought since the world was opened, below 0: taken; 2^-20 m, summed over posts */
	int64_t carried;      /* soil aboard all bodies, also those whose soil is not in the record; the same units */
	size_t active_count;  /* active blocks, where soil may still relax */
	struct soil_block active[DEFORM_BLOCKS_MAX];
	size_t carried_count;  /* numbers of soil aboard, of all objects in turn and then of bodies of vehicles; they follow the attached ones */
	struct record_thrown thrown; /* its grains follow the numbers of soil aboard */
	size_t attached_count; /* numbers that another part of the run keeps (struct world_attached); they follow the objects */
	struct record_object objects[]; /* one for each of the scene's objects, in its order */
};

size_t world_record_bytes(size_t objects);
size_t world_record_bytes_with(size_t objects, size_t attached);
/* Returns the bytes of a record with all its parts. */
size_t world_record_bytes_of(const struct record *record, size_t objects);
/* Returns the numbers of soil aboard (struct soil_carried) of a record with so many objects. */
int64_t *world_record_carried(struct record *record, size_t objects);
/* Returns the grains in flight of a record with so many objects. */
struct bearing_grain *world_record_grains(struct record *record, size_t objects);
int64_t world_record_in_flight(const struct record *record, size_t objects); /* fixed-point units of these grains */
/* Returns the attached numbers of a record with so many objects. */
double *world_record_attached(struct record *record, size_t objects);
/* Returns the functions with which pages write the records of a scene. The scene must stay valid as long as they are used. */
struct pages_record world_record_pages(const struct scene *scene);
/* Returns the record's state as text, which the caller frees with mem_free. NULL: out of memory. Any thread. */
char *world_record_print(const struct record *record, const struct scene *scene, const struct pages_sums *sums);
/* Reads a record. `record` needs room for the scene's objects for `attached_count` numbers, and for `thrown.room` grains, which are set. STATUS_INPUT: something is missing or contradictory. The caller
 * must check that the record fits the ground and the paths. */
enum status world_record_parse(const struct store_run *run, const char *store, const struct scene *scene,
			 struct record *record) FURROW_CHECKED;
/* Returns STATUS_INPUT with a message: the record of the store at this path cannot be used, and why. */
enum status world_record_damaged(const char *store, const char *why);

#endif
