/* Shared by the files of src/store: the connection to SQLite, rows of tiles, and small helpers for SQLite. */
#ifndef FURROW_STORE_INTERNAL_H
#define FURROW_STORE_INTERNAL_H

#include <sqlite3.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "store/changes.h"
#include "store/codec.h"
#include "store/lineage.h"
#include "store/pins.h"
#include "store/store.h"

#define STORE_APPLICATION_ID 0x46757277 /* "Furw" */
#define STORE_VERSION 8
#define STORE_VERSION_OLDEST 3 /* it is read too: its shear, a length without direction, counts as none */
#define STORE_VERSION_SHEAR 4  /* the first with a shear that is read */
#define STORE_VERSION_HISTORY 5 /* the first that can keep a history */
#define STORE_VERSION_PINS 6    /* the first that can keep what overlays depend on */
#define STORE_VERSION_LOOSE 7   /* the first that keeps what a post remembers of loose layers */
#define STORE_VERSION_MARKS 8   /* the first that keeps marks that fade */
#define STORE_VERSION_IMAGERY 9 /* of a store with imagery; one without stays at STORE_VERSION, so that older programs read it */
#define STORE_BUSY_MS 5000
#define STORE_DEPTH_MOST 16 /* overlays over a plain store */

/* In store_commit.c: returns STATUS_INTERRUPTED if run->given_up tells to give up the commit. */
enum status store_commit_goes_on(const struct store *store, const struct store_run *run) FURROW_CHECKED;
/* store_place.c: STATUS_FAILED if the file was moved, replaced or deleted since it was opened, or its WAL was deleted. A file under an overlay
 * that is gone is only told, once. Call it before a transaction, on the writer's thread. */
enum status store_place_check(struct store *store) FURROW_CHECKED;

/* --- store_sql.c: calls of SQLite, with error messages --- */

/* Reports a failed call on `db`. The message tells what was being done (`doing`) to the store at `path`. Never returns
 * STATUS_OK. */
enum status store_sql_fail(sqlite3 *db, int code, const char *path, const char *doing);
enum status store_sql_exec(sqlite3 *db, const char *path, const char *doing, const char *sql) FURROW_CHECKED;
/* Begins a transaction that writes. If an earlier transaction could not be undone for lack of memory, undoes it first. */
enum status store_sql_begin(sqlite3 *db, const char *path, const char *doing) FURROW_CHECKED;
/* Undoes the transaction, unless the failure has already undone it. The error message stays that of the failure. */
void store_sql_undo(sqlite3 *db);
/* Prepares *statement if it is not prepared yet. */
enum status store_sql_prepare(sqlite3 *db, const char *path, sqlite3_stmt **statement, const char *sql)
	FURROW_CHECKED;
/* Gives the first column of the first row as an integer. */
enum status store_sql_integer(sqlite3 *db, const char *path, const char *sql, int64_t *value) FURROW_CHECKED;

/* --- store_rows.c: the tables of tiles, a row at a time --- */

/* The table of the base, and one table for each plane. */
enum row_table { ROW_BASE, ROW_OFFSET, ROW_DISTURBANCE, ROW_DEPOSITED, ROW_PLASTIC_SINKAGE, ROW_SHEAR, ROW_DUG, ROW_SETTLED, ROW_LOOSE, ROW_FLOOR, ROW_DENSITY, ROW_SLOPE,
		 ROW_HEALED, ROW_RISEN, ROW_GROWN, ROW_TABLES };

static inline enum row_table row_table_of(enum plane plane)
{
	return (enum row_table)(ROW_OFFSET + (int)plane);
}

/* Returns the plane of a table. The table must not be the base's. */
static inline enum plane row_plane(enum row_table table)
{
	return (enum plane)(table - ROW_OFFSET);
}

/* Returns true for tables of the soil's state. They have rows at the working level only. */
static inline bool row_is_state(enum row_table table)
{
	return table >= ROW_DEPOSITED && table < ROW_HEALED;
}

struct row {
	struct tile tile;
	double low, high; /* metres, for disturbance the stored numbers; both NaN: all posts are nodata */
	double error;     /* metres; base only */
	int64_t codec;    /* as read; not yet checked */
	int64_t revision; /* the commit that wrote this row; 0: the import */
	uint64_t hash;
	int64_t below, above; /* sums of the tile's own negative and positive offsets, in fixed-point units; only for offsets */
	const void *bytes;    /* valid until the table is used again */
	size_t size;
};

/* Prepared statements and scratch memory of one connection. One thread. */
struct rows {
	sqlite3 *db;
	const char *path;         /* path of the store */
	const struct extent *extent;
	struct codec codec;
	int32_t *wide;            /* (cells + 1)^2 */
	sqlite3_stmt *find[ROW_TABLES], *head[ROW_TABLES], *write[ROW_TABLES], *drop[ROW_TABLES],
		*under[ROW_TABLES], *below;
	/* Of an overlay over a deformed store or over an overlay: what it inherits, and the rows of each layer under it. Then all
	 * functions below give the row that counts: its own, or the nearest inherited one. NULL: the file alone counts. */
	const struct lineage *lineage;
	struct rows *const *layers;
	struct statements *statements; /* of the overlay, where further reads are counted */
};

enum status store_rows_init(struct rows *rows, sqlite3 *db, const char *path, const struct extent *extent,
		      enum codec_effort effort) FURROW_CHECKED;
void store_rows_finish(struct rows *rows); /* call this before the connection is closed */
/* Returns true if this row of an overlay says that there is no row, over one that it inherits. */
static inline bool row_is_none(const struct row *row)
{
	return row->low == 0 && row->high == 0;
}

const char *store_rows_name(enum row_table table);
const char *store_rows_sql_name(enum row_table table); /* quoted if it is a word of SQL */
/* Writes the name of a tile's row for messages: "store.furrow: base tile level 1 x 2 y 3". */
void store_rows_text(const struct rows *rows, enum row_table table, struct tile tile, char *text, size_t room);
/* Reads a row without its blob, and checks that its numbers make sense. */
enum status store_rows_head(struct rows *rows, enum row_table table, struct tile tile, struct row *row,
		      bool *found) FURROW_CHECKED;
/* Reads a row and its posts, and checks its hash. If it is not found, posts stay unchanged. */
enum status store_rows_read(struct rows *rows, enum row_table table, struct tile tile, int32_t *posts,
		      struct row *row, bool *found) FURROW_CHECKED;
/* Encodes the posts into the row: sets codec, hash, bytes and size. */
void store_rows_encode(struct rows *rows, enum row_table table, const int32_t *posts, struct row *row);
/* Writes a row that is already encoded. If an overlay inherits the same row, removes its own instead. */
enum status store_rows_put(struct rows *rows, enum row_table table, const struct row *row) FURROW_CHECKED;
/* Removes a row. If an overlay inherits one, writes a row of zeros with this revision over it. */
enum status store_rows_drop(struct rows *rows, enum row_table table, struct tile tile, int64_t revision) FURROW_CHECKED;
/* Calls `fn` with the row that counts and its bytes, whose hash was checked; NULL: there is none. `fn` must not use the table. */
typedef enum status (*row_bytes_fn)(void *user, const struct row *row);
enum status store_rows_bytes(struct rows *rows, enum row_table table, struct tile tile, row_bytes_fn fn, void *user) FURROW_CHECKED;
/* Copies a row, which must exist, from one connection to another. Checks its hash and gives it this revision. */
enum status store_rows_copy(struct rows *from, struct rows *to, enum row_table table, struct tile tile, int64_t revision)
	FURROW_CHECKED;
/* Gives the range and the number of the rows of the next finer level below `tile`. */
enum status store_rows_under(struct rows *rows, enum row_table table, struct tile tile, double *low,
		       double *high, int *count) FURROW_CHECKED;
/* Calls `fn` for each row with a key from `first` to `last`, in the order of keys. `fn` may use `rows`, but not change the table.
 * The key is as stored: it may lie outside the terrain. */
struct row_entry {
	uint64_t key, hash;
	int64_t revision;
	uint32_t size; /* bytes of its blob */
	const struct lineage_entry *inherited; /* NULL: the row is the file's own */
};
typedef enum status (*row_entry_fn)(void *user, const struct row_entry *entry);
enum status store_rows_each(struct rows *rows, enum row_table table, uint64_t first, uint64_t last, row_entry_fn fn, void *user)
	FURROW_CHECKED;
/* Counts the rows of a table, and the bytes of their blobs. */
enum status store_rows_count(struct rows *rows, enum row_table table, int64_t *count, int64_t *bytes) FURROW_CHECKED;
uint64_t store_rows_hash(enum row_table table, const struct row *row);
/* Takes a row and its bytes from a statement's columns: low, high, error, codec, revision, hash, below, above, blob. Checks its numbers and
 * its hash. */
enum status store_rows_take(const struct rows *rows, enum row_table table, struct tile tile, sqlite3_stmt *statement, struct row *row)
	FURROW_CHECKED;
/* Says that a row is damaged, and how. Returns STATUS_INPUT. */
enum status store_rows_bad(const struct rows *rows, enum row_table table, struct tile tile, const char *why);

/* --- store_below.c: base tiles that are every second post of the tiles below them --- */

/* Returns true for tiles that may be stored so: those of the odd levels above 0. */
bool store_below_has(struct tile tile);
/* Returns the blob of such a tile: bit i says that there is a tile (2x + i % 2, 2y + i / 2) below it. */
uint8_t store_below_children(const struct extent *extent, struct tile tile);
/* As store_rows_read(), for the base tiles for which store_below_has() is true, however they are stored. */
enum status store_below_read(struct rows *rows, struct tile tile, int32_t *posts, struct row *row, bool *found) FURROW_CHECKED;

/* Returns a post in metres; for disturbance the stored number. */
double store_rows_metres(enum row_table table, int32_t post, double step);
/* Computes the range of a tile's own posts, in metres (for disturbance, the stored numbers; for shear, shares, of both parts of the
 * posts together). Both NaN if all are nodata. */
void store_rows_range(enum row_table table, const int32_t *posts, size_t count, double step, double *low,
		double *high);
bool store_rows_all_zero(const int32_t *posts, size_t count);
/* Sums the tile's own offsets below zero and above zero. The last row and column count only at the end of the terrain, so that
 * each shared post counts once. */
void store_rows_sums(const struct extent *extent, struct tile tile, const int32_t *posts, int64_t *below,
	       int64_t *above);

/* --- store_statements.c: counts executed statements by table --- */

struct statements {
	atomic_uint_fast64_t read[STORE_TABLES], written[STORE_TABLES];
	atomic_uint_fast64_t inherited[ROW_TABLES]; /* reads that an overlay needs beyond those of a plain store */
	atomic_uint_fast64_t kept[ROW_TABLES]; /* rows that commits put into the history, by the table of the row */
	atomic_uint_fast64_t sought, revisions; /* rows looked for in the history, and attempts to keep a revision */
};
/* Forgets what was counted. */
void store_statements_restart(struct statements *statements);
/* From now on, counts the statements of connection `db` in `statements`. */
void store_statements_count(struct statements *statements, sqlite3 *db);

/* --- store_history.c: what commits replaced --- */

/*
 * The rows of revisions that are kept. A revision is kept if it has a snapshot, or if the commit after it kept what it replaced. Of each
 * kept revision the file has the rows that the commits after it changed, until the next kept one.
 */
struct history_row {
	enum row_table table; /* "plane" in the file */
	uint64_t key;
	int64_t revision, form, codec;
	const void *bytes;
	size_t size;
};

struct history {
	bool each, last; /* every revision is kept, or only the one before the present one (store_options) */
	int64_t kept;   /* the newest revision in the table; -1: none */
	int64_t label;  /* in a transaction: the revision whose rows are kept; -1: none */
	bool deltas;    /* in a transaction: rows are kept as differences */
	bool copies;    /* in a transaction: rows are kept as they are, and no older ones are kept */
	bool has_level; /* it has rows, of the level below */
	int level;
	bool before_read;        /* `before` has the posts that the row had at revision `label` */
	int32_t *before, *after; /* one tile each */
	struct rows rows;        /* the store's connection, with a codec and statements of its own */
	sqlite3_stmt *find, *put, *put_first;
};

/* Reads what the file has. Call this when the store's rows can be read. */
enum status store_history_open(struct store *store) FURROW_CHECKED;
void store_history_finish(struct store *store);
/* Call this when a transaction that changes rows has begun. `always`: keeps the present revision, even without keep_history. */
enum status store_history_begin(struct store *store, bool always) FURROW_CHECKED;
/* Call this when the transaction is over. `status`: how it went; after a failure the transaction is undone. Returns `status`. */
enum status store_history_end(struct store *store, enum status status) FURROW_CHECKED;
/* Call these before and after a row is changed. `posts`: the new ones; NULL: none, all zero. */
enum status store_history_before(struct store *store, enum row_table table, struct tile tile) FURROW_CHECKED;
enum status store_history_after(struct store *store, enum row_table table, struct tile tile, const int32_t *posts) FURROW_CHECKED;
/* As store_history_after, where the new posts are to be read from the row. */
enum status store_history_after_read(struct store *store, enum row_table table, struct tile tile) FURROW_CHECKED;
/* Adds the present revision to the table of kept ones, unless it is there. In a transaction. */
enum status store_history_keep(struct store *store) FURROW_CHECKED;
/* Gives the posts that a tile of the working level had at a kept revision. */
enum status store_history_posts(struct store *store, enum row_table table, struct tile tile, int64_t revision, int32_t *posts)
	FURROW_CHECKED;
/* Gives the posts that the file itself keeps of a tile at a revision, whole. *found is false if it keeps none of just this revision. */
enum status store_history_kept(struct store *store, enum row_table table, struct tile tile, int64_t revision, int32_t *posts, bool *found)
	FURROW_CHECKED;
/* Writes a row, in a transaction. */
enum status store_history_put(struct store *store, const struct history_row *row) FURROW_CHECKED;
uint64_t store_history_hash(const struct history_row *row);

/* --- store_part.c: parts --- */

/* The "plane" of the rows of a part's history that say which commit had a tile's page. */
#define PART_CLAIM ROW_BASE

/* Notes, in a commit of a part, that it has these pages. */
enum status store_part_claim(struct store *store, const struct store_page *pages, size_t count) FURROW_CHECKED;
/* Returns STATUS_INPUT if the store is a part. `what` cannot be done with it on its own. */
enum status store_part_refuse(const struct store *store, const char *what) FURROW_CHECKED;
/* Opens a part alone for reading: without the files under it, so only the rows of its own file can be read. STATUS_INPUT: it is none. */
enum status store_part_open(const char *path, struct store **out) FURROW_CHECKED;
/* The next functions give what a part that was opened alone had at `commit`: its last one, or the one before. */

/* Calls `fn` for each tile of which a page was committed, in the order of keys, with the number of the last such commit. */
typedef enum status (*part_claim_fn)(void *user, uint64_t key, int64_t commit);
enum status store_part_claims(struct store *part, int64_t commit, part_claim_fn fn, void *user) FURROW_CHECKED;
/* Gives the posts of its own row of a tile of the working level, zeros if that undoes an inherited row. *found is false if it has no
 * row: then what is inherited counts. posts NULL: only asks. */
enum status store_part_posts(struct store *part, enum row_table table, struct tile tile, int64_t commit, int32_t *posts, bool *found)
	FURROW_CHECKED;
/* Calls `fn` with the key of each tile for which it has a row of the soil's state, in the order of keys. */
enum status store_part_each(struct store *part, enum row_table table, int64_t commit, store_key_fn fn, void *user) FURROW_CHECKED;

/* --- store_run.c: the run's record --- */

struct store_run_copy {
	bool found;
	int64_t commit, step;
	double time;
	int64_t made; /* seconds since 1970; 0: not known */
	char *scene_hash, *state, *who, *what; /* owned by this copy */
};
/* Gives the name of the user whom this process belongs to. */
void store_who(char *name, size_t room);
/* Reads the record that the file has now. `copy` must be filled by an earlier call, or zero. */
enum status store_run_copy(struct store *store, struct store_run_copy *copy) FURROW_CHECKED;
void store_run_copy_finish(struct store_run_copy *copy);
/* Reads the record of a kept revision, and what the header had then. */
struct store_run_header {
	bool has_working;
	int64_t compacted, added;
};
enum status store_run_copy_kept(struct store *store, int64_t revision, struct store_run_copy *copy, struct store_run_header *header)
	FURROW_CHECKED;
/* Writes the record of the next commit, with the text `state`. */
enum status store_run_put(struct store *store, const struct store_run *run, const char *state) FURROW_CHECKED;
/* Writes the record of a copy as that of the next commit. `what` was done. Removes the record if the copy has none. */
enum status store_run_put_back(struct store *store, const struct store_run_copy *copy, const char *what) FURROW_CHECKED;

/* --- store_undo.c: marks and rollbacks --- */

/* What a rollback needs. It is in a separate SQLite database without a name. SQLite keeps the database in memory, or above a
 * few MB in a file that it has already unlinked. So the store's file gets no extra tables, and nothing remains if the process
 * is killed. */
struct undo {
	struct rows rows; /* access to the separate database; without a codec */
	int64_t kept;     /* number of kept rows */
	/* The store as it was at the mark: */
	int64_t commit; /* its number then, or that of the last rollback to the mark */
	bool working_stored, has_compacted;
	int64_t compacted, added;
	struct store_run_copy run;
};

/* Call this before a commit changes a row. Keeps the row as it was at the last mark. `had`: the row exists. */
enum status store_undo_keep(struct store *store, enum plane plane, struct tile tile, bool had) FURROW_CHECKED;
void store_undo_destroy(struct undo *undo); /* undo may be NULL */

/* --- the store --- */

/* Tells if a table of the soil's state has rows. */
enum state_rows { STATE_UNKNOWN, STATE_NONE, STATE_MAYBE };

/* --- store_frozen.c: reading a store that nobody writes --- */

enum store_way { STORE_PLAIN, STORE_IMMUTABLE, STORE_ASIDE };
enum { STORE_FILE_NUMBERS = 4 };
struct store_frozen {
	bool is; /* the connection sees the file as it was when it was made */
	int64_t file[STORE_FILE_NUMBERS], wal[STORE_FILE_NUMBERS]; /* what they looked like before that */
};
/* Finds how a store whose header says WAL is read without making a file beside it. Fills `frozen`, but leaves frozen->is false. */
enum store_way store_frozen_way(const char *path, struct store_frozen *frozen);
/* Returns true if file or WAL look other than when the connection was made, and it is frozen. */
bool store_frozen_changed(const char *path, const struct store_frozen *frozen);
/* Returns true if the header of the connection's file says WAL. Reads it without a lock, and makes no file. */
bool store_frozen_says_wal(sqlite3 *db);
/* Returns the name of the VFS that a connection of the way STORE_ASIDE uses. */
const char *store_frozen_vfs(void);

struct store {
	struct history history;
	struct pins pins;
	int version;     /* of the file */
	char *path;      /* the path that messages show */
	char *real_path; /* the path of the file, links resolved */
	const struct store_staged *staged; /* while it is being opened: the copy to read in place of the base under it; NULL: none */
	char *copied_from; /* the path of this file, where `path` is that of a copy, which is read in its place; NULL: the file is read */
	char *part_path; /* path of the file being written; NULL after publishing, and for opened stores */
	char *lock_path;
	int lock;        /* file descriptor of the lock; -1: none */
	bool lock_was_there; /* a killed writer left the lock's file: who only looks leaves it, too */
	enum store_overwrite overwrite;
	bool keeps_part; /* store_close leaves PATH.part */
	bool writing;    /* opened for writing */
	bool late;       /* opened for writing, and nothing of the file was changed yet: `db` can only read (store_begin) */
	bool older;      /* late, and of an earlier version */
	atomic_bool raised; /* it was made one of this version since it was opened: readers connect anew */
	bool wal_seen;   /* the file of the WAL was there when store_place_check() looked */
	bool base_told;  /* a file under it was gone then, and was told */
	bool durable_full;
	char *scene;     /* from store_options; NULL: none */
	char who[64];    /* who writes */
	int64_t commit_bytes; /* while making a store: commit after this many bytes */
	int64_t uncommitted;  /* bytes put since the last commit, which was at `committed` seconds */
	double committed;
	sqlite3 *db;
	struct rows rows;
	char *base_path;    /* of an overlay: path of its parent as stored, relative to the overlay's folder; NULL: a plain store */
	struct store *under; /* of an overlay: its parent, open for reading; NULL: a plain store */
	struct store *over; /* while a parent is being opened: the overlay that names it */
	const uint64_t *wanted; /* while it is being opened: the state that must be shown (store_lineage_hash); NULL: that of an overlay's parent, or the present one */
	int64_t shown;   /* a pinned revision that is shown in place of the present one; -1: none */
	const char *parent_given; /* while it is being relinked: the file to take for its parent; NULL: the one that it names */
	bool over_told;     /* the parent is an overlay, and has told what is wrong with a file under it */
	int depth;          /* files under this one; 0: a plain store */
	bool inherits;      /* an overlay that shows the deformation of its parent, too */
	uint64_t parent_hash;    /* if it inherits: the parent's state (store_lineage_hash), and its revision, as of the making */
	int64_t parent_revision;
	struct lineage lineage;  /* if it inherits: the rows of all files under it */
	struct rows *layers[STORE_DEPTH_MOST]; /* the rows of each file under it; 0: the plain store */
	struct rows *base;  /* where base tiles are read: `rows`, or those of the plain store under it */
	bool made;          /* an overlay that did not exist before it was opened */
	bool moved_on;      /* while an overlay of it is made: it was committed to since it was opened */
	bool alone;         /* an overlay whose parent is not opened (store_part_open) */
	struct store_part part; /* count 0: it is none */
	struct store_meta meta; /* its texts are owned by the store */
	int32_t code_low, code_high; /* the meta's low and high as height codes; low > high: all nodata */
	int finest_base; /* the finest level with base tiles; 0: there are no insets */
	bool has_working, working_stored;
	int working;
	char *relief_text; /* of what is deformed, or of the history; NULL: none (store_relief.c) */
	bool relief_stored;   /* the file has such a text */
	struct relief relief; /* what raises the ground now, */
	struct rocks rocks;   /* and these */
	int64_t compacted; /* soil compacted, as of the last commit; only when writing */
	int64_t added;     /* soil added, likewise */
	enum state_rows state_rows[ROW_TABLES]; /* for each table of the soil's state; only when writing */
	uint64_t base_hash; /* hash of the base (store_identity.c) */
	int64_t commit; /* number of the last commit */
	bool has_imagery;  /* of a plain store, as of its opening or of the end of an import of imagery; then these: */
	int imagery_finest, imagery_quality;
	uint64_t imagery_hash;
	bool imagery_made; /* an import of imagery is in a transaction */
	bool marked;       /* there is a mark, and the undo belongs to it */
	struct undo *undo; /* NULL: never marked */
	struct changes changes; /* store_changes.c */
	int64_t frame_bytes;  /* bytes of a page in the WAL, with its header */
	int64_t wal_bytes;    /* bytes of the WAL in use after the last commit */
	int64_t wal_patience; /* size of the WAL from which a checkpoint waits for readers */
	sqlite3_stmt *run_statement, *meta_statement;
	struct statements statements; /* counts this connection and those of readers */
	struct store_run_copy last_run; /* the last result of store_last_run() */
};

struct store_reader {
	struct store *store;
	sqlite3 *db;
	struct store_frozen frozen, layer_frozen[STORE_DEPTH_MOST]; /* of `db`, and of layer_db */
	bool older; /* it was made before the store was raised to this version */
	struct rows rows;
	/* Of an overlay: a connection to each file under it that is read. `base`: `rows`, or those of the plain store. */
	sqlite3 *layer_db[STORE_DEPTH_MOST];
	struct rows layer_rows[STORE_DEPTH_MOST], *layers[STORE_DEPTH_MOST], *base;
	sqlite3_stmt *imagery; /* reads a tile of imagery, on the connection of `base`; NULL: none was read yet */
};

/* In store_read.c. Call the first before rows of the reader are used, outside a transaction: it connects anew if the reader is outdated. It is
 * when somebody wrote that its connection cannot see. A result counts only if the reader is not outdated afterwards. */
enum status store_reader_begin(struct store_reader *reader) FURROW_CHECKED;
bool store_reader_outdated(const struct store_reader *reader);

/* Returns the rows of `table`. Base tiles of an overlay are in another file. */
static inline struct rows *store_table(struct store *store, enum row_table table)
{
	return table == ROW_BASE ? store->base : &store->rows;
}

/* Gives the first and last key of a level's tiles. The level is in the upper bits of a key. */
static inline void level_keys(int level, uint64_t *first, uint64_t *last)
{
	*first = tile_key((struct tile){level, 0, 0});
	*last = *first | (((uint64_t)1 << 56) - 1);
}

/* --- store_connect.c --- */

enum status store_connect_file(const char *path, const char *named, bool writing, sqlite3 **db) FURROW_CHECKED;
/* Connects a reader. Undoes an unfinished transaction if there is a journal. Otherwise changes and makes no file, if nobody has the store open
 * for writing. frozen->is: what it reads is right until store_frozen_changed() says that somebody wrote; connect anew then. */
enum status store_connect_reader(const char *path, const char *named, struct store_frozen *frozen, sqlite3 **db) FURROW_CHECKED;
/* Returns true if there is a WAL beside the file, which may hold pages of it. `path` is a real path. */
bool store_connect_has_wal(const char *path);
/* returns true if there is a journal, with which an unfinished transaction can be undone */
bool store_connect_has_journal(const char *path);

/* --- store_wal.c --- */

/* Call this only after the schema was checked. */
enum status store_wal_begin(struct store *store) FURROW_CHECKED;

/* --- store_schema.c --- */

enum status store_schema_create(sqlite3 *db, const char *path) FURROW_CHECKED;
/* STATUS_INPUT unless application_id, user_version and all objects of the schema are as this program, or an older one, makes them.
 * If *version is less than STORE_VERSION, call one of the other two before its rows are read. */
enum status store_schema_check(sqlite3 *db, const char *path, int *version) FURROW_CHECKED;
/* Shows this connection an older store as one of this version. The file stays as it is. */
enum status store_schema_hide(sqlite3 *db, const char *path, int version) FURROW_CHECKED;
/* Makes an older store one of this version, in one transaction. Shear of version 3 is dropped. */
enum status store_schema_raise(sqlite3 *db, const char *path, int version) FURROW_CHECKED;

/* Gives the store the table of imagery, and version 9. In a transaction; set store->version when it is committed. */
enum status store_schema_add_imagery(struct store *store) FURROW_CHECKED;
enum status store_schema_drop_imagery(struct store *store) FURROW_CHECKED; /* the reverse, in the same way */

/* --- store_imagery.c --- */

/* Returns the store that has the imagery: the plain one at the end of a chain. */
const struct store *store_imagery_holder(const struct store *store);
#define STORE_IMAGERY_WEBP 1 /* the codec of a row */
uint64_t store_imagery_row_hash(uint64_t key, int64_t codec, const void *bytes, size_t size);
/* Computes the hash over all rows of imagery; 0: there are none. `db` is a connection to a store of version 9. */
enum status store_imagery_compute(sqlite3 *db, const char *path, uint64_t *hash) FURROW_CHECKED;
/* Reads what the header of a plain store says of imagery, into the store. */
enum status store_imagery_open(struct store *store) FURROW_CHECKED;
/* Unpacks a blob into side x side pixels of 4 bytes. Returns false if it is no such picture. In store_imagery_pixels.c. */
bool store_imagery_unpack(const void *bytes, size_t size, uint32_t side, uint8_t *pixels);
/* Copies the imagery of `from` into a plain store that is being made, in its transaction. */
enum status store_imagery_copy(const struct store *from, struct store *to) FURROW_CHECKED;
/* Checks all rows, each by its hash and its size, and that each has the tile above it. Calls `tell` with what is wrong. */
enum status store_imagery_verify(const struct store *store, void (*tell)(void *user, const char *text), void *user) FURROW_CHECKED;

/* --- store_misfit.c: meta.off_resampled and meta.off_source in the file --- */
enum status store_misfit_write(struct store *store) FURROW_CHECKED; /* in a transaction */
enum status store_misfit_read(struct store *store) FURROW_CHECKED;

/* --- store_meta.c --- */

enum status store_meta_copy(struct store_meta *to, const struct store_meta *from) FURROW_CHECKED;
void store_meta_finish(struct store_meta *meta);
enum status store_meta_write(struct store *store) FURROW_CHECKED;
enum status store_meta_read(struct store *store) FURROW_CHECKED; /* also the working level and the commit */
/* The request of a store being made: written when it is begun, compared when it is resumed, even if only the rename is missing.
 * *same is false if the file has another request, or none. */
/* Reads what three keys say. No such keys: no posts. */
enum status store_meta_misfit(struct store *store, const char *posts, const char *greatest, const char *squares,
			      struct misfit *misfit) FURROW_CHECKED;
enum status store_meta_put_request(struct store *store) FURROW_CHECKED;
enum status store_meta_same_request(struct store *store, bool *same) FURROW_CHECKED;
enum status store_meta_put_base_path(struct store *store) FURROW_CHECKED; /* store->base_path */
enum status store_meta_put_text(struct store *store, const char *key,
				const char *value) FURROW_CHECKED;
enum status store_meta_put_integer(struct store *store, const char *key, int64_t value) FURROW_CHECKED;
enum status store_meta_put_real(struct store *store, const char *key, double value) FURROW_CHECKED;
enum status store_meta_drop(struct store *store, const char *key) FURROW_CHECKED;
/* *found false, or NULL: there is no such key, or its value is of another type. *text is for mem_free(). */
enum status store_meta_find_integer(const struct store *store, const char *key, bool *found, int64_t *value) FURROW_CHECKED;
enum status store_meta_find_text(const struct store *store, const char *key, char **text) FURROW_CHECKED;
/* Reads the hash of the base from the file of a connection. */
enum status store_meta_base_hash(sqlite3 *db, const char *path, uint64_t *hash) FURROW_CHECKED;
/* Adds to the compacted soil in the file. store->compacted does not change. */
enum status store_meta_add_compacted(struct store *store, int64_t more) FURROW_CHECKED;
/* Reads how much soil was compacted so far, as the file has it now: 2^-20 m, summed over posts. */
enum status store_meta_compacted(sqlite3 *db, const char *path, int64_t *compacted) FURROW_CHECKED;
/* The same of soil that was added. store_meta_added_at: up to a kept or pinned revision. store_meta_keep_added: keeps for the present revision what
 * the other reads. store_meta_put_added: writes the whole amount. */
enum status store_meta_add_added(struct store *store, int64_t more) FURROW_CHECKED;
enum status store_meta_put_added(struct store *store, int64_t added) FURROW_CHECKED;
enum status store_meta_added(sqlite3 *db, const char *path, int64_t *added) FURROW_CHECKED;
enum status store_meta_added_at(sqlite3 *db, const char *path, int64_t revision, int64_t *added) FURROW_CHECKED;
enum status store_meta_keep_added(struct store *store) FURROW_CHECKED;
enum status store_meta_forget_added(struct store *store) FURROW_CHECKED; /* what is kept for revisions before the present one */
/* Writes the working level, and the relief under it; NULL: none. */
enum status store_meta_put_working(struct store *store, int level,
				   const char *relief) FURROW_CHECKED;
/* Makes the relief of the store anew, from its text and its working level. STATUS_INPUT: the text
 * is wrong. */
enum status store_relief_settle(struct store *store) FURROW_CHECKED;
bool store_relief_equal(const char *one, const char *other); /* texts; NULL: none */
/* Reads the working level as the file has it now. */
enum status store_meta_working(sqlite3 *db, const char *path, const struct extent *extent, bool *has, int *level)
	FURROW_CHECKED;

/* --- store_hash.c: hashes over numbers and texts --- */

struct XXH3_state_s;
void store_hash_words(struct XXH3_state_s *state, const uint64_t *words, size_t count);
void store_hash_text(struct XXH3_state_s *state, const char *text);
void store_hash_added(struct XXH3_state_s *state, int64_t added); /* nothing where no soil was added */
uint64_t store_hash_real(double value); /* returns the bits of a double; 0 for NaN */

/* --- store_identity.c: the identity of a store's base --- */

/* Computes the hash from the rows of the base. The store's meta must be complete. */
enum status store_identity_compute(struct store *store, uint64_t *hash) FURROW_CHECKED;

/* --- store_change.c: changes of rows in a commit --- */

/* Writes `posts` as the tile's row, with the range and sums in *row. `old`: the present row; NULL: there is none. Counts the
 * change in `result`. */
enum status store_change_write(struct store *store, enum row_table table, const int32_t *posts, struct row *row,
			 const struct row *old, struct store_commit_result *result) FURROW_CHECKED;
/* Removes the row; `old` is the present row. */
enum status store_change_drop(struct store *store, enum row_table table, const struct row *old,
			struct store_commit_result *result) FURROW_CHECKED;

/* --- store_climb.c: tiles of the working level, and the levels above them --- */

struct climb_item {
	uint64_t key;  /* of a tile of the working level; each once */
	size_t index;  /* for the source */
	size_t posts;  /* of the tile */
};
struct climb_source {
	void *user;
	/* Gives the new posts of an item. They may be in `scratch`, which has room for a tile. */
	enum status (*posts)(void *user, enum row_table table, const struct climb_item *item, int32_t *scratch, const int32_t **posts);
};
/* Writes the new posts of the tiles, and all tiles above them. Sorts the items. Stops if run->given_up tells so. */
enum status store_climb(struct store *store, enum row_table table, struct climb_item *items, size_t count,
			const struct climb_source *source, const struct store_run *run, struct store_commit_result *result)
	FURROW_CHECKED;

/* --- store_state.c: the soil's state in a commit --- */

/* Writes a tile of one plane of the soil's state. Drops its row if all posts are zero. */
enum status store_state_put_tile(struct store *store, enum row_table table, struct tile tile, const int32_t *posts,
				 struct store_commit_result *result) FURROW_CHECKED;

/* Commits one plane of the soil's state. Rows are written for pages that have the plane, and dropped for pages that lack it. If
 * no page has the plane and the table is empty, the table is not used. */
enum status store_state_put(struct store *store, enum row_table table, const struct store_page *pages, size_t count,
			    const struct store_run *run, struct store_commit_result *result) FURROW_CHECKED;

/* --- store_lock.c: one writer --- */

enum status store_lock_take(const char *lock_path, const char *named, int *descriptor) FURROW_CHECKED;
void store_lock_drop(const char *lock_path, int descriptor); /* also removes the lock's file, unless lock_path is NULL */
/* As store_lock_take, but if another process has the lock, *taken is false and *descriptor stays. */
enum status store_lock_try(const char *lock_path, const char *named, int *descriptor, bool *taken) FURROW_CHECKED;

/* --- store_copy.c --- */

/* Copies what an open store shows into a new plain store at `out`. Kept revisions and their names are not copied. `what` made the file. `imagery`: also imagery.
 * `progress` is called with rows; NULL: none. From then on `from` reads what it is now (store_overlay_hold). */
enum status store_copy(struct store *from, const char *out, enum store_overwrite overwrite, const char *what, bool imagery, store_progress_fn progress, void *user)
	FURROW_CHECKED;

/* --- store_posts.c --- */

/* Reads the posts that the base has at just this level, in metres; NaN: it has none there, or a hole. */
enum status store_read_stored(struct store_reader *reader, int level, struct post_rect rect, double *values) FURROW_CHECKED;

/* --- store_replace.c --- */

/* Makes the store at `path` complete in its file: a WAL or journal beside it goes into it first. Another file is left as it is. */
enum status store_replace_settle(const char *path, const char *named) FURROW_CHECKED;

/* --- store_create.c --- */

/* Removes PATH.part and then its journal. A journal that remained could be applied by mistake to a later PATH.part. Returns
 * false on failure; errno tells why. */
bool store_create_remove_part(const struct store *store);

/* --- store_put.c: base tiles of a store that is being made --- */

enum status store_put_begin(struct store *store) FURROW_CHECKED; /* begins a transaction */

/* --- store_open.c --- */

/* `over`: the overlay that names this store as its parent; NULL: none. `parent`: the path of the file to take for the parent in place
 * of the one that the store names; NULL: that one. The store must be an overlay then. */
enum status store_open_as(const char *path, const struct store_options *options, struct store *over, const char *parent,
			  struct store **out) FURROW_CHECKED;
/* Opens an overlay for reading, without its parent. Only rows of its own file can be read. */
enum status store_open_alone(const char *path, struct store **out) FURROW_CHECKED;
char *store_path_with(const char *path, const char *suffix);
/* Opens a store for reading, and shows the state with this hash, the present one or a pinned one. If it has neither, shows the present one. */
enum status store_open_state(const char *path, uint64_t hash, struct store **out) FURROW_CHECKED;
/* Returns the path of the file that is read: its own, links resolved, or that of its copy. */
const char *store_file_read(const struct store *store);

/* --- store_lineage.c --- */

/* Computes the hash of the state that a store shows now. */
enum status store_lineage_state(struct store *store, uint64_t *hash) FURROW_CHECKED;
/* Gathers the rows that an overlay of `under` inherits. `newest`: the revision of `under` that the overlay names. */
enum status store_lineage_make(struct store *under, int64_t newest, struct lineage *out) FURROW_CHECKED;
/* Computes the hash of the state of `under`: its base, working level, compacted soil, and the hash of every row that counts. It does
 * not tell in which file a row is. */
enum status store_lineage_hash(const struct store *under, const struct lineage *lineage, uint64_t *hash) FURROW_CHECKED;

/* --- store_overlay.c --- */

/* Opens the parent that an overlay names. STATUS_INPUT if it is not as it was when the overlay was made. */
enum status store_overlay_connect(struct store *store) FURROW_CHECKED;
/* Returns the path of the parent that an overlay names: the real path, if the file exists. NULL: out of memory. */
char *store_overlay_parent_file(const struct store *store);
/* Returns the relative path from `folder` to `file`, both real paths; the absolute one if they share no folder. NULL: out of memory. */
char *store_overlay_path_between(const char *folder, const char *file);
/* Gives store->rows what the overlay inherits. Call this when both are open. */
void store_overlay_inherit(struct store *store);
/* Sets in memory what an overlay says of its parent: its path from the overlay's folder, and its base. */
enum status store_overlay_name_parent(struct store *store, const struct store *parent) FURROW_CHECKED;
/* Returns true if both headers describe the same terrain. */
bool store_overlay_same_terrain(const struct store_meta *a, const struct store_meta *b);
/* Makes an overlay, as store_create_overlay. `state`: the hash of the state of the parent that it goes on from, the present one or a pinned
 * one; NULL: the present one. `part`: it is this part; NULL: it is none. `fill` writes rows before it is published; NULL:
 * none. */
enum status store_overlay_make(const char *path, const char *parent_path, const uint64_t *state, const struct store_part *part,
			       enum status (*fill)(struct store *store, void *user), void *user) FURROW_CHECKED;
/* Writes to a new file what lets a drive go on where `parent` is: its working level, compacted soil and run. `run`: the record, with the
 * number that the file's last commit gets. `what` made the file. In a transaction. */
enum status store_overlay_begin_as(struct store *store, const struct store *parent, const struct store_run_copy *run, const char *what)
	FURROW_CHECKED;
/* Writes to an overlay that inherits what it has of its parent at its beginning: the header's entries and the run's record. In a
 * transaction. */
enum status store_overlay_begin(struct store *store) FURROW_CHECKED;
/* Keeps what this connection reads from changing: SQLite lets nobody write the file, or shows this connection the file as it is now.
 * STATUS_INPUT: the file is not at the revision of `store` any more. */
enum status store_overlay_hold(const struct store *store, sqlite3 *db) FURROW_CHECKED;
/* Returns false if `path` cannot be the path of a file, or has characters that a message cannot show. */
bool store_overlay_path_fits(const char *path, size_t length);

#endif
