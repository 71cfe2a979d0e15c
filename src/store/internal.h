/* What the files of this folder share: the connection, the rows, and small helpers over SQLite. */
#ifndef FURROW_STORE_INTERNAL_H
#define FURROW_STORE_INTERNAL_H

#include <sqlite3.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "store/changes.h"
#include "store/codec.h"
#include "store/store.h"

#define STORE_APPLICATION_ID 0x46757277 /* "Furw" */
#define STORE_VERSION 3
#define STORE_BUSY_MS 5000

/* store_commit.c: STATUS_INTERRUPTED if run->given_up says that the commit is given up. */
enum status store_commit_goes_on(const struct store *store, const struct store_run *run) FURROW_CHECKED;

/* --- store_sql.c: SQLite with messages --- */

/* A failed call on `db`, told: what was being done to the store at `path`. Never STATUS_OK. */
enum status store_sql_fail(sqlite3 *db, int code, const char *path, const char *doing);
enum status store_sql_exec(sqlite3 *db, const char *path, const char *doing, const char *sql) FURROW_CHECKED;
/* A transaction that writes; one that could not be undone for want of memory is undone first. */
enum status store_sql_begin(sqlite3 *db, const char *path, const char *doing) FURROW_CHECKED;
/* Undoes the transaction, unless what failed did so already. The message stays the failure's. */
void store_sql_undo(sqlite3 *db);
/* Prepares *statement unless that was done before. */
enum status store_sql_prepare(sqlite3 *db, const char *path, sqlite3_stmt **statement, const char *sql)
	FURROW_CHECKED;
/* First column of the first row. */
enum status store_sql_integer(sqlite3 *db, const char *path, const char *sql, int64_t *value) FURROW_CHECKED;

/* --- store_rows.c: the tables of tiles, a row at a time --- */

/* The base's, and one for each plane. */
enum row_table { ROW_BASE, ROW_OFFSET, ROW_DISTURBANCE, ROW_DEPOSITED, ROW_PLASTIC_SINKAGE, ROW_SHEAR, ROW_TABLES };

static inline enum row_table row_table_of(enum plane plane)
{
	return (enum row_table)(ROW_OFFSET + (int)plane);
}

/* Not for the base. */
static inline enum plane row_plane(enum row_table table)
{
	return (enum plane)(table - ROW_OFFSET);
}

/* The soil's state: of the working level alone, without a pyramid. */
static inline bool row_is_state(enum row_table table)
{
	return table >= ROW_DEPOSITED;
}

struct row {
	struct tile tile;
	double low, high; /* metres (disturbance: as it is); NaN both: nothing but nodata */
	double error;     /* metres; base only */
	int64_t codec;    /* not yet checked */
	int64_t revision; /* the commit that wrote it, 0: import */
	uint64_t hash;
	int64_t below, above; /* fixed-point units, own sums; offset only */
	const void *bytes;    /* until the next use of the table */
	size_t size;
};

/* A connection's statements and scratch. One thread. */
struct rows {
	sqlite3 *db;
	const char *path;         /* the store's */
	const struct extent *extent;
	struct codec codec;
	int32_t *wide;            /* (cells + 1)^2 */
	sqlite3_stmt *find[ROW_TABLES], *head[ROW_TABLES], *write[ROW_TABLES], *drop[ROW_TABLES],
		*under[ROW_TABLES];
};

enum status store_rows_init(struct rows *rows, sqlite3 *db, const char *path, const struct extent *extent,
		      enum codec_effort effort) FURROW_CHECKED;
void store_rows_finish(struct rows *rows); /* before the connection is closed */

const char *store_rows_name(enum row_table table);
const char *store_rows_sql_name(enum row_table table); /* quoted where it must be */
/* "store.furrow: base tile level 1 x 2 y 3" into text. */
void store_rows_text(const struct rows *rows, enum row_table table, struct tile tile, char *text, size_t room);
/* Everything but the blob; checked for sense. */
enum status store_rows_head(struct rows *rows, enum row_table table, struct tile tile, struct row *row,
		      bool *found) FURROW_CHECKED;
/* The row and its posts, its hash checked. Not found: posts are untouched. */
enum status store_rows_read(struct rows *rows, enum row_table table, struct tile tile, int32_t *posts,
		      struct row *row, bool *found) FURROW_CHECKED;
/* Encodes the posts into the row: codec, hash, bytes and size are filled. */
void store_rows_encode(struct rows *rows, enum row_table table, const int32_t *posts, struct row *row);
/* Writes a row whose posts were encoded before. */
enum status store_rows_put(struct rows *rows, enum row_table table, const struct row *row) FURROW_CHECKED;
enum status store_rows_drop(struct rows *rows, enum row_table table, struct tile tile) FURROW_CHECKED;
/* The row, which is there, from one connection to another, its hash checked and with this revision. */
enum status store_rows_copy(struct rows *from, struct rows *to, enum row_table table, struct tile tile, int64_t revision)
	FURROW_CHECKED;
/* Range over the rows of the next finer level below `tile`, and how many there are. */
enum status store_rows_under(struct rows *rows, enum row_table table, struct tile tile, double *low,
		       double *high, int *count) FURROW_CHECKED;
uint64_t store_rows_hash(enum row_table table, const struct row *row);

/* A post in metres (disturbance: as it is). */
double store_rows_metres(enum row_table table, int32_t post, double step);
/* Range in metres (disturbance: as it is) of a plane's own posts; NaN if all are nodata. */
void store_rows_range(enum row_table table, const int32_t *posts, size_t count, double step, double *low,
		double *high);
bool store_rows_all_zero(const int32_t *posts, size_t count);
/* Sums of a tile's own offsets below and above zero. The last row and column do not count, unless it is the world's last tile
 * in that direction. */
void store_rows_sums(const struct extent *extent, struct tile tile, const int32_t *posts, int64_t *below,
	       int64_t *above);

/* --- store_statements.c: what was executed, by table --- */

struct statements {
	atomic_uint_fast64_t read[STORE_TABLES], written[STORE_TABLES];
};
/* From now on those of this connection count there. */
void store_statements_count(struct statements *statements, sqlite3 *db);

/* --- store_run.c: the run's record --- */

struct store_run_copy {
	bool found;
	int64_t commit, step;
	double time;
	char *scene_hash, *state; /* its own */
};
/* What the file has now, into what an earlier call filled, or zeros. */
enum status store_run_copy(struct store *store, struct store_run_copy *copy) FURROW_CHECKED;
void store_run_copy_finish(struct store_run_copy *copy);
/* As that of the next commit, with this text. */
enum status store_run_put(struct store *store, const struct store_run *run, const char *state) FURROW_CHECKED;
/* The same, of a copy; none where that found none. */
enum status store_run_put_back(struct store *store, const struct store_run_copy *copy) FURROW_CHECKED;

/* --- store_undo.c: marks and rollbacks --- */

/* What a rollback needs, in a database of its own without a name. SQLite keeps it in memory; above a few MB it uses a file that
 * it has unlinked. So the store's file gets no more tables, and a kill leaves nothing to clean up. */
struct undo {
	struct rows rows; /* of its connection; without a codec */
	int64_t kept;     /* how many */
	/* The store at the mark: */
	int64_t commit; /* or of the last rollback to it */
	bool working_stored, has_compacted;
	int64_t compacted;
	struct store_run_copy run;
};

/* Before a row changes in a commit: the undo of the last mark has what it was then. `had`: it is there. */
enum status store_undo_keep(struct store *store, enum plane plane, struct tile tile, bool had) FURROW_CHECKED;
void store_undo_destroy(struct undo *undo); /* takes NULL */

/* --- the store --- */

/* Whether a table of the soil's state has rows. */
enum state_rows { STATE_UNKNOWN, STATE_NONE, STATE_MAYBE };

struct store {
	char *path;      /* as named in messages */
	char *real_path; /* the file itself */
	char *part_path; /* being written; NULL once published or if only opened */
	char *lock_path;
	int lock;        /* descriptor, -1: none */
	bool overwrite;
	bool keeps_part; /* closing leaves PATH.part */
	bool writing;    /* opened for writing */
	bool immutable;  /* a WAL store without its WAL where nothing can be made beside it */
	bool durable_full;
	int64_t commit_bytes; /* creating: a commit after so many */
	int64_t uncommitted;  /* put since the last commit, at `committed` seconds */
	double committed;
	sqlite3 *db;
	struct rows rows;
	char *base_path;    /* an overlay's: as stored, from its folder; NULL: a plain store */
	struct store *under; /* an overlay's base, open for reading; NULL: a plain store */
	struct rows *base;  /* where base tiles are: `rows`, or those of `under` */
	bool made;          /* an overlay that this opening made */
	struct store_meta meta; /* its texts are the store's own */
	int32_t code_low, code_high; /* of the meta's low and high; low > high: all nodata */
	bool has_working, working_stored;
	int working;
	int64_t compacted; /* writing: as of the last commit */
	enum state_rows state_rows[ROW_TABLES]; /* writing: by table of the soil's state */
	uint64_t base_hash; /* store_identity.c */
	int64_t commit; /* the last one committed */
	bool marked;       /* the undo is of a mark that holds */
	struct undo *undo; /* NULL: never marked */
	struct changes changes; /* store_changes.c */
	int64_t frame_bytes;  /* of the WAL: a page with its head */
	int64_t wal_bytes;    /* in use after the last commit */
	int64_t wal_patience; /* from this on a checkpoint waits for readers */
	sqlite3_stmt *run_statement, *meta_statement;
	struct statements statements; /* of this connection and of readers' */
	struct store_run_copy last_run; /* given out by store_last_run() */
};

struct store_reader {
	struct store *store;
	sqlite3 *db, *base_db; /* base_db: of an overlay's base, NULL for a plain store */
	struct rows rows, base_rows;
	struct rows *base; /* `rows` or `base_rows` */
};

/* The rows of `table`: an overlay's base tiles are in another file. */
static inline struct rows *store_table(struct store *store, enum row_table table)
{
	return table == ROW_BASE ? store->base : &store->rows;
}

/* Keys of a level's tiles: the level is a key's upper bits. */
static inline void level_keys(int level, uint64_t *first, uint64_t *last)
{
	*first = tile_key((struct tile){level, 0, 0});
	*last = *first | (((uint64_t)1 << 56) - 1);
}

/* --- store_connect.c --- */

enum status store_connect_file(const char *path, const char *named, bool writing, bool immutable, sqlite3 **db)
	FURROW_CHECKED;
/* A reader's: undoes what a journal says, and falls back on `immutable` where that is safe, and says so. */
enum status store_connect_reader(const char *path, const char *named, bool *immutable, sqlite3 **db)
	FURROW_CHECKED;
/* True if pages may be beside the file. `path` is a real one. */
bool store_connect_has_wal(const char *path);
bool store_connect_has_journal(const char *path); /* a change to be undone may be */

/* --- store_wal.c --- */

/* Only once the schema is known to be a store's. */
enum status store_wal_begin(struct store *store) FURROW_CHECKED;

/* --- store_schema.c --- */

enum status store_schema_create(sqlite3 *db, const char *path) FURROW_CHECKED;
/* STATUS_INPUT unless application_id, user_version and every object are what this program makes. */
enum status store_schema_check(sqlite3 *db, const char *path) FURROW_CHECKED;

/* --- store_meta.c --- */

enum status store_meta_copy(struct store_meta *to, const struct store_meta *from) FURROW_CHECKED;
void store_meta_finish(struct store_meta *meta);
enum status store_meta_write(struct store *store) FURROW_CHECKED;
enum status store_meta_read(struct store *store) FURROW_CHECKED; /* also the working level and the commit */
/* The request from which a store is made. It is written when the store is begun. It is compared when making the store is resumed,
 * even if only the renaming is missing. *same false: the file has another request, or none. */
enum status store_meta_put_request(struct store *store) FURROW_CHECKED;
enum status store_meta_same_request(struct store *store, bool *same) FURROW_CHECKED;
enum status store_meta_put_integer(struct store *store, const char *key, int64_t value) FURROW_CHECKED;
enum status store_meta_put_real(struct store *store, const char *key, double value) FURROW_CHECKED;
enum status store_meta_drop(struct store *store, const char *key) FURROW_CHECKED;
/* The base's hash as a connection's file has it. */
enum status store_meta_base_hash(sqlite3 *db, const char *path, uint64_t *hash) FURROW_CHECKED;
/* What a commit adds; store->compacted stays as it was. */
enum status store_meta_add_compacted(struct store *store, int64_t more) FURROW_CHECKED;
/* Soil compacted so far, as the file has it now: 2^-20 m, summed over posts. */
enum status store_meta_compacted(sqlite3 *db, const char *path, int64_t *compacted) FURROW_CHECKED;
/* The working level as the file has it now. */
enum status store_meta_working(sqlite3 *db, const char *path, const struct extent *extent, bool *has, int *level)
	FURROW_CHECKED;

/* --- store_hash.c: what all hashes over numbers and texts share --- */

struct XXH3_state_s;
void store_hash_words(struct XXH3_state_s *state, const uint64_t *words, size_t count);
void store_hash_text(struct XXH3_state_s *state, const char *text);
uint64_t store_hash_real(double value); /* its bits; NaN: 0 */

/* --- store_identity.c: which base a store has --- */

/* From what the base's tables hold; the store's meta must be complete. */
enum status store_identity_compute(struct store *store, uint64_t *hash) FURROW_CHECKED;

/* --- store_change.c: a commit's rows --- */

/* The row becomes `posts`, with the range and sums in *row; `old`: what is there, NULL: nothing. Counts what it does. */
enum status store_change_write(struct store *store, enum row_table table, const int32_t *posts, struct row *row,
			 const struct row *old, struct store_commit_result *result) FURROW_CHECKED;
/* Removes the row; `old` is what is there. */
enum status store_change_drop(struct store *store, enum row_table table, const struct row *old,
			struct store_commit_result *result) FURROW_CHECKED;

/* --- store_state.c: the soil's state in a commit --- */

/* One plane of it: written where pages have it; where they have not, dropped. A table that no page has rows for,
 * and that has none, is not touched. */
enum status store_state_put(struct store *store, enum row_table table, const struct store_page *pages, size_t count,
			    const struct store_run *run, struct store_commit_result *result) FURROW_CHECKED;

/* --- store_lock.c: one writer --- */

enum status store_lock_take(const char *lock_path, const char *named, int *descriptor) FURROW_CHECKED;
void store_lock_drop(const char *lock_path, int descriptor); /* and removes the file */

/* --- store_replace.c --- */

/* The file at `path`, if it is a store, holds all of it afterwards: nothing that matters is beside it. */
enum status store_replace_settle(const char *path, const char *named) FURROW_CHECKED;

/* --- store_create.c --- */

/* PATH.part and, after it, its journal: alone that undoes nothing, and would be taken for a later part's.
 * False: errno says why. */
bool store_create_remove_part(const struct store *store);

/* --- store_put.c: base tiles of a store that is being made --- */

enum status store_put_begin(struct store *store) FURROW_CHECKED; /* a transaction */

/* --- store_open.c --- */

/* `as_base`: for an overlay; one that is an overlay itself is refused. */
enum status store_open_as(const char *path, const struct store_options *options, bool as_base,
			  struct store **out) FURROW_CHECKED;
char *store_path_with(const char *path, const char *suffix);

/* --- store_overlay.c --- */

/* Opens the base that `store` names, and sees that it is that base. */
enum status store_overlay_connect(struct store *store) FURROW_CHECKED;
/* False: no file's path, or one that no message could show. */
bool store_overlay_path_fits(const char *path, size_t length);

#endif
