/*
 * store: one SQLite file that holds a terrain's base and everything that deformation added to it.
 *
 * A store is made with store_create (or store_resume), store_put_base for each tile, then store_publish. It is written as
 * PATH.part and renamed when complete. Then store_open opens it for reading or writing.
 *
 * A store open for writing has one read-write connection, used by one thread at a time (the writer). There may be any number of
 * struct store_reader, one for each thread, each with its own read-only connection. A second writer is refused with
 * STATUS_FAILED. A store is untrusted input. Wrong content is STATUS_INPUT, and the message names the tile.
 *
 * An overlay is a store without a base of its own. It names the store that has the base (store_create_overlay), which is then
 * only read. It is opened, read and written as any store.
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
	double step;          /* metres: step of height codes, 0: lossless float32 */
	double max_error;     /* metres, as the import was asked */
	const char *srs;      /* WKT, "" for local metres */
	double origin[2];     /* SRS coordinates of the south-west post */
	const char *vertical; /* "" if unknown */
	const char *sources;  /* one source a line */
	const char *request;  /* to make a store: everything that decides its rows, as text. "" or NULL: it cannot be resumed */
	double low, high;     /* metres over all posts; filled by store_publish */
	enum store_pack pack;
};

struct store_range {
	double low, high; /* metres over the whole subtree; NaN both: all nodata */
	double error;     /* metres, decimation error (base only) */
};

struct store;
struct store_reader;

/* --- making a store ---
 *
 * It is written as PATH.part, with a commit from time to time. A process that is killed leaves that file. store_resume goes on
 * from its last commit. One thread at a time. */
enum status store_create(const char *path, const struct store_meta *meta, bool overwrite,
			 struct store **out) FURROW_CHECKED;
/* As store_create, or goes on with one that was broken off. *tiles: the number of tiles that are already there, the first that
 * were put. STATUS_INPUT: it was of another request. */
enum status store_resume(const char *path, const struct store_meta *meta, bool overwrite, struct store **out,
			 int64_t *tiles) FURROW_CHECKED;
/* Puts one tile. `codes`: (cells + 1)^2. Put each tile once, and in the same order whenever the same store is made. */
enum status store_put_base(struct store *store, struct tile tile, const int32_t *codes,
			   const struct store_range *range) FURROW_CHECKED;
/* Reads the codes of a tile that was put. *found false: it was not. */
enum status store_get_base(struct store *store, struct tile tile, int32_t *codes, bool *found) FURROW_CHECKED;
enum status store_publish(struct store *store) FURROW_CHECKED; /* syncs the file and gives it its name */
/* Commits and closes, and leaves PATH.part for store_resume. Frees the store, even on failure. */
enum status store_suspend(struct store *store) FURROW_CHECKED;

/* The same in two halves, since packing takes long. Any thread packs, with a packer of its own. */
struct store_packer;
struct store_packed {
	int64_t codec;
	const void *bytes; /* owned by the packer, valid until its next use */
	size_t size;       /* at most store_packed_most() */
};
enum status store_packer_create(const struct store_meta *meta, struct store_packer **out) FURROW_CHECKED;
void store_packer_destroy(struct store_packer *packer); /* takes NULL */
size_t store_packed_most(const struct store_packer *packer);
struct store_packed store_pack(struct store_packer *packer, const int32_t *codes);
enum status store_put_packed(struct store *store, struct tile tile, const struct store_packed *packed,
			     const struct store_range *range) FURROW_CHECKED;

/* --- using a store --- */
enum store_mode { STORE_READ, STORE_WRITE };
struct store_options {
	enum store_mode mode;
	bool durable_full; /* synchronous=FULL */
};
enum status store_open(const char *path, const struct store_options *options, struct store **out)
	FURROW_CHECKED;
/* Closes a store. Takes NULL. After writing, moves the WAL into the file. An unpublished store is removed, unless it was
 * resumed. */
void store_close(struct store *store);

const struct store_meta *store_meta(const struct store *store);
/* Returns the path where an overlay's base was found; NULL for a plain store. */
const char *store_base_path(const struct store *store);
/* Returns a hash of the base: of the terrain's description and of every base row. */
uint64_t store_base_hash(const struct store *store);
/* Returns the finest level: 0 until the first deformation fixed a finer one. */
int store_finest(const struct store *store);
bool store_has_working_level(const struct store *store, int *level);
/* Fixes the working level in memory; the first commit writes it. STATUS_INPUT: another one is fixed. */
enum status store_set_working_level(struct store *store, int level) FURROW_CHECKED;

/* --- overlays: deformation in a file of its own, over a base that is only read --- */

/* Makes an overlay. It is used as a store is: base tiles come from the base, everything else is its own. STATUS_INPUT: `path`
 * exists, or the base is deformed or an overlay itself. */
enum status store_create_overlay(const char *path, const char *base_path) FURROW_CHECKED;
/* Opens the overlay at `path`, and makes it if it does not exist. STATUS_INPUT: it is no overlay of that base. */
enum status store_open_overlay(const char *path, const char *base_path, const struct store_options *options,
			       struct store **out) FURROW_CHECKED;
/* Closes as store_close, after a failure. Removes what store_open_overlay() made if it has no commit. */
void store_abandon(struct store *store);

/* --- reading: on any thread, each with its own reader --- */
enum status store_reader_create(struct store *store, struct store_reader **out) FURROW_CHECKED;
void store_reader_destroy(struct store_reader *reader);

/* Reads the base of a tile of level >= 0. STATUS_INPUT: it is missing or damaged. */
enum status store_read_base(struct store_reader *reader, struct tile tile, int32_t *codes,
			    struct store_range *range) FURROW_CHECKED;
/* Reads only the range, without decoding. */
enum status store_read_base_range(struct store_reader *reader, struct tile tile, struct store_range *range)
	FURROW_CHECKED;
/* Reads planes of a tile, in their own types. `wanted`: a mask of PLANE_BIT. Fills the planes that the tile has and sets them
 * in *present; fills the others with zeros. planes[] that are not wanted may be NULL. Planes of the soil's state exist only at
 * the working level. STATUS_INPUT: a row is damaged. */
enum status store_read_deformed(struct store_reader *reader, struct tile tile, unsigned wanted,
				void *const planes[PLANES], unsigned *present) FURROW_CHECKED;
/* Reads the offset's range over the subtree, in metres. *found false: there is no row. */
enum status store_read_offset_range(struct store_reader *reader, struct tile tile, double *low,
				    double *high, bool *found) FURROW_CHECKED;
/* Tells the keys of the tiles with an offset row at `level`, in the order of keys. */
typedef enum status (*store_key_fn)(void *user, uint64_t key);
enum status store_each_offset(struct store_reader *reader, int level, store_key_fn fn, void *user)
	FURROW_CHECKED;
/* The same for another plane, wherever it has a row, even without an offset. */
enum status store_each_plane(struct store_reader *reader, enum plane plane, int level, store_key_fn fn, void *user)
	FURROW_CHECKED;

/* Tells the keys of the tiles of the working level that changed after the revision `since`, in any order. *now: the last
 * revision. Commits and rollbacks change tiles. Revisions are numbers of commits, and none is used twice before a reset.
 *
 * A tile that lost its last row before this opening of the store is not told. `fn` must not call the store. On the writing
 * store it is up to date. On others it tells only changes before their opening. */
enum status store_each_changed(struct store_reader *reader, int64_t since, store_key_fn fn, void *user, int64_t *now)
	FURROW_CHECKED;

/* --- commits: on the writer thread --- */
struct store_page {
	struct tile tile; /* of the working level */
	/* (cells + 1)^2 each, in the plane's own type, with shared edges. The offset must be there. NULL: the page does not
	 * have this plane, and its row stays. A row of the soil's state is dropped then, since it describes the ground before
	 * the change. It is dropped in the tile, and in the posts that other tiles share with it. */
	const void *planes[PLANES];
};

struct store_commit_result {
	int64_t commit; /* number of this commit, 1 for the first */
	int64_t tiles_written, bytes_written; /* rows of all levels and tables */
	int64_t coarser;           /* coarser tiles above the pages whose offsets changed */
	int64_t changed[PLANES];   /* rows of each plane that were written or removed */
	int64_t looked_up[PLANES]; /* rows of each plane of the soil's state that were looked up */
	int64_t header;            /* entries of the header that were written */
	/* Change of the sums of offsets below and above zero, 2^-20 m, over all posts. A shared post counts once. */
	int64_t below, above;
};

struct store_run {
	const char *scene_hash; /* hex */
	int64_t step;
	double time; /* s */
	int64_t compacted; /* soil compacted since the commit before: 2^-20 m, summed over posts */
	const char *state; /* JSON: everything else that a resumed drive needs */
	/* For a state that depends on what this commit changed. Called inside the transaction, when that is known. It returns
	 * the state; NULL: out of memory. */
	const char *(*describe)(void *user, const struct store_commit_result *result);
	/* Asked before each tile: true gives the whole commit up, with STATUS_INTERRUPTED. NULL: it goes on. */
	bool (*given_up)(void *user);
	void *user;
};

/* Commits in one transaction: the pages, every coarser level above them, and the run's record. All or nothing. */
enum status store_commit(struct store *store, const struct store_page *pages, size_t count,
			const struct store_run *run, struct store_commit_result *result) FURROW_CHECKED;
/* Moves the WAL into the file, as far as readers allow. Waits for no reader. */
enum status store_checkpoint(struct store *store) FURROW_CHECKED;
/* Call after a commit. Moves the WAL into the file once it has grown to about 64 MB, so that it stays near that size. Waits
 * only for a reader that keeps a much longer WAL from being used again, and only briefly. */
enum status store_bound_wal(struct store *store) FURROW_CHECKED;
/* Marks the present content. From now on commits keep what they replace, and store_rollback() brings it back. It replaces the
 * mark before. A mark ends when the store is closed or reset; a kill leaves nothing of it.
 *
 * The kept rows are no part of the store. Above a few MB they are in a temporary file of SQLite. That file is in the folder
 * that SQLITE_TMPDIR or TMPDIR names, else in /var/tmp. */
enum status store_mark(struct store *store) FURROW_CHECKED;
/* Goes back to the last mark in one transaction: every row, and the run's record. The mark stays. Rows that it puts back count
 * as changed, with a revision of their own. If nothing has changed there is no new revision. Call store_bound_wal() after it. */
enum status store_rollback(struct store *store) FURROW_CHECKED;
/* Drops every deformation and the working level. Keeps the base, and forgets the mark. */
enum status store_reset(struct store *store) FURROW_CHECKED;

/* --- executed statements --- */

/* The tables; STORE_NO_TABLE: statements of no table, which are transactions. */
enum store_table {
	STORE_BASE_TABLE,
	STORE_OFFSET_TABLE,
	STORE_DISTURBANCE_TABLE,
	STORE_DEPOSITED_TABLE,
	STORE_PLASTIC_SINKAGE_TABLE,
	STORE_SHEAR_TABLE,
	STORE_META_TABLE,
	STORE_RUN_TABLE,
	STORE_NO_TABLE,
	STORE_TABLES
};
const char *store_table_name(enum store_table table); /* "base", ..., "other" */
/* Statements executed so far through this store and its readers, by table. Closed readers count too. Statements that open a
 * connection do not. Any thread. */
struct store_statements {
	uint64_t read[STORE_TABLES], written[STORE_TABLES];
};
void store_statements(const struct store *store, struct store_statements *out);

/* Adds the statements that commits execute with pages of these planes (0: commits have no pages). effects[plane] calls for a
 * plane. `was_deformed`: earlier commits had pages, maybe with other planes. Pure. */
void store_commit_plan(unsigned planes, bool was_deformed, const char *const effects[PLANES], struct plan *plan);
/* Adds a line for `amount` reads or writes of a table for each unit. */
void store_plan_reads(struct plan *plan, enum store_table table, int64_t amount, enum plan_unit unit, const char *effect);
void store_plan_writes(struct plan *plan, enum store_table table, int64_t amount, enum plan_unit unit, const char *effect);

/* --- looking at a store --- */
struct store_numbers {
	int64_t base_tiles, plane_tiles[PLANES];
	int64_t file_bytes, base_bytes, plane_bytes[PLANES]; /* blobs as stored */
	int64_t commits, compacted;
	struct store_run last_run; /* scene_hash NULL if there was none; owned by the store */
};
enum status store_count(struct store *store, struct store_numbers *numbers) FURROW_CHECKED;
/* The last run alone, as in store_numbers. */
enum status store_last_run(struct store *store, struct store_run *run) FURROW_CHECKED;

struct store_check {
	int64_t problems;   /* all of them, also those not passed to `problem` */
	int64_t tiles;      /* rows checked */
	int coarsest, finest;
	int64_t compacted;  /* soil that was compacted, as the store says: 2^-20 m */
	int64_t offset_sum[TILE_LEVEL_MAX - TILE_LEVEL_MIN + 1]; /* by level - TILE_LEVEL_MIN: a shared post once */
};
typedef void (*store_problem_fn)(void *user, const char *text);
typedef enum status (*store_progress_fn)(void *user, int64_t done, int64_t total);
/* Checks everything: SQLite's own check, every hash, edges between neighbours, the pyramid, ranges. */
enum status store_verify(struct store *store, store_problem_fn problem, store_progress_fn progress,
			 void *user, struct store_check *check) FURROW_CHECKED;
/* Computes the hash of all rows (not of the file's bytes). Equal hashes mean equal stores. */
enum status store_content_hash(struct store *store, uint64_t *hash) FURROW_CHECKED;

/* --- reading posts, at any level from the finest to the coarsest --- */
enum store_layer {
	STORE_SURFACE,
	STORE_BASE,
	STORE_OFFSET,
	STORE_UNITS,
	STORE_SOIL, /* disturbance */
	STORE_DEPOSITED,
	STORE_PLASTIC_SINKAGE,
	STORE_SHEAR,
	STORE_LAYERS
};
/* Reads the posts of `rect`, row 0 south, in metres. Fixed-point offsets and disturbance are as stored. NaN: nodata or outside.
 *
 * Below level 0 the base is interpolated. Below the working level, offsets and the other planes are interpolated too. Base
 * heights at level >= 0 are the stored ones; below, those of the lattice. STATUS_INPUT: the soil's state (deposited thickness,
 * plastic sinkage, shear) at a level coarser than the working one. */
enum status store_read_posts(struct store_reader *reader, enum store_layer layer, int level,
			     struct post_rect rect, double *values) FURROW_CHECKED;

/* Heights at a point, in metres from the south-west post. They are bilinear between the posts of the finest level stored there. */
struct store_sample {
	double height, base, offset; /* metres; NaN where nodata */
	bool nodata, outside;
	unsigned disturbance;
	unsigned planes; /* a mask: planes that the tile there has */
	double deposited, plastic_sinkage, shear; /* metres, at the nearest post */
};
enum status store_sample(struct store_reader *reader, double x, double y, struct store_sample *sample)
	FURROW_CHECKED;

#endif
