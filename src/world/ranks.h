/*
 * world/ranks.h, a part of world.h: a world that several processes (ranks) step together. fleet implements struct world_ranks by the functions here.
 */
#ifndef FURROW_WORLD_RANKS_H
#define FURROW_WORLD_RANKS_H

#include "world/body.h"
#include "world/events.h"

/* What ranks did together. */
struct world_ranked {
	struct pages_sums sums; /* of the whole drive */
	int64_t tiles_moved, bodies_moved, blocks_moved, bytes_moved, exchanges;
	double waiting; /* s that ranks waited for others, all together */
	/* Processor time of all ranks in steps without waiting, s; of that, for who computes what, and for what moves. */
	double busy, planning, moving;
	double balance; /* work of the busiest rank by the mean of all, in the mean over steps */
};

/*
 * The other processes (ranks) that step this world, too: fleet. Each rank has its own ground, and computes the contacts of its own bodies.
 * All functions are called on the world's thread, on every rank in the same order. They may wait for the other ranks.
 */
struct world_ranks {
	void *user;
	int rank, ranks;         /* number of this one, from 0; how many there are */
	const char *over, *part; /* overlay of the run, and the one over it that this rank writes */
	/* Before the contacts of a step that ends at `until`. Afterwards this rank has the newest ground of all that its bodies touch in
	 * this step, and where soil slides near them. `status`: of this rank so far. A failure of any rank is returned on all. */
	enum status (*step)(void *user, double until, enum status status);
	/* Fills the contacts of bodies that are elsewhere. `status`: of this rank's own probes. */
	enum status (*probed)(void *user, size_t count, const int32_t *numbers, struct furrow_contact *contacts, enum status status);
	/* Takes a number of each tile, as this rank has the tile, and gives that of the rank with its newest planes. The tiles are the same on all ranks. `status`: of this rank's
	 * own numbers. */
	enum status (*newest)(void *user, size_t count, const uint64_t *keys, double *numbers, enum status status);
	/* This rank changes the tile in this step. */
	enum status (*changes)(void *user, uint64_t key);
	/* Returns true if this rank may read the tile in this step. */
	bool (*has)(void *user, uint64_t key);
	/* Takes rows of bodies here, after each step that has some, and before each commit. */
	enum status (*rows)(void *user, const struct world_row *rows, size_t count);
	/* Gives all ranks the soil aboard bodies of vehicles, at the end of each step where such bodies carry some: every rank moves the vehicles. */
	enum status (*loads)(void *user);
	/* Before the run's last commit. `status`: how this rank ended. */
	enum status (*end)(void *user, enum status status);
	/* When this rank has closed its ground: puts what all ranks have committed into `over`. Fills `figures`. */
	enum status (*gather)(void *user, struct world_ranked *figures);
	/* Returns the failure of any rank on all. What ranks have in common is compared at the first call. */
	enum status (*agree)(void *user, struct world *world, enum status status);
};

/*
 * --- ranks.c: for struct world_ranks ---
 */
bool world_ranked(const struct world *world, size_t number); /* false: there is no such body, or it is not placed */
/* Gives the posts that a body may touch in the step that ends at `until`, with those where soil may slide because of it. Empty: none.
 * Gives the same on every rank. */
struct post_rect world_body_area(const struct world *world, size_t number, double until);
int64_t world_intervals_due(const struct world *world, double until); /* number of relaxation intervals until then */
/* Gives the posts that so many intervals may read or change because of an active block. */
struct post_rect world_block_area(const struct world *world, struct soil_block block, int64_t intervals);
void world_body_here(struct world *world, size_t number, bool here); /* says if this rank computes its contacts */
bool world_meets(const struct world *world);                        /* contacts of bodies near each other are computed together */
bool world_unplaced(const struct world *world);                     /* a body was placed since world_ranks.step was called last */
void world_placed(struct world *world);                             /* struct world_ranks.step has seen such bodies */
enum status world_begin_commit(struct world *world) FURROW_CHECKED; /* with the record as it is */
void world_pass_elsewhere(struct world *world, double until);       /* counts the path samples of bodies elsewhere */
/* Returns the failure that collecting the events until then would have. Keeps what it placed for the steps until then. */
enum status world_check_events(struct world *world, double until) FURROW_CHECKED;
/* Undoes the collecting of this step's events. The step collects them again. */
void world_forget_events(struct world *world);

/* The state of a body that moves to another rank. Forces must be settled. It has no pointers. */
struct world_moved {
	int64_t number, next, skipped, equilibrium;
	uint64_t windows, windows_moved, regions, regions_moved;
	struct soil_pose last, shown; /* shown: the pose of its rows */
	struct soil_trend trend;      /* its recent motion, up to `last` */
	struct world_force force;
	double distance, sinkage;
	bool has_last, placed, felt;  /* placed: it has rows; felt: `force` is that of its last contact */
};
/* Returns true if bodies change the ground. */
bool world_changes_ground(const struct world *world);
/* The same as deform_active_blocks, deform_wake_block and deform_tally, whichever way the ground is changed. */
enum status world_active_blocks(const struct world *world, const struct soil_block **blocks, size_t *count) FURROW_CHECKED;
enum status world_wake_block(struct world *world, struct soil_block block) FURROW_CHECKED;
enum status world_tally(const struct world *world, struct deform_tally *tally) FURROW_CHECKED;
void world_body_pack(const struct world *world, size_t number, struct world_moved *moved);
/* `here`: this rank computes its contacts from now on. STATUS_FAILED: there is no such body. */
enum status world_body_unpack(struct world *world, const struct world_moved *moved, bool here) FURROW_CHECKED;
/* Soil aboard a body, as whole numbers: how many there are (0: the body carries none), and to and from them. places: the soil goes to its place above the body, too;
 * false: it is only kept for the record. STATUS_FAILED: the numbers contradict each other. */
size_t world_carried_moves(const struct world *world, size_t number);
void world_carried_pack(const struct world *world, size_t number, int64_t *numbers);
enum status world_carried_unpack(struct world *world, size_t number, const int64_t *numbers, bool places) FURROW_CHECKED;
/*
 * Soil in flight: each rank has grains that may come down on its ground, and its own share of what was thrown, landed and lost. Functions with a number need it
 * below world_grains_here().
 */
#define WORLD_GRAIN_NUMBERS 9
struct world_grain_moved {
	int64_t numbers[WORLD_GRAIN_NUMBERS];
};
size_t world_grains_here(const struct world *world);
/* Gives the posts that a grain may read or change until then, with those where soil may slide because of it. Empty: it is beyond the terrain. */
struct post_rect world_grain_area(const struct world *world, size_t number, double until);
void world_grain_pack(const struct world *world, size_t number, struct world_grain_moved *moved);
/* Lets a grain of another rank fly here. STATUS_FAILED: it is no grain. */
enum status world_grain_unpack(struct world *world, const struct world_grain_moved *moved) FURROW_CHECKED;
void world_grains_keep(struct world *world, const bool *stays); /* by number; the others are forgotten */
size_t world_grains_most_here(struct world *world);             /* returns how many there were at once at most since the last call */
/* Gives the share of this rank: thrown by class, landed, lost; fixed-point units. Needs grains to be thrown in this world, as all that follow. */
#define WORLD_THROWN_SUMS (SOIL_CLASSES + 2)
void world_thrown_share(const struct world *world, int64_t sums[WORLD_THROWN_SUMS]);
/* Tell what all other ranks have after this step, for the record: first begin, then the share of each, and each of their grains. */
void world_thrown_others_begin(struct world *world);
void world_thrown_others_sums(struct world *world, const int64_t sums[WORLD_THROWN_SUMS]);
enum status world_thrown_others_grain(struct world *world, const struct world_grain_moved *moved) FURROW_CHECKED;
/* Keeps only the active blocks for which `keeps` returns true. Waits for the GPU. */
typedef bool (*world_block_fn)(void *user, struct soil_block block);
enum status world_active_keep(struct world *world, world_block_fn keeps, void *user) FURROW_CHECKED;
/* Takes the planes of a tile from another rank: resident_pages_put. */
enum status world_tile_came(struct world *world, struct tile tile, unsigned planes, const void *bytes) FURROW_CHECKED;
/* Fills the record of the last whole step. `others`: blocks that are active on other ranks. */
enum status world_record_ranks(struct world *world, const struct soil_block *others, size_t count) FURROW_CHECKED;

#endif
