/*
 * store: one SQLite file that holds a terrain's base and everything that deformation added to it.
 *
 * To make a store, call store_create (or store_resume), store_put_base for each tile, then store_publish. The store is written
 * as PATH.part and renamed when complete. Then store_open opens it for reading or writing.
 *
 * A store that is open for writing has one read-write connection. One thread at a time uses it (the writer). There may be any
 * number of struct store_reader, one for each thread, each with its own read-only connection. A second writer is refused with
 * STATUS_FAILED. A store is untrusted input. Wrong content is STATUS_INPUT, and the message names the tile.
 *
 * An overlay is a store without a base of its own. It names another store, which has the base and is only read
 * (store_create_overlay), or another overlay. An overlay is opened, read and written like any store.
 */
#ifndef FURROW_STORE_H
#define FURROW_STORE_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "base/plan.h"
#include "base/plane.h"
#include "base/rocks.h"

enum store_pack { STORE_PACK_FAST, STORE_PACK_SMALL };

struct store_meta {
	struct extent extent;
	double step;          /* metres: unit of height codes; 0: heights are lossless float32 */
	double max_error;     /* metres: largest error that the import allowed */
	const char *srs;      /* WKT, "" for local metres */
	double origin[2];     /* SRS coordinates of the south-west post */
	/* By what share distances on the ground differ most from those of the SRS; -0.18: they are up to 18 % shorter. 0: by less than 0.5 %. NaN: not
	 * known, as in stores that an older Furrow made */
	double ground_off;
	double holes; /* share of the posts of level 0 that have no height; NaN: not known, as in stores that an older Furrow made */
	const char *vertical; /* "" if unknown */
	const char *sources;  /* the sources of the base, one on each line */
	const char *insets;   /* the insets, one on each line, which store_inset_next() reads; "" or NULL: none */
	/* for making a store: a text with all settings that decide its rows. "" or NULL: making it cannot be resumed */
	const char *request;
	double low, high;     /* metres: range over all posts; store_publish fills them */
	enum store_pack pack;
	/* Errors that the import measured. Off the resampled sources at each post of level 0; off the sources at their own posts. No
	 * posts: not measured. */
	struct misfit off_resampled, off_source;
};

struct store_range {
	double low, high; /* metres: range over the tile and all finer tiles below it; both NaN: all nodata */
	double error;     /* metres: error by leaving out posts of finer levels; base only */
};

struct store;
struct store_reader;
struct store_staged;

/* --- making a store ---
 *
 * A new store is written as PATH.part, with a commit from time to time. If the process is killed, that file remains, and
 * store_resume continues from its last commit. One thread at a time. */
enum store_overwrite {
	STORE_OVERWRITE_NOT,
	STORE_OVERWRITE,       /* a store that overlays depend on, or with snapshots, is not replaced: STATUS_INPUT */
	STORE_OVERWRITE_FORCE, /* it is, too */
};
enum status store_create(const char *path, const struct store_meta *meta, enum store_overwrite overwrite,
			 struct store **out) FURROW_CHECKED;
/* As store_create, but continues an unfinished PATH.part if there is one. *tiles: how many tiles it already has; these are the
 * first that were put. STATUS_INPUT: the unfinished store has another request. */
enum status store_resume(const char *path, const struct store_meta *meta, enum store_overwrite overwrite, struct store **out,
			 int64_t *tiles) FURROW_CHECKED;
/* Puts one tile. `codes`: (cells + 1)^2. Put each tile once. To resume a store, put the tiles in the same order as before. */
enum status store_put_base(struct store *store, struct tile tile, const int32_t *codes,
			   const struct store_range *range) FURROW_CHECKED;
/* Reads the codes and the range of a tile that was put before; range may be NULL. Sets *found to false if it was not put. */
enum status store_get_base(struct store *store, struct tile tile, int32_t *codes, struct store_range *range, bool *found) FURROW_CHECKED;
enum status store_publish(struct store *store) FURROW_CHECKED; /* syncs PATH.part and renames it to PATH */
/* Commits and closes. PATH.part remains for store_resume. Frees the store, even on failure. */
enum status store_suspend(struct store *store) FURROW_CHECKED;

/* store_put_base in two parts, since packing takes long. Any thread may pack; each thread needs its own packer. */
struct store_packer;
struct store_packed {
	int64_t codec;
	const void *bytes; /* owned by the packer, valid until its next use */
	size_t size;       /* at most store_packed_most() */
};
enum status store_packer_create(const struct store_meta *meta, struct store_packer **out) FURROW_CHECKED;
void store_packer_destroy(struct store_packer *packer); /* packer may be NULL */
size_t store_packed_most(const struct store_packer *packer);
/* A tile of an odd level above 0 takes no bytes: the tiles below it have its posts, and must be put before it. */
struct store_packed store_pack(struct store_packer *packer, struct tile tile, const int32_t *codes);
/* Adds to what the store says about errors; written with the tiles put before. */
void store_put_holes(struct store *store, double share); /* before store_publish; sets meta.holes */
void store_put_misfit(struct store *store, const struct misfit *resampled, const struct misfit *source);
enum status store_put_packed(struct store *store, struct tile tile, const struct store_packed *packed,
			     const struct store_range *range) FURROW_CHECKED;

/* --- using a store --- */
enum store_mode { STORE_READ, STORE_WRITE };
struct store_options {
	enum store_mode mode;
	bool late;         /* for writing: nobody else can write from now on, but no byte of the file changes before store_begin() */
	bool durable_full; /* synchronous=FULL */
	bool keep_history; /* each commit keeps what it replaces, so that store_restore() can return to every revision */
	bool keep_last;    /* the same for the last revision only: each commit drops older ones. STATUS_INPUT: one of them has a name */
	const char *scene; /* what commits are made for, as store_log() tells it; NULL: "" */
	/* Reads the base of an overlay from its copy (store_stage). Valid during the call. NULL: from where it is. */
	const struct store_staged *staged;
};
enum status store_open(const char *path, const struct store_options *options, struct store **out)
	FURROW_CHECKED;
/* Makes a store ready for its first commit, if it was opened late; otherwise does nothing. A commit does so, too. On the thread that commits,
 * or while none does. After a failure it is as before: call it again, or close the store. */
enum status store_begin(struct store *store) FURROW_CHECKED;
/* Closes a store; it may be NULL. After writing, moves the WAL into the file. Removes a store that was being made and is not
 * published, unless it was resumed. Removes an overlay that store_open_overlay() made, if it was opened late and not begun. */
void store_close(struct store *store);

/* In a child of the process that opened the store: closes the lock that the child has inherited. Otherwise the store stays locked as long as the
 * child lives, if its process is killed. The store must not be used in the child. */
void store_forked(const struct store *store);

const struct store_meta *store_meta(const struct store *store);

/* One inset: its rectangle in posts of its level, counted from the terrain's south-west post, and its first source. */
struct store_inset {
	int level;
	int64_t x, y, width, height;
	const char *source; /* not ended by 0 */
	size_t source_length;
};
/* Writes a line of store_meta.insets. Returns its length, as snprintf does. */
int store_inset_line(const struct store_inset *inset, char *text, size_t room);
/* Reads the next line at *text, and moves *text behind it. Returns false at the end, or if it is no such line. */
bool store_inset_next(const char **text, const struct extent *extent, struct store_inset *inset);
/* Returns the path with which the store was opened. It stays valid until the store is closed. */
const char *store_file_path(const struct store *store);
/* Returns the path of the plain store at the end of a chain of overlays, as it was found. Returns NULL for a plain store. */
const char *store_base_path(const struct store *store);
/* Returns the path of the copy that is read in place of that store; NULL: none. */
const char *store_copy_path(const struct store *store);
/* Returns the path of an overlay's parent, and *revision, the revision of the parent that the overlay shows (0: only its base). Returns
 * NULL for a plain store. */
const char *store_parent(const struct store *store, int64_t *revision);
int store_depth(const struct store *store); /* how many files are under an overlay; 0: a plain store */
/* Returns a hash of the base, that is, of the terrain's description and all base rows. */
uint64_t store_base_hash(const struct store *store);
/* Returns the finest level: that of the finest inset, or the working level if it is finer; 0 if there is neither. */
int store_finest(const struct store *store);
/* Returns the finest level with base tiles, at most 0. Below 0 the store has insets (FORMAT.md). */
int store_finest_base(const struct store *store);
bool store_has_working_level(const struct store *store, int *level);
/* Sets the working level in memory. The first commit writes it to the file. STATUS_INPUT: the store has another working level. */
enum status store_set_working_level(struct store *store, int level) FURROW_CHECKED;

/* Returns the relief that raises the ground below level 0; NULL: none. It is that over which the
 * store was deformed, unless it depends on classes: then there is none before store_set_relief().
 * Valid while the store is open and store_set_relief() is not called. */
const struct relief *store_relief(const struct store *store);
/* Returns the rocks that raise the ground at every level; NULL: none. They are with the relief: of what store_set_ground() gave, or of what the store was deformed over.
 * Valid as long as store_relief() is. */
const struct rocks *store_rocks(const struct store *store);
/* Returns the relief and rocks over which the store was deformed, as rocks_print() gives it; NULL: none. It
 * may depend on classes. */
const char *store_relief_text(const struct store *store);
/* Sets the relief (NULL: none), after the working level. The first commit writes what it is to the
 * file; heights are never written. `map` is used if it depends on classes, on any thread.
 * STATUS_INPUT: the store was deformed over another relief. */
enum status store_set_relief(struct store *store, const struct relief_spec *spec,
			     const struct relief_map *map) FURROW_CHECKED;
/* The same with rocks (NULL: none). */
enum status store_set_ground(struct store *store, const struct relief_spec *spec, const struct rocks_spec *rocks, const struct relief_map *map) FURROW_CHECKED;

/* --- overlays: deformation in a separate file, over a store that is only read --- */

/* Makes an overlay of a store, or of another overlay. It is used like a store. Base tiles are read from the plain store at the end
 * of the chain. If the parent is deformed or an overlay, the new one shows its deformation as it is now, and its record of a run.
 * Changes go to the overlay's file alone. The parent stays as it is. It may be driven on: it keeps what the overlay depends on (see pins).
 * STATUS_INPUT: `path` exists, or 16 overlays lie one over another already. */
enum status store_create_overlay(const char *path, const char *parent_path) FURROW_CHECKED;
/* Opens the overlay at `path`. Makes it if it does not exist. STATUS_INPUT: the file is not an overlay of that store, nor of an
 * overlay that is over it. */
enum status store_open_overlay(const char *path, const char *base_path, const struct store_options *options,
			       struct store **out) FURROW_CHECKED;
/* Tells an overlay where its parent is now. Opens the overlay with `parent_path` in place of the file that it names, which need not
 * exist. Proves by hashes that it is the same: of the base and, if the overlay shows its parent's deformation, of that. Then writes
 * the new path in one transaction. STATUS_INPUT: it is another file, or `path` is not an overlay; nothing is written. */
enum status store_relink(const char *path, const char *parent_path) FURROW_CHECKED;
/* Makes one plain store of an overlay and all files under it. It shows the same terrain, ruts and record of a run, so that
 * store_content_hash() gives the same and a drive can go on. Rows are copied as they are. Kept revisions and their names are not copied.
 * `progress` is called with rows; NULL: none; what it returns ends the work. On failure the file at `out` stays as it was.
 * STATUS_INPUT: `path` is no overlay; a row is damaged; `out` exists and `overwrite` is false, or is a file of the chain. */
typedef enum status (*store_progress_fn)(void *user, int64_t done, int64_t total);
enum status store_flatten(const char *path, const char *out, enum store_overwrite overwrite, store_progress_fn progress, void *user) FURROW_CHECKED;
#define STORE_CONFLICTS_MOST 20
struct store_conflicts {
	int64_t posts, places; /* places: all, also those that are not in `rects` */
	int level;             /* of the posts */
	struct post_rect rects[STORE_CONFLICTS_MOST]; /* in posts of the working level */
};
/* A base, and its copy on another disk, from which overlays can be read (store_options.staged). Overlays go on naming the original. */
struct store_staged {
	char *original; /* path of the plain store at the end of a chain, links resolved */
	char *copy;     /* path of its copy: NAME-HASH.furrow in the folder. The hash is that of base and ruts */
	uint64_t state; /* that hash */
};
/* Finds the base of the store or overlay at `path`, and how its copy in `folder` is called. Reads headers, and the hashes of ruts. Makes
 * nothing. Free *out with store_staged_finish(). */
enum status store_stage_name(const char *path, const char *folder, struct store_staged *out) FURROW_CHECKED;
/* Makes the copy, and the folder; or checks all hashes of the copy that is there. While another process makes it, waits, and calls `progress`
 * with 0 of 0. *made is false if it was there. `progress` is called with rows; NULL: none; what it returns ends the work. A copy is whole or
 * absent. STATUS_INPUT: the file that is there is not this copy, or is damaged. It stays. */
enum status store_stage(const struct store_staged *staged, store_progress_fn progress, void *user, bool *made) FURROW_CHECKED;
void store_staged_finish(struct store_staged *staged); /* all zero is allowed */
/* Merges two overlays into a new overlay of the nearest file that both are over, or of their plain store. Each post is as the one has
 * it that changed it. STATUS_INPUT: both changed posts, and not to the same values; *conflicts tells where. Or they are not of one base or
 * one working level, or `path` exists. Then nothing is made. */
enum status store_merge(const char *ours, const char *theirs, const char *path, struct store_conflicts *conflicts) FURROW_CHECKED;
/* Closes as store_close, after a failure. If store_open_overlay() made the overlay and it has no commit, removes the file. */
void store_abandon(struct store *store);

/* --- reading: on any thread, each thread with its own reader --- */
enum status store_reader_create(struct store *store, struct store_reader **out) FURROW_CHECKED;
void store_reader_destroy(struct store_reader *reader);

/* Reads the base of a tile of level >= 0. STATUS_INPUT: it is missing or damaged. */
enum status store_read_base(struct store_reader *reader, struct tile tile, int32_t *codes,
			    struct store_range *range) FURROW_CHECKED;
/* The same for a tile of any level. *found is false, and nothing is read, if an inset may have this tile and has not. Below level
 * 0, HEIGHT_CODE_NODATA in codes means: this post is not stored, and is interpolated from a coarser level. */
enum status store_find_base(struct store_reader *reader, struct tile tile, int32_t *codes, struct store_range *range,
			    bool *found) FURROW_CHECKED;
/* Reads only the range of a tile of any level; *found as above. Below level 0 it is that of the stored posts. */
enum status store_find_base_range(struct store_reader *reader, struct tile tile, struct store_range *range, bool *found)
	FURROW_CHECKED;
/* Reads only the range of a base tile, without decoding its heights. */
enum status store_read_base_range(struct store_reader *reader, struct tile tile, struct store_range *range)
	FURROW_CHECKED;
/* Reads planes of a tile, each in its own type. `wanted`: the planes to read, a mask of PLANE_BIT. *present: the planes that
 * the tile has. Wanted planes that the tile lacks are filled with zeros. planes[] of others may be NULL. The soil's state
 * exists at the working level only. STATUS_INPUT: a row is damaged. */
enum status store_read_deformed(struct store_reader *reader, struct tile tile, unsigned wanted,
				void *const planes[PLANES], unsigned *present) FURROW_CHECKED;
/* Reads the range of offsets over the tile and all finer tiles below it, in metres. *found is false if there is no row. */
enum status store_read_offset_range(struct store_reader *reader, struct tile tile, double *low,
				    double *high, bool *found) FURROW_CHECKED;
/* Calls `fn` with the key of each base tile of a level, in the order of keys. Below level 0 these are the tiles where insets lie that
 * are at least as fine. STATUS_INPUT: a tile is outside the terrain. */
typedef enum status (*store_key_fn)(void *user, uint64_t key);
enum status store_each_base(struct store_reader *reader, int level, store_key_fn fn, void *user) FURROW_CHECKED;
/* The same for each tile that has an offset row at `level`. */
enum status store_each_offset(struct store_reader *reader, int level, store_key_fn fn, void *user)
	FURROW_CHECKED;
/* The same for any plane: each tile that has a row of it, even if it has no offset. */
enum status store_each_plane(struct store_reader *reader, enum plane plane, int level, store_key_fn fn, void *user)
	FURROW_CHECKED;

/* Calls `fn` with the key of each tile of the working level that changed after the revision `since`, in any order. *now: the
 * last revision. Commits and rollbacks change tiles. Revisions are numbers of commits. No number is used twice, until a reset.
 *
 * Tiles that lost their last row before the store was opened are not told. `fn` must not call the store. On the store that is
 * writing, the result is up to date. On another, it has only the changes made before it was opened. */
enum status store_each_changed(struct store_reader *reader, int64_t since, store_key_fn fn, void *user, int64_t *now)
	FURROW_CHECKED;

/* For a store that is open for reading, while another process may write it. *moved: there are commits that the last call did not know, or the
 * opening. Then calls `fn` with the key of each tile of the working level that they changed; fn may be NULL. STATUS_INPUT: it was reset, or
 * deformed for the first time at another level than that set here; open it again. */
enum status store_follow(struct store_reader *reader, store_key_fn fn, void *user, bool *moved) FURROW_CHECKED;
/* Tells only whether there are such commits. */
enum status store_has_moved(struct store_reader *reader, bool *moved) FURROW_CHECKED;

/* --- commits: on the writer thread --- */
struct store_page {
	struct tile tile; /* of the working level */
	/* (cells + 1)^2 posts each, in the plane's own type, with shared edges. The offset must be given. NULL: the page does
	 * not have this plane. Then the row in the store stays, but a row of the soil's state is dropped, since it describes
	 * the ground before the change. It is dropped for the tile, and set to zero in the posts that other tiles share with
	 * it. */
	const void *planes[PLANES];
};

struct store_commit_result {
	int64_t commit; /* number of this commit, 1 for the first */
	int64_t tiles_written, bytes_written; /* rows of all levels and tables */
	int64_t coarser;           /* coarser tiles that lie above pages with a changed offset */
	int64_t changed[PLANES];   /* rows of each plane that were written or removed */
	int64_t looked_up[PLANES]; /* rows of each plane of the soil's state that were looked up */
	int64_t header;            /* entries of the header (table meta) that were written */
	/* How much this commit changed two sums over all posts of the working level, in 2^-20 m. below: of the negative
	 * offsets. above: of the positive ones. A post that several tiles share counts once. */
	int64_t below, above;
};

struct store_run {
	const char *scene_hash; /* hex */
	int64_t step;
	double time; /* s */
	int64_t compacted; /* soil compacted since the last commit: 2^-20 m, summed over posts */
	int64_t added;     /* soil brought from outside since then, below 0: taken; in the same unit */
	const char *what;  /* what made the commit, for a person; NULL: the scene of store_options */
	const char *state; /* JSON: everything else that is needed to resume a drive */
	/* Used instead of `state` if the state depends on what this commit changed. Called inside the transaction, after the
	 * rows are written. Returns the state; NULL: out of memory. */
	const char *(*describe)(void *user, const struct store_commit_result *result);
	/* Asked before each tile. If it returns true, the whole commit is undone and returns STATUS_INTERRUPTED. May be NULL. */
	bool (*given_up)(void *user);
	void *user;
};

/* Commits the pages, all coarser tiles above them, and the run's record in one transaction. On failure nothing is changed. */
enum status store_commit(struct store *store, const struct store_page *pages, size_t count,
			const struct store_run *run, struct store_commit_result *result) FURROW_CHECKED;
/* Moves the WAL into the file, as far as readers allow. Does not wait for readers. */
enum status store_checkpoint(struct store *store) FURROW_CHECKED;
/* Call this after a commit. If the WAL has grown to about 64 MB, moves it into the file, so that it stays near that size. Waits
 * for readers only if the WAL is much longer than that, and only briefly. */
enum status store_bound_wal(struct store *store) FURROW_CHECKED;
/* Marks the present content and replaces the earlier mark. From now on commits keep the rows that they replace, and
 * store_rollback() can restore them. The mark ends when the store is closed or reset. If the process is killed, nothing of the
 * mark remains.
 *
 * The kept rows are not part of the store. Above a few MB they are in a temporary file of SQLite. Its folder is the one named
 * by SQLITE_TMPDIR or TMPDIR, otherwise /var/tmp. */
enum status store_mark(struct store *store) FURROW_CHECKED;
/* Restores the content at the last mark in one transaction: every row, and the run's record. The mark stays. Restored rows
 * count as changed and get a new revision. If nothing has changed since the mark, there is no new revision. Call
 * store_bound_wal() afterwards. */
enum status store_rollback(struct store *store) FURROW_CHECKED;

/* --- history: revisions that are kept ---
 *
 * A revision is the content after a commit; its number is the commit's. Revision 0 is a store as imported. A revision is kept if the
 * commit after it was made with keep_history, if it has a snapshot, or if a restore replaced it. */

/* Names the present revision, which is kept from now on. Later commits keep what they replace of it. `name`: 1 to 64 characters,
 * not all digits, without blanks and commas. STATUS_INPUT: another name is needed. */
enum status store_snapshot(struct store *store, const char *name) FURROW_CHECKED;
/* Returns to a kept revision: every row, the working level, compacted soil, and the run's record. `text`: its number, or a snapshot's
 * name. *revision: its number. One transaction; it is a revision itself, and keeps the one that it replaces. If it is the present one,
 * nothing changes. The mark is lost. STATUS_INPUT: it is not kept. */
enum status store_restore(struct store *store, const char *text, int64_t *revision) FURROW_CHECKED;

struct store_revision {
	const char *file;  /* path of the store or overlay that has it */
	int64_t revision;
	int64_t made;      /* seconds since 1970; 0: not known */
	const char *who;   /* the user whose process made it */
	const char *what;  /* the scene's file, "restore 7", "rollback", ... */
	const char *scene_hash; /* "": no run */
	int64_t step;
	double time;       /* s */
	const char *names; /* of snapshots, parted by commas */
	bool present;      /* what the store holds now */
};
typedef enum status (*store_log_fn)(void *user, const struct store_revision *revision);
/* Calls `fn` for each revision that is kept, and for the present one, the newest first. Then for those that the files under an overlay
 * have, up to the revision that the overlay shows. Texts are valid during the call. */
enum status store_log(const struct store *store, store_log_fn fn, void *user) FURROW_CHECKED;

/* --- parts: one run by several processes ---
 *
 * Each process commits into a part, an overlay of its own over one store. That store stays as it is meanwhile. All parts commit in
 * lockstep: the n-th commit of each is of the same step, even if it has no pages. No part begins a commit before all have finished the
 * one before it. A tile belongs to one part at a time. When it goes to another part, the next commit of that part has its page, changed
 * or not. All pages of a run have the same planes. The content of the run is that of the last commit that all parts have. Each tile is
 * as it was committed last until then, by whichever part.
 *
 * A part keeps the revision before the present one (keep_last), and each commit of it is synced (durable_full), whatever the options say.
 * So after a kill or a power cut every part has the last commit that all have. A part cannot be rolled back or restored alone. */
#define STORE_PARTS_MOST (1 << 20)
struct store_part {
	uint64_t run; /* all parts of a run have this number, and no other run has it: store_part_run() */
	uint32_t index, count; /* 0 to count - 1; how many parts the run has, at most STORE_PARTS_MOST */
};
/* Gives a number for a new run, at random. */
enum status store_part_run(uint64_t *run) FURROW_CHECKED;
/* Makes a part over the store or overlay at `over`. Several processes may do so at a time. The file is whole or absent, also after a
 * power cut. STATUS_INPUT: as store_create_overlay(). */
enum status store_create_part(const char *path, const char *over, const struct store_part *part) FURROW_CHECKED;

struct store_gathering {
	void *user;
	/* Returns the state of the gathered record. `runs` has the records of the parts at the commit that is gathered, by store_part.index.
	 * Their `compacted` and `added` are what each part compacted and added in the run. Called inside the transaction, after the rows are written. NULL: out of
	 * memory. */
	const char *(*describe)(void *user, const struct store_run *runs, size_t count, const struct store_commit_result *result);
};
/* Commits into the store or overlay at `path` what the parts of a run over it have, in one synced transaction. The parts stay, to be
 * removed. The result is as if all pages of the run had been committed there at once. result->commit is the number of that commit. It is
 * 0 if the parts have no common commit: then nothing is changed. If this run was gathered before, nothing is changed either, and
 * result->commit is the last one of the store. Then parts may be missing already.
 *
 * STATUS_INPUT: a file is not a part, or is of another run. A part is missing, and others have more than one commit. Their numbers of
 * commits differ by more than one. Their records are of different scenes or steps. The store has changed since. A row is damaged.
 * STATUS_FAILED: a part, or another overlay over the store, is still open. */
enum status store_gather(const char *path, const char *const *parts, size_t count, const struct store_gathering *gathering,
			 struct store_commit_result *result) FURROW_CHECKED;

/* Drops all deformation and the working level. Keeps the base. Drops the history, too. An overlay becomes as it was made: what its parent has stays. The mark
 * is lost. STATUS_INPUT: overlays depend on its ruts, or it has snapshots; `force` loses them. */
enum status store_reset(struct store *store, bool force) FURROW_CHECKED;
/* How often it was reset: after each the numbers of revisions begin anew. */
enum status store_resets(const struct store *store, int64_t *count) FURROW_CHECKED;

/* --- pins: overlays that depend on a store ---
 *
 * A store keeps a list of its overlays, in the file PATH-pins. What commits, rollbacks and restores replace of a revision in that list is
 * kept, so that the overlay goes on reading it. Nobody who only reads writes that list. Overlays of the base alone that lie beside the store are not
 * listed: they are found there. */
enum store_pin_state {
	STORE_PIN_THERE, /* the file is where the list says */
	STORE_PIN_MOVED,  /* it is at `found`: a file there depends on the same */
	STORE_PIN_GONE,   /* no such file is known */
	STORE_PIN_FOUND,  /* the list lacks the overlay at `path`, which lies beside the store */
};
struct store_pin {
	const char *path;  /* absolute; NULL: a revision is kept, and the list has lost for whom */
	const char *found; /* NULL: at `path` */
	int64_t revision;  /* that it depends on */
	uint64_t hash;     /* of the store's ground then, or of its base */
	bool base;         /* it depends on the base alone, which no drive changes */
	int64_t made;      /* seconds since 1970; 0: not known */
	enum store_pin_state state;
};
typedef enum status (*store_pin_fn)(void *user, const struct store_pin *pin);
/* Calls `fn` for each. Reads what each file says of itself. Texts are valid during the call. */
enum status store_each_pin(struct store *store, store_pin_fn fn, void *user) FURROW_CHECKED;
/* Drops the pins whose files are gone, and what is kept for them alone. Lists those that were moved, or that the list lacks. Calls `fn` for
 * each, as it was before. Writes nothing if all stand. */
enum status store_prune(const char *path, store_pin_fn fn, void *user) FURROW_CHECKED;
/* Tells in a sentence without an end what a reset would lose; `whole`: what a new store in its place would. *count 0: nothing. */
enum status store_losses(struct store *store, bool whole, char *text, size_t room, int64_t *count) FURROW_CHECKED;

/* --- executed statements --- */

/* The tables. STORE_NO_TABLE counts statements that belong to no table: those of transactions. */
enum store_table {
	STORE_BASE_TABLE,
	STORE_OFFSET_TABLE,
	STORE_DISTURBANCE_TABLE,
	STORE_DEPOSITED_TABLE,
	STORE_PLASTIC_SINKAGE_TABLE,
	STORE_SHEAR_TABLE,
	STORE_DUG_TABLE,
	STORE_SETTLED_TABLE,
	STORE_LOOSE_TABLE,
	STORE_FLOOR_TABLE,
	STORE_DENSITY_TABLE,
	STORE_SLOPE_TABLE,
	STORE_HEALED_TABLE,
	STORE_RISEN_TABLE,
	STORE_GROWN_TABLE,
	STORE_META_TABLE,
	STORE_RUN_TABLE,
	STORE_HISTORY_TABLE,
	STORE_REVISION_TABLE,
	STORE_NO_TABLE,
	STORE_TABLES
};
const char *store_table_name(enum store_table table); /* "base", ..., "other" */
/* How many statements this store and its readers have executed so far, by table. Closed readers count too. Statements that open
 * a connection do not count. Any thread. */
struct store_statements {
	uint64_t read[STORE_TABLES], written[STORE_TABLES];
	uint64_t inherited[STORE_TABLES]; /* of `read`: those that a plain store would not need */
	/* What a history adds. kept: rows put into it, by the row's table, and their sum; for STORE_REVISION_TABLE the revisions that
	 * were written. sought: rows looked for in it. */
	uint64_t kept[STORE_TABLES], sought;
};
void store_statements(const struct store *store, struct store_statements *out);

/* Adds to `plan` the statements that commits execute. `planes`: the planes that pages have; 0: commits have no pages.
 * effects[plane]: the effect that needs the plane. `was_deformed`: earlier commits had pages, perhaps with other planes. Pure. */
void store_commit_plan(unsigned planes, bool was_deformed, const char *const effects[PLANES], struct plan *plan);
/* Adds what a history adds to that. */
void store_history_plan(unsigned planes, const char *const effects[PLANES], struct plan *plan);
/* Returns true if commits have to look into a history: it keeps every revision, or one was kept. */
bool store_has_history(const struct store *store);
/* Adds a line to `plan`: `amount` reads or writes of a table for each `unit`. */
void store_plan_reads(struct plan *plan, enum store_table table, int64_t amount, enum plan_unit unit, const char *effect);
void store_plan_writes(struct plan *plan, enum store_table table, int64_t amount, enum plan_unit unit, const char *effect);

/* --- information about a store --- */
struct store_numbers {
	int64_t base_tiles, plane_tiles[PLANES];
	int64_t file_bytes, base_bytes, plane_bytes[PLANES]; /* blobs as stored */
	int64_t commits, compacted, added;
	int64_t carried, in_flight;   /* of what counts as compacted: aboard bodies, and in flight, at the last commit of the last drive */
	int64_t revisions, snapshots; /* kept revisions, and names */
	int64_t history_rows, history_bytes; /* rows that commits replaced, blobs as stored */
	struct store_run last_run; /* scene_hash is NULL if there was no run; owned by the store */
};
enum status store_count(struct store *store, struct store_numbers *numbers) FURROW_CHECKED;
/* Gives only the last run, as store_count does. */
enum status store_last_run(struct store *store, struct store_run *run) FURROW_CHECKED;
/* Gives the soil that bodies of the last drive carry, and its soil in flight, at its last commit, in 2^-20 m summed over posts. Both count as compacted in the
 * store. STATUS_INPUT: the record is damaged. */
enum status store_last_soil(struct store *store, int64_t *carried, int64_t *in_flight) FURROW_CHECKED;
/* The time of a store, in which marks fade. It adds up over drives, from the first one that keeps such marks on. */
struct store_marks {
	bool any;                    /* a drive kept such marks; otherwise all else is 0 */
	double since, time;          /* s: how old the store was when the last drive began, and how long that drive took up to the last commit */
	double heals, rises, grows;  /* s: what the darkest marks take; 0: no drive kept such ones */
};
/* Reads it as the last commit has it. STATUS_INPUT: the record is damaged. */
enum status store_marks(struct store *store, struct store_marks *marks) FURROW_CHECKED;
/* The same of the record that store_last_run() read last. Reads nothing. */
enum status store_last_marks(const struct store *store, struct store_marks *marks) FURROW_CHECKED;
/* Returns that time and what marks take in fixed point, `time` s after the last drive began. Pure. */
struct plane_marks store_marks_at(const struct store_marks *marks, double time);
/* Returns true if that last run is of the parent: the overlay began with it and has no commit of its own. Call it after store_last_run(). */
bool store_run_inherited(const struct store *store);

struct store_check {
	int64_t problems;   /* number of all problems, including those that were not passed to `problem` */
	int64_t tiles;      /* rows checked */
	int coarsest, finest;
	int64_t compacted;  /* soil compacted, by the store's record: 2^-20 m */
	int64_t added;      /* soil brought from outside, likewise. Under conserving models the sum of offsets + compacted is added */
	int64_t carried, in_flight; /* of what counts as compacted: store_last_soil */
	/* for each level, at index level - TILE_LEVEL_MIN; a shared post counts once */
	int64_t offset_sum[TILE_LEVEL_MAX - TILE_LEVEL_MIN + 1];
};
typedef void (*store_problem_fn)(void *user, const char *text);
/* Checks everything: SQLite's own check, all hashes, edges between neighbours, coarser levels against finer ones, ranges. */
enum status store_verify(struct store *store, store_problem_fn problem, store_progress_fn progress,
			 void *user, struct store_check *check) FURROW_CHECKED;
/* Computes a hash of all rows, but not of the file's bytes. Stores with equal hashes have equal content. */
enum status store_content_hash(struct store *store, uint64_t *hash) FURROW_CHECKED;

/* --- imagery: colours over the terrain ---
 *
 * Pixels lie on the lattice of posts: level -2 has four pixels for each post along a side, and a pixel's centre is its post. A tile has
 * (cells + 1)^2 pixels and shares its edges with its neighbours, as a tile of heights does. Each pixel has four bytes: red, green, blue and
 * opacity. Opacity 0: the imagery has nothing there, and the colours are 0. Level L + 1 is level L smoothed (1 2 1) and every second pixel.
 * An overlay shows the imagery of its plain store. FORMAT.md tells how it is stored.
 */
struct store_imagery {
	bool found;      /* false: the store has no imagery, and the rest is 0 */
	bool broken_off; /* an import of imagery was broken off */
	int finest;      /* level of the finest tiles; the coarsest is extent_coarsest() */
	int quality;     /* 1 to 100 of WebP; 0: lossless */
	int64_t tiles, bytes;
	char sources[4096]; /* one on each line, cut after whole lines */
};
/* Of the store, or of the one under an overlay. Returns false if there is no imagery. `finest`, `quality`: as above; may be NULL. Any thread. */
bool store_has_imagery(const struct store *store, int *finest, int *quality);
uint64_t store_imagery_hash(const struct store *store); /* over all tiles; 0: there is none */
/* Counts, which takes longer. On the thread that uses the store. */
enum status store_imagery_info(const struct store *store, struct store_imagery *out) FURROW_CHECKED;
/* Reads a tile: (cells + 1)^2 * 4 bytes, row 0 south. If there is none, *found is false and all bytes are 0. STATUS_INPUT: the row is damaged.
 * STATUS_FAILED: this build has no libwebp. On any thread, each with its own reader. */
enum status store_imagery_read(struct store_reader *reader, struct tile tile, uint8_t *pixels, bool *found) FURROW_CHECKED;
/* Reads the pixels of `rect`, which may extend beyond the imagery. Row 0 is the south row. A level finer than the imagery gives the pixels of
 * its finest level, bilinear between them. */
enum status store_imagery_read_rect(struct store_reader *reader, int level, struct post_rect rect, uint8_t *pixels) FURROW_CHECKED;

/* Making it, on a plain store that is open for writing. Begin, put each tile once, finish. One thread at a time. */
struct store_imagery_making {
	int finest, quality;
	const char *sources; /* one on each line */
	const char *request; /* all that decides the tiles; an import that is resumed must have the same */
	bool resume, overwrite;
};
/* *tiles: how many tiles an import that is resumed has already. STATUS_INPUT: the store is an overlay; or has imagery, and `overwrite` is false;
 * or the import that was broken off had another request. */
enum status store_imagery_begin(struct store *store, const struct store_imagery_making *making, int64_t *tiles) FURROW_CHECKED;
enum status store_imagery_has(struct store *store, struct tile tile, bool *has) FURROW_CHECKED;
/* `packed`: of store_imagery_pack(). */
enum status store_imagery_put(struct store *store, struct tile tile, const void *packed, size_t size) FURROW_CHECKED;
enum status store_imagery_finish(struct store *store) FURROW_CHECKED; /* from then on the store has this imagery */
enum status store_imagery_suspend(struct store *store) FURROW_CHECKED; /* keeps what was put, for store_imagery_begin with `resume` */
enum status store_imagery_drop(struct store *store) FURROW_CHECKED;    /* removes what was put */
/* Packs side x side pixels of 4 bytes. Returns memory for mem_free(). Pure; on any thread. `quality` as in struct store_imagery. */
enum status store_imagery_pack(const uint8_t *pixels, uint32_t side, int quality, void **packed, size_t *size) FURROW_CHECKED;
bool store_imagery_possible(void); /* false: this build has no libwebp */
enum status store_imagery_check(const char *where) FURROW_CHECKED; /* STATUS_FAILED: the same, told of `where` */

/* --- reading posts, at any level from the finest to the coarsest --- */
enum store_layer {
	STORE_SURFACE,
	STORE_BASE,
	STORE_OFFSET,
	STORE_UNITS,
	STORE_SOIL, /* disturbance */
	STORE_HEALED, /* marks that fade: when they are gone, s of the store's time */
	STORE_RISEN,
	STORE_GROWN,
	STORE_DEPOSITED, /* from here on: the soil's state */
	STORE_PLASTIC_SINKAGE,
	STORE_SHEAR, /* its amount, a share of the soil's strength; and its parts to the east and to the north */
	STORE_SHEAR_EAST,
	STORE_SHEAR_NORTH,
	STORE_SETTLED, /* of a loose layer, as the planes have them; and how dense passes have made the soil, a share of 1 */
	STORE_LOOSE,
	STORE_DENSITY,
	STORE_LAYERS
};
/* Returns the part of a post's shear that a layer of shear shows. Pure. */
enum plane_shear_part store_shear_part(enum store_layer layer);
/* Reads the posts of `rect`, in metres; shear as a share of 1. Row 0 is the south row. Fixed-point offsets and disturbance are given
 * as stored. NaN: nodata, or outside the terrain.
 *
 * Base heights at level >= 0 are the stored ones. At finer levels (below 0) the base is interpolated as on the lattice. At
 * levels finer than the working level, offsets and other planes are interpolated too. STATUS_INPUT: the soil's state (deposited
 * thickness, plastic sinkage, shear) at a level coarser than the working level. */
enum status store_read_posts(struct store_reader *reader, enum store_layer layer, int level,
			     struct post_rect rect, double *values) FURROW_CHECKED;

/* Heights at a point. The point is in metres from the south-west post. Heights are bilinear between posts of the finest level
 * stored there. */
struct store_sample {
	double height, base, offset; /* metres; NaN where nodata */
	bool nodata, outside;
	unsigned disturbance;
	unsigned planes; /* the planes that the tile at this point has, a mask of PLANE_BIT */
	/* at the nearest post: metres; and the mobilised shear to the east and to the north, shares of the soil's strength */
	double deposited, plastic_sinkage, shear[2];
	/* At the nearest post: how thick soil lies loose there, m, with what came since a body touched it. How dense passes have made it, a share of 1 */
	double loose, density;
	double healed, risen, grown; /* at the nearest post: when its marks are gone, s of the store's time; 0: it never had one */
};
enum status store_sample(struct store_reader *reader, double x, double y, struct store_sample *sample)
	FURROW_CHECKED;

#endif
