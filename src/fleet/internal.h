/* What the files of fleet share. */
#ifndef FURROW_FLEET_INTERNAL_H
#define FURROW_FLEET_INTERNAL_H

#include "base/key_map.h"
#include "base/key_set.h"
#include "fleet/comm.h"
#include "fleet/fleet.h"
#include "fleet/groups.h"

/* What an exchange is for. If ranks are in different ones, one of them has failed, and tells so. */
enum fleet_kind { FLEET_AGREE, FLEET_STEP, FLEET_COMMIT, FLEET_PROBE, FLEET_NEWEST, FLEET_LOADS, FLEET_END, FLEET_FIGURES };

/* Bytes that are put together for a message, or read from one. */
struct fleet_bytes {
	char *bytes;
	size_t size, room;
	size_t at; /* read so far */
};

struct fleet_row {
	double time, slip, position[3];
	int64_t body;
	struct world_force force;
	struct world_aboard aboard;
	int32_t soil;
};

struct fleet_row_list {
	struct fleet_row *rows;
	size_t count, room;
};

/* Areas of bodies. */
struct fleet_together {
	struct post_rect *areas; /* of the posts that each may touch */
	size_t *first;           /* those that meet the ground together: one of them */
	struct key_map blocks;   /* the first whose area has posts in a block */
	size_t room;
};

/* Tiles that go to one rank, since active blocks or grains of a rank are on them. */
struct fleet_link {
	uint32_t x0, y0, x1, y1, weight;
};

struct fleet {
	struct fleet_params params;
	int rank, ranks;
	struct world_ranks hooks;
	struct world *world;       /* after the first agree */
	struct store_staged staged; /* the base's copy; original NULL: none */
	char *over, *parts, *part; /* paths: of the run's overlay, of the folder of parts, of this rank's */
	bool made, founded;        /* rank 0: this run made the overlay, and the folder */
	int agreed;                /* how often ranks were asked whether they agree (agree.c) */
	bool ran, gathered;        /* the run began, so parts may have commits; what they have is in the overlay */
	/* step.c */
	struct fleet_groups groups;
	int32_t *owners;           /* of each body, by its index: */
	size_t owner_count;
	int32_t *next;             /* of each body: the rank that it has in this step */
	size_t next_room;
	size_t *planned_bodies;    /* of each item of a body: the body's index */
	size_t planned_count, planned_room;
	struct fleet_together together;
	int64_t intervals;         /* of relaxation in this step */
	struct key_set changed;    /* tiles that this rank has changed, or got: their numbers are indices of: */
	bool *mine;                /* false: it was sent away since */
	size_t mine_room;
	int64_t plans, steps;      /* plans made, steps begun */
	int64_t horizon, ahead;    /* steps for which plans hold, and the present one does; horizon 0: not known yet */
	int64_t planned_until;     /* step before which the next plan is due */
	bool leaves;               /* a body of this rank leaves the ground before then */
	bool failed;               /* a failure of any rank is known: there are no more steps */
	volatile sig_atomic_t stop;
	struct fleet_bytes sent;   /* of an exchange */
	double until;              /* s: up to which the areas of the present plan go */
	/* aboard.c, grains.c */
	int64_t *aboard;           /* numbers of soil aboard a body */
	size_t aboard_room;
	struct fleet_link *grain_links; /* tiles of the grains of this rank, in no order */
	size_t grain_link_room;
	uint64_t grains;           /* in flight at once at most since the last exchange, of all ranks */
	/* rows.c */
	const struct report_rows *rows; /* of rank 0; NULL: there are none */
	struct fleet_row_list given, waiting; /* given: by this rank since the last exchange; waiting: on rank 0, of all */
	/* figures */
	int64_t tiles_moved, bodies_moved, blocks_moved, bytes_moved, exchanges;
	double waited, balance;
	double spun;              /* processor time of waiting: MPI asks again and again if a message has come, s */
	double planning, moving;  /* processor time, s */
	double began, busy;       /* process time at the first step; processor time of all steps without waiting, s */
};

/* --- fleet.c --- */

int fleet_joined(int *rank); /* returns how many ranks there are; 0: they were not joined */

/* Count the time between them as waiting. */
struct fleet_wait {
	double clock, processor;
};
struct fleet_wait fleet_wait_begin(void);
void fleet_wait_end(struct fleet *fleet, struct fleet_wait wait);
void fleet_meet(void);           /* waits until all ranks are here */
/* Empties fleet->sent and puts the head of an exchange into it. */
enum status fleet_begin(struct fleet *fleet, enum fleet_kind kind, enum status status) FURROW_CHECKED;
struct fleet_told {
	bool stop, due, leaves; /* a rank is to stop; wants a commit; has a body that leaves the ground soon */
};
/*
 * Gives fleet->sent to all ranks, and takes theirs: each(user, rank, bytes) for every rank in turn. `status`: of putting it together. Returns
 * the failure of any rank on all. Then `each` was not called. each NULL: nothing follows the head.
 */
typedef enum status (*fleet_each_fn)(void *user, int rank, struct fleet_bytes *bytes);
enum status fleet_tell(struct fleet *fleet, enum fleet_kind kind, enum status status, struct fleet_told *told, fleet_each_fn each, void *user)
	FURROW_CHECKED;

enum status fleet_put(struct fleet_bytes *bytes, const void *from, size_t size) FURROW_CHECKED;
/* STATUS_FAILED: there are not so many bytes. */
enum status fleet_get(struct fleet_bytes *bytes, void *to, size_t size) FURROW_CHECKED;

/* --- agree.c, step.c, move.c, commit.c, newest.c: struct world_ranks --- */
/* Returns the failure of any rank on all ranks. The first two calls also compare what ranks must have in common. */
enum status fleet_agree_on(void *user, struct world *world, enum status status) FURROW_CHECKED;
enum status fleet_step(void *user, double until, enum status status) FURROW_CHECKED;
enum status fleet_changes(void *user, uint64_t key) FURROW_CHECKED;
bool fleet_has(void *user, uint64_t key);
/* Sends and takes what changes its rank, then settles the groups. `status`: of this rank. After a failure it sends nothing but that. */
enum status fleet_move(struct fleet *fleet, enum status status) FURROW_CHECKED;
enum status fleet_note_changed(struct fleet *fleet, uint64_t key, bool mine) FURROW_CHECKED;
bool fleet_is_changed(const struct fleet *fleet, uint64_t key);
/* Finds the tiles of these posts. Returns false if they have none. */
bool fleet_tiles_of(const struct fleet *fleet, struct post_rect posts, struct fleet_item *item);
struct fleet_item fleet_block_item(const struct fleet *fleet, struct soil_block block, int64_t intervals);
/* Both are called on all ranks together; `status` is that of this rank so far. A failure of any rank before the exchange is returned on all,
 * and sets fleet->failed. A later one is this rank's alone. */
enum status fleet_commit(struct fleet *fleet, enum status status) FURROW_CHECKED; /* begins a commit */
/* Afterwards no commit is in flight, and the world's record is the same on all ranks. */
enum status fleet_share_record(struct fleet *fleet, enum status status) FURROW_CHECKED;
enum status fleet_end(void *user, enum status status) FURROW_CHECKED;
enum status fleet_newest(void *user, size_t count, const uint64_t *keys, double *numbers, enum status status) FURROW_CHECKED;
enum status fleet_probed(void *user, size_t count, const int32_t *numbers, struct furrow_contact *contacts, enum status status) FURROW_CHECKED;

/* --- aboard.c --- */
/* Appends the soil aboard a body that carries some, with its number. */
enum status fleet_aboard_put(struct fleet *fleet, struct fleet_bytes *bytes, size_t body) FURROW_CHECKED;
/* Reads it. takes: this world's body gets it. places: as world_carried_unpack. */
enum status fleet_aboard_get(struct fleet *fleet, struct fleet_bytes *bytes, bool takes, bool places) FURROW_CHECKED;
/* Append the soil aboard all bodies of this rank, or all bodies of vehicles; and read those of a rank. */
enum status fleet_aboard_put_all(struct fleet *fleet, bool vehicles) FURROW_CHECKED;
enum status fleet_aboard_get_all(struct fleet *fleet, int rank, struct fleet_bytes *bytes, bool places) FURROW_CHECKED;
enum status fleet_loads(void *user) FURROW_CHECKED; /* of struct world_ranks */

/* --- grains.c: soil in flight --- */
/* Append the tiles of this rank's grains to fleet->sent, and how many there were; and read those of a rank. */
enum status fleet_grains_put_links(struct fleet *fleet) FURROW_CHECKED;
enum status fleet_grains_get_links(struct fleet *fleet, int rank, struct fleet_bytes *bytes) FURROW_CHECKED;
/* STATUS_FAILED on all ranks: more grains fly than one process has room for. Then the world is torn. */
enum status fleet_grains_check(struct fleet *fleet) FURROW_CHECKED;
enum status fleet_grains_allowed(const struct fleet *fleet) FURROW_CHECKED; /* STATUS_INPUT: ranks cannot drive this scene. The same on all ranks */
/* Append the grains that leave this rank to the messages that are not empty, out[rank], and forget them here. */
enum status fleet_grains_move(struct fleet *fleet, struct fleet_bytes *out) FURROW_CHECKED;
enum status fleet_grains_take(struct fleet *fleet, struct fleet_bytes *in) FURROW_CHECKED;
/* The whole share of a rank, for the record. */
enum status fleet_grains_put_share(struct fleet *fleet) FURROW_CHECKED;
enum status fleet_grains_get_share(struct fleet *fleet, int rank, struct fleet_bytes *bytes) FURROW_CHECKED;

/* --- together.c --- */
void fleet_together_finish(struct fleet_together *together);
enum status fleet_together_need(struct fleet_together *together, size_t count) FURROW_CHECKED; /* makes room for so many bodies */
/* Makes the areas of bodies that may meet the ground together the rectangle around all of them. */
enum status fleet_together_join(struct fleet_together *together, size_t count) FURROW_CHECKED;

/* --- rows.c --- */
enum status fleet_rows_take(void *user, const struct world_row *rows, size_t count) FURROW_CHECKED;
enum status fleet_rows_put(struct fleet *fleet) FURROW_CHECKED; /* appends the given rows to fleet->sent */
enum status fleet_rows_get(struct fleet *fleet, struct fleet_bytes *bytes) FURROW_CHECKED;
/* On rank 0: writes the rows until `until`, in order. */
enum status fleet_rows_write(struct fleet *fleet, double until) FURROW_CHECKED;
void fleet_rows_finish(struct fleet *fleet);

/* --- parts.c --- */
enum status fleet_note_resumed(struct fleet *fleet) FURROW_CHECKED; /* on rank 0: the run goes on from the overlay's record */
enum status fleet_gather(void *user, struct world_ranked *figures) FURROW_CHECKED;

#endif
