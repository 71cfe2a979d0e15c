/*
 * store: one SQLite file that holds a terrain's base and everything deformation added to it.
 *
 * Life: store_create (or store_resume) -> store_put_base... -> store_publish (written aside as
 * PATH.part, renamed when whole), then store_open for reading or writing. A store open for writing has one read-write
 * connection, used by one thread at a time (the writer); any number of struct store_reader, one a
 * thread, each with its own read-only connection. A second writer is refused with STATUS_FAILED.
 * A store is untrusted: what does not check out is STATUS_INPUT and names the tile.
 *
 * An overlay is a store without a base of its own: it names another's (store_create_overlay), which
 * is only read then. It is opened, read and written as any store.
 */
#ifndef FURROW_STORE_H
#define FURROW_STORE_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "base/plan.h"
#include "base/plane.h"

enum store_pack { STORE_PACK_FAST, STORE_PACK_SMALL };

struct store_meta {
	struct extent extent;
	double step;          /* height code step in metres, 0: lossless float32 */
	double max_error;     /* metres, as asked */
	const char *srs;      /* WKT, "" for local metres */
	double origin[2];     /* SRS coordinates of the south-west post */
	const char *vertical; /* "" if unknown */
	const char *sources;  /* one a line */
	const char *request;  /* to make one: all that decides its rows, as text; "" or NULL: cannot be resumed */
	double low, high;     /* metres over all posts; filled by store_publish */
	enum store_pack pack;
};

struct store_range {
	double low, high; /* metres over the whole subtree; NaN both: all nodata */
	double error;     /* metres, decimation error (base only) */
};

struct store;
struct store_reader;

/* --- making one ---
 *
 * Beside its name, as PATH.part, with a commit now and then: a process that is killed leaves that, and
 * store_resume goes on from its last commit. One thread at a time.
 */
enum status store_create(const char *path, const struct store_meta *meta, bool overwrite,
			 struct store **out) FURROW_CHECKED;
/* store_create, or the one that was broken off: *tiles are there already, the first ones put. STATUS_INPUT if
 * that was of another request. */
enum status store_resume(const char *path, const struct store_meta *meta, bool overwrite, struct store **out,
			 int64_t *tiles) FURROW_CHECKED;
/* Codes: (cells + 1)^2. Each tile once, in an order that is the same whenever the same store is made. */
enum status store_put_base(struct store *store, struct tile tile, const int32_t *codes,
			   const struct store_range *range) FURROW_CHECKED;
/* Codes of a tile put before; *found false: it was not. */
enum status store_get_base(struct store *store, struct tile tile, int32_t *codes, bool *found) FURROW_CHECKED;
enum status store_publish(struct store *store) FURROW_CHECKED; /* syncs and renames into place */
/* Commits and closes, and leaves PATH.part for store_resume. Frees the store, also when it fails. */
enum status store_suspend(struct store *store) FURROW_CHECKED;

/* The same in two halves, since packing is the long one: any thread packs, with a packer of its own. */
struct store_packer;
struct store_packed {
	int64_t codec;
	const void *bytes; /* the packer's, until its next use */
	size_t size;       /* at most store_packed_most() */
};
enum status store_packer_create(const struct store_meta *meta, struct store_packer **out) FURROW_CHECKED;
void store_packer_destroy(struct store_packer *packer); /* takes NULL */
size_t store_packed_most(const struct store_packer *packer);
struct store_packed store_pack(struct store_packer *packer, const int32_t *codes);
enum status store_put_packed(struct store *store, struct tile tile, const struct store_packed *packed,
			     const struct store_range *range) FURROW_CHECKED;

/* --- using one --- */
enum store_mode { STORE_READ, STORE_WRITE };
struct store_options {
	enum store_mode mode;
	bool durable_full; /* synchronous=FULL */
};
enum status store_open(const char *path, const struct store_options *options, struct store **out)
	FURROW_CHECKED;
/* Checkpoints if it was written; takes NULL. An unpublished store is removed, but for one that was resumed. */
void store_close(struct store *store);

const struct store_meta *store_meta(const struct store *store);
/* An overlay's base, where it was found; NULL for a plain store. */
const char *store_base_path(const struct store *store);
/* Which base it has: a hash of what the terrain is and of every base row. */
uint64_t store_base_hash(const struct store *store);
/* The finest level: 0 until the first deformation fixed a finer one. */
int store_finest(const struct store *store);
bool store_has_working_level(const struct store *store, int *level);
/* Fixes it at `level` in memory; written with the first epoch. STATUS_INPUT if another was fixed. */
enum status store_set_working_level(struct store *store, int level) FURROW_CHECKED;

/* --- overlays: deformation in a file of its own, over a base that is only read --- */

/* An overlay is used as a store is: its base tiles are the base's, all else is its own. STATUS_INPUT
 * if `path` exists, or the base is deformed or an overlay itself. */
enum status store_create_overlay(const char *path, const char *base_path) FURROW_CHECKED;
/* Opens the overlay at `path`, made if it is not there; STATUS_INPUT if it is no overlay of that base. */
enum status store_open_overlay(const char *path, const char *base_path, const struct store_options *options,
			       struct store **out) FURROW_CHECKED;
/* store_close() after a failure: what store_open_overlay() made is removed if it holds no epoch. */
void store_abandon(struct store *store);

/* --- reading: any thread, a reader each --- */
enum status store_reader_create(struct store *store, struct store_reader **out) FURROW_CHECKED;
void store_reader_destroy(struct store_reader *reader);

/* Base of a tile of level >= 0. STATUS_INPUT if it is missing or does not check out. */
enum status store_read_base(struct store_reader *reader, struct tile tile, int32_t *codes,
			    struct store_range *range) FURROW_CHECKED;
/* Range only, without decoding. */
enum status store_read_base_range(struct store_reader *reader, struct tile tile, struct store_range *range)
	FURROW_CHECKED;
/* Planes asked for (a mask of PLANE_BIT) that the tile has are filled, in their own types, and returned
 * in *present; the others are zeroed. planes[] of those not asked for may be NULL. Planes of the soil's
 * state are of the working level alone. STATUS_INPUT if a row does not check out. */
enum status store_read_deformed(struct store_reader *reader, struct tile tile, unsigned wanted,
				void *const planes[PLANES], unsigned *present) FURROW_CHECKED;
/* Offset's range over the subtree, in metres; *found false without a row. */
enum status store_read_offset_range(struct store_reader *reader, struct tile tile, double *low,
				    double *high, bool *found) FURROW_CHECKED;
/* Keys of the tiles with an offset row at `level`, in key order. */
typedef enum status (*store_key_fn)(void *user, uint64_t key);
enum status store_each_offset(struct store_reader *reader, int level, store_key_fn fn, void *user)
	FURROW_CHECKED;
/* The same, of another plane: where it is kept, offset or none. */
enum status store_each_plane(struct store_reader *reader, enum plane plane, int level, store_key_fn fn, void *user)
	FURROW_CHECKED;

/* Keys of the tiles of the working level of which a plane changed by an epoch or a rollback after the revision `since`,
 * in any order; *now: the last revision. Revisions are the numbers of epochs, and never come again before a reset. A tile that lost its last
 * row before this opening of the store is not among them. `fn` may not ask the store for anything. Of the writing store:
 * of others, only what there was when it was opened. */
enum status store_each_changed(struct store_reader *reader, int64_t since, store_key_fn fn, void *user, int64_t *now)
	FURROW_CHECKED;

/* --- epochs: the writer thread --- */
struct store_page {
	struct tile tile; /* of the working level */
	/* (cells + 1)^2 each, in the plane's own type, shared edges included. NULL: without that plane, which
	 * then stays as it is, but for the soil's state: that is of ground which is no more, and is dropped,
	 * in the tile and in the posts that others share with it. The offset must be there. */
	const void *planes[PLANES];
};

struct store_epoch_result {
	int64_t epoch; /* number of this commit, 1 for the first */
	int64_t tiles_written, bytes_written; /* rows of all levels and tables */
	int64_t coarser;           /* tiles above the pages, whose offsets followed */
	int64_t changed[PLANES];   /* rows of a plane that were written or removed */
	int64_t looked_up[PLANES]; /* rows of a plane of the soil's state that were looked up */
	int64_t header;            /* entries of the header that were written */
	/* Change of the sum over posts (a shared post once) of offsets below and above zero, quanta. */
	int64_t below, above;
};

struct store_run {
	const char *scene_hash; /* hex */
	int64_t step;
	double time; /* s */
	int64_t compacted; /* quanta summed over posts that were lost for good since the epoch before */
	const char *state; /* JSON: all else that it goes on from */
	/* Where that tells what this epoch changed too: called once that is known, within the transaction, and
	 * what it returns is the state. NULL: out of memory. */
	const char *(*describe)(void *user, const struct store_epoch_result *result);
	/* Asked before each tile: true gives the whole epoch up, with STATUS_INTERRUPTED. NULL: it goes on. */
	bool (*given_up)(void *user);
	void *user;
};

/* One transaction: the pages, every coarser level above them, the run's record. All or nothing. */
enum status store_epoch(struct store *store, const struct store_page *pages, size_t count,
			const struct store_run *run, struct store_epoch_result *result) FURROW_CHECKED;
/* Into the file what readers let, without waiting for any. */
enum status store_checkpoint(struct store *store) FURROW_CHECKED;
/* After an epoch: a checkpoint once the WAL has grown to some 64 MB, so that it stays about that long. Waits,
 * but briefly, only for a reader that keeps it from being used again while it grows well beyond. */
enum status store_bound_wal(struct store *store) FURROW_CHECKED;
/* Marks what is there: from now on epochs keep what they replace, and store_rollback() brings it back. Takes the place
 * of the mark before. A mark ends when the store is closed, or reset; also a kill leaves nothing of it. What is
 * kept is no part of the store: once it is a few MB it is in a temporary file of SQLite's, in the folder that SQLITE_TMPDIR or
 * TMPDIR names, else in /var/tmp. */
enum status store_mark(struct store *store) FURROW_CHECKED;
/* One transaction: every row, and the run's record, are as they were at the last mark, which stays. What it puts back
 * has a revision of its own, so it counts as changed. Nothing to do is no revision. Call store_bound_wal() after it. */
enum status store_rollback(struct store *store) FURROW_CHECKED;
/* Drops every deformation and the working level; keeps the base, and forgets the mark. */
enum status store_reset(struct store *store) FURROW_CHECKED;

/* --- what was executed --- */

/* The tables, and what is of none: transactions. */
enum store_table {
	STORE_BASE_TABLE,
	STORE_OFFSET_TABLE,
	STORE_DIRT_TABLE,
	STORE_HEAPED_TABLE,
	STORE_PRESSED_TABLE,
	STORE_SHEAR_TABLE,
	STORE_META_TABLE,
	STORE_RUN_TABLE,
	STORE_NO_TABLE,
	STORE_TABLES
};
const char *store_table_name(enum store_table table); /* "base", ..., "other" */
/* Statements executed so far through this store and its readers, also those that are gone, by table. What opening a
 * connection took is not among them. Any thread. */
struct store_statements {
	uint64_t read[STORE_TABLES], written[STORE_TABLES];
};
void store_statements(const struct store *store, struct store_statements *out);

/* What epochs execute by themselves: with pages of these planes (0: epochs have no pages), each called for by
 * effects[plane]; `was_deformed`: earlier epochs had pages, maybe of other planes. Pure. */
void store_epoch_plan(unsigned planes, bool was_deformed, const char *const effects[PLANES], struct plan *plan);
/* Adds a line for so many reads or writes of a table. */
void store_plan_reads(struct plan *plan, enum store_table table, int64_t amount, enum plan_unit unit, const char *effect);
void store_plan_writes(struct plan *plan, enum store_table table, int64_t amount, enum plan_unit unit, const char *effect);

/* --- looking at one --- */
struct store_numbers {
	int64_t base_tiles, plane_tiles[PLANES];
	int64_t file_bytes, base_bytes, plane_bytes[PLANES]; /* blobs as stored */
	int64_t epochs, compacted;
	struct store_run last_run; /* scene_hash NULL if there was none; owned by the store */
};
enum status store_count(struct store *store, struct store_numbers *numbers) FURROW_CHECKED;
/* The last run alone, as in store_numbers. */
enum status store_last_run(struct store *store, struct store_run *run) FURROW_CHECKED;

struct store_check {
	int64_t problems;   /* all of them, also those not passed to `problem` */
	int64_t tiles;      /* rows checked */
	int coarsest, finest;
	int64_t compacted;  /* quanta that were lost for good, as the store says */
	int64_t offset_sum[TILE_LEVEL_MAX - TILE_LEVEL_MIN + 1]; /* by level - TILE_LEVEL_MIN: a shared post once */
};
typedef void (*store_problem_fn)(void *user, const char *text);
typedef enum status (*store_progress_fn)(void *user, int64_t done, int64_t total);
/* Everything: SQLite's own check, every hash, edges between neighbours, the pyramid, ranges. */
enum status store_verify(struct store *store, store_problem_fn problem, store_progress_fn progress,
			 void *user, struct store_check *check) FURROW_CHECKED;
/* The hash of all rows (not of the file's bytes): "the same store". */
enum status store_content_hash(struct store *store, uint64_t *hash) FURROW_CHECKED;

/* --- posts out, at any level from the finest to the coarsest --- */
enum store_layer {
	STORE_SURFACE,
	STORE_BASE,
	STORE_OFFSET,
	STORE_QUANTA,
	STORE_SOIL, /* dirt */
	STORE_HEAPED,
	STORE_PRESSED,
	STORE_SHEAR,
	STORE_LAYERS
};
/* Posts of `rect` (row 0 south) in metres (quanta and dirt as they are); NaN where nodata or outside.
 * Below level 0 the base is interpolated; finer than the working level offsets, and what is kept beside
 * them, are too. Base heights are the stored ones at level >= 0, those of the lattice below.
 * STATUS_INPUT for the soil's state (heaped, pressed, shear) at a level coarser than the working one. */
enum status store_read_posts(struct store_reader *reader, enum store_layer layer, int level,
			     struct post_rect rect, double *values) FURROW_CHECKED;

/* Height at a point (metres from the south-west post), bilinear between the posts of the finest
 * level that is stored there. */
struct store_sample {
	double height, base, offset; /* metres; NaN where nodata */
	bool nodata, outside;
	unsigned dirt;
	unsigned planes; /* a mask: of those that the tile there has */
	double heaped, pressed, shear; /* metres, of the nearest post */
};
enum status store_sample(struct store_reader *reader, double x, double y, struct store_sample *sample)
	FURROW_CHECKED;

#endif
