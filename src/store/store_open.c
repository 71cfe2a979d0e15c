/*
 * Opens and closes stores.
 *
 *   published: one file, rollback journal mode
 *     --open for writing--> lock taken --at once, or store_begin if it was opened late--> WAL
 *     --close--> checkpoint, rollback mode again, one file; lock released
 *
 * Until then nothing of the file changes: a store that was opened late, and was not begun, has the bytes that it had.
 *
 * A killed writer leaves FILE, FILE-wal and FILE-shm. The next process that opens the store, for reading or writing, sees its last
 * complete commit.
 */
#include "store/internal.h"

#include <assert.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/limits.h"

char *store_path_with(const char *path, const char *suffix)
{
	size_t room = strlen(path) + strlen(suffix) + 1;
	char *with = mem_alloc(room, 1);
	if (with != NULL)
		snprintf(with, room, "%s%s", path, suffix);
	return with;
}

static enum status find_file(struct store *store)
{
	char real[PATH_MAX];
	struct stat file;
	if (realpath(store->path, real) == NULL || stat(real, &file) != 0)
		return fail_with(STATUS_INPUT, "%s: %s; check the path, or make one with furrow import", store->path,
				 strerror(errno));
	if (!S_ISREG(file.st_mode))
		return fail_with(STATUS_INPUT, "%s: not a file; name a store", store->path);
	if (file.st_size == 0)
		return fail_with(STATUS_INPUT, "%s: it is empty, not a Furrow store; make one with furrow import",
				 store->path);
	store->real_path = mem_strdup(real);
	store->lock_path = store_path_with(real, "-lock");
	return store->real_path != NULL && store->lock_path != NULL ? STATUS_OK : fail_memory("a store");
}

/* Finds out whether a copy is read in place of this file. Messages name the copy then. */
static enum status find_copy(struct store *store)
{
	if (store->over == NULL || store->staged == NULL || strcmp(store->real_path, store->staged->original) != 0)
		return STATUS_OK;
	store->copied_from = store->path;
	return mem_text(&store->path, store->staged->copy, "a store");
}

const char *store_file_read(const struct store *store)
{
	return store->copied_from != NULL ? store->path : store->real_path;
}

/* SQLite counts a last page that is there in part. Within a transaction: nobody shortens it now. */
static enum status check_length(struct store *store)
{
	int64_t pages, size;
	struct stat file = {0};
	TRY(store_sql_exec(store->db, store->path, "opening it", "BEGIN"));
	enum status status;
	TRY_OR(done, store_sql_integer(store->db, store->path, "PRAGMA page_count", &pages));
	TRY_OR(done, store_sql_integer(store->db, store->path, "PRAGMA page_size", &size));
	const char *path = store_file_read(store);
	if (!store_connect_has_wal(path) && (stat(path, &file) != 0 || file.st_size < pages * size))
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: it was cut short: %lld bytes of %lld; restore or import it again",
				       store->path, (long long)file.st_size, (long long)(pages * size)));
done:
	sqlite3_exec(store->db, "ROLLBACK", NULL, NULL, NULL); /* only read */
	return status;
}

/* Makes a store of an earlier version usable. Tells once what this loses. */
static enum status adapt(struct store *store, bool writing, int version)
{
	int64_t sheared = 0, ruts = 0;
	if (version < STORE_VERSION_SHEAR)
		TRY(store_sql_integer(store->db, store->path, "SELECT EXISTS (SELECT 1 FROM shear)", &sheared));
	if (version < STORE_VERSION_LOOSE)
		TRY(store_sql_integer(store->db, store->path, "SELECT EXISTS (SELECT 1 FROM heaped) AND EXISTS (SELECT 1 FROM pressed)", &ruts));
	TRY(writing ? store_schema_raise(store->db, store->path, version) : store_schema_hide(store->db, store->path, version));
	if ((sheared != 0 || ruts != 0) && store->wanted == NULL && (store->over == NULL || store->over->inherits))
		note("%s: an older furrow drove there; its ruts stay, what lies deposited on them counts as loose%s%s", store->path,
		     sheared != 0 ? ", its shear counts as none" : "", writing ? ", and older furrows cannot read the store any more" : "");
	store->older = !writing;
	return STATUS_OK;
}

/* Makes this process the only writer. */
static enum status lock(struct store *store)
{
	if (access(store->real_path, W_OK) != 0)
		return fail_with(STATUS_FAILED, "%s: cannot be written: %s; %s", store->path, strerror(errno),
				 limits_advice(errno, "make the file writable, or only look at it (readonly)"));
	store->lock_was_there = access(store->lock_path, F_OK) == 0;
	return store_lock_take(store->lock_path, store->path, &store->lock);
}

/* The level is in the upper bits of a key, so the lowest key has the finest level. */
static enum status find_finest_base(struct store *store)
{
	int64_t key;
	if (store->under != NULL) {
		store->finest_base = store->under->finest_base;
		return STATUS_OK;
	}
	TRY(store_sql_integer(store->db, store->path, "SELECT coalesce(min(key), 0) FROM base", &key));
	const int level = key > 0 ? tile_from_key((uint64_t)key).level : 0;
	store->finest_base = level > 0 ? 0 : level < TILE_LEVEL_MIN ? TILE_LEVEL_MIN : level;
	return STATUS_OK;
}

/* What an overlay depends on is shown, if the store has gone on since and keeps it. */
static enum status show_pinned(struct store *store)
{
	const uint64_t *wanted = store->wanted;
	int64_t present = 0, commit = -1;
	if (wanted == NULL && store->over != NULL && store->over->inherits) {
		wanted = &store->over->parent_hash;
		commit = store->over->parent_revision;
	}
	if (wanted == NULL)
		return STATUS_OK;
	TRY(store_pinned_find(store, *wanted, &store->shown));
	if (store->shown < 0)
		return STATUS_OK;
	TRY(store_sql_integer(store->db, store->path, "SELECT coalesce(max(epoch), 0) FROM main.run", &present));
	if (store->shown == present || commit == present) {
		store->shown = -1;
		return STATUS_OK;
	}
	return store_pinned_show(store->db, store->path, store->shown);
}

/* Connects the file, and reads what it says of itself. */
static enum status connect(struct store *store, const struct store_options *options, int *version)
{
	TRY(find_file(store));
	TRY(find_copy(store));
	if (options->mode == STORE_WRITE)
		TRY(lock(store));
	if (options->mode == STORE_WRITE && !options->late)
		TRY(store_connect_file(store->real_path, store->path, true, &store->db));
	else
		TRY(store_connect_reader(store_file_read(store), store->path, &(struct store_frozen){.is = false}, &store->db));
	TRY(store_schema_check(store->db, store->path, version));
	store->version = *version;
	TRY(check_length(store));
	TRY(show_pinned(store));
	return store_meta_read(store);
}

/* Tells whether what these options keep fits together, and what a part keeps in any case. */
static enum status settle_history(struct store *store, const struct store_options *options)
{
	int64_t named = 0;
	store->history.each = options->keep_history;
	store->history.last = options->keep_last || store->part.count > 0;
	if (options->mode != STORE_WRITE || !store->history.last)
		return STATUS_OK;
	if (store->history.each)
		return fail_with(STATUS_USAGE, "%s: it cannot keep every revision and only the last one; leave out one of them", store->path);
	TRY(store_sql_integer(store->db, store->path, "SELECT count(*) FROM snapshot", &named));
	if (named > 0)
		return fail_with(STATUS_INPUT, "%s: it keeps revisions that have names, and a commit that keeps only the last one would drop "
				 "them; drive an overlay of it", store->path);
	return STATUS_OK;
}

/* Connects the file and those under it, and reads what is kept of them in memory. */
static enum status take_all(struct store *store, const struct store_options *options)
{
	const bool begins = options->mode == STORE_WRITE && !options->late;
	int version = STORE_VERSION;
	if (store->path == NULL || (options->scene != NULL && store->scene == NULL))
		return fail_memory("a store");
	TRY(connect(store, options, &version));
	if (store->parent_given != NULL && store->base_path == NULL)
		return fail_with(STATUS_INPUT, "%s: it is a store of its own, not an overlay, so it has no base to name; name an overlay", store->path);
	if (store->base_path != NULL && !store->alone)
		TRY(store_overlay_connect(store));
	if (version < STORE_VERSION)
		TRY(adapt(store, begins, version));
	TRY(find_finest_base(store));
	TRY(store_imagery_open(store));
	if (begins)
		TRY(store_wal_begin(store));
	store->writing = options->mode == STORE_WRITE;
	store->late = store->writing && options->late;
	TRY(store_rows_init(&store->rows, store->db, store->path, &store->meta.extent, store->meta.pack == STORE_PACK_SMALL ? CODEC_SMALL : CODEC_FAST));
	if (!store->alone)
		store_overlay_inherit(store);
	TRY(store_history_open(store));
	TRY(store_pinned_open(store));
	TRY(settle_history(store, options));
	/* What an opening reads is not counted, in the files under it neither. */
	for (struct store *under = store->under; under != NULL; under = under->under)
		store_statements_restart(&under->statements);
	store_statements_count(&store->statements, store->db);
	store_changes_restart(&store->changes, store->commit);
	return STATUS_OK;
}

static enum status open_it(const char *path, const struct store_options *options, struct store *over, const char *parent, bool alone,
			   const uint64_t *wanted, struct store **out)
{
	struct store *store = mem_calloc(1, sizeof *store);
	TRY_MEM(store, "a store");
	store->lock = -1;
	store->base = &store->rows;
	store->over = over;
	store->parent_given = parent;
	store->staged = options->staged;
	store->alone = alone;
	store->wanted = wanted;
	store->shown = -1;
	store_changes_begin(&store->changes);
	store->durable_full = options->durable_full;
	store_who(store->who, sizeof store->who);
	store->path = mem_strdup(path);
	store->scene = options->scene != NULL ? mem_strdup(options->scene) : NULL;
	enum status status = take_all(store, options);
	store->staged = NULL;
	store->wanted = NULL;
	if (status != STATUS_OK)
		store_close(store);
	else
		*out = store;
	return status;
}

enum status store_open_as(const char *path, const struct store_options *options, struct store *over, const char *parent,
			  struct store **out)
{
	return open_it(path, options, over, parent, false, NULL, out);
}

enum status store_open_alone(const char *path, struct store **out)
{
	return open_it(path, &(struct store_options){.mode = STORE_READ}, NULL, NULL, true, NULL, out);
}

enum status store_open_state(const char *path, uint64_t hash, struct store **out)
{
	return open_it(path, &(struct store_options){.mode = STORE_READ}, NULL, NULL, false, &hash, out);
}

enum status store_open(const char *path, const struct store_options *options, struct store **out)
{
	return store_open_as(path, options, NULL, NULL, out);
}

/* --- the first change --- */

/* Makes the connection that writes. */
static enum status connect_begun(struct store *store, sqlite3 **db)
{
	int version = STORE_VERSION;
	TRY(store_connect_file(store->real_path, store->path, true, db));
	TRY(store_schema_check(*db, store->path, &version));
	store->version = version;
	if (version >= STORE_VERSION)
		return STATUS_OK;
	TRY(store_schema_raise(*db, store->path, version));
	atomic_store(&store->raised, true);
	if (store->working_stored)
		note("%s: it is a store of this version from now on; older furrows cannot read it any more", store->path);
	return STATUS_OK;
}

enum status store_begin(struct store *store)
{
	struct rows rows = {0};
	sqlite3 *db = NULL, *reading = store->db;
	enum status status;
	if (!store->late)
		return STATUS_OK;
	assert(store->writing);
	/* The name may be another file's by now. */
	TRY(store_place_check(store));
	TRY_OR(failed, connect_begun(store, &db));
	TRY_OR(failed, store_rows_init(&rows, db, store->path, &store->meta.extent, store->meta.pack == STORE_PACK_SMALL ? CODEC_SMALL : CODEC_FAST));
	store->db = db;
	TRY_OR(failed, store_wal_begin(store));
	store_rows_finish(&store->rows);
	store_history_finish(store);
	sqlite3_finalize(store->run_statement);
	sqlite3_finalize(store->meta_statement);
	store->run_statement = store->meta_statement = NULL;
	store->rows = rows;
	if (!store->alone)
		store_overlay_inherit(store);
	sqlite3_close(reading);
	store_statements_count(&store->statements, db);
	store->late = false;
	return STATUS_OK;
failed:
	store->db = reading;
	store_rows_finish(&rows);
	sqlite3_close(db);
	return status;
}

/* --- closing --- */

/* Back to one file. Where that fails (another process reads it) everything is in the WAL still. */
static void end_writing(struct store *store)
{
	sqlite3_busy_timeout(store->db, 100);
	sqlite3_wal_checkpoint_v2(store->db, NULL, SQLITE_CHECKPOINT_TRUNCATE, NULL, NULL);
	sqlite3_exec(store->db, "PRAGMA journal_mode=DELETE", NULL, NULL, NULL);
}

static void close_store(struct store *store, bool remove)
{
	if (store == NULL)
		return;
	store_close(store->under);
	store_rows_finish(&store->rows);
	store_lineage_finish(&store->lineage);
	store_history_finish(store);
	store_pinned_finish(store);
	store_undo_destroy(store->undo);
	store_changes_finish(&store->changes);
	sqlite3_finalize(store->run_statement);
	sqlite3_finalize(store->meta_statement);
	if (store->writing && !store->late)
		end_writing(store);
	int code = sqlite3_close(store->db);
	assert(code == SQLITE_OK);
	(void)code;
	if (store->part_path != NULL && store->lock >= 0 && !store->keeps_part)
		store_create_remove_part(store);
	if (remove)
		unlink(store->real_path);
	store_lock_drop(store->late && store->lock_was_there ? NULL : store->lock_path, store->lock);
	store_meta_finish(&store->meta);
	store_run_copy_finish(&store->last_run);
	mem_free_all(store->path, store->copied_from, store->real_path, store->part_path, store->lock_path, store->base_path,
		     store->relief_text, store->scene, store);
}

void store_forked(const struct store *store)
{
	if (store->lock >= 0)
		close(store->lock);
}

void store_close(struct store *store)
{
	close_store(store, store != NULL && store->made && store->late);
}

void store_abandon(struct store *store)
{
	bool remove = store != NULL && store->made && (store->late || store->commit == 0);
	if (remove)
		store_pins_withdraw(store);
	close_store(store, remove);
}

/* --- what it is --- */

const struct store_meta *store_meta(const struct store *store)
{
	return &store->meta;
}

int store_finest(const struct store *store)
{
	return store->has_working && store->working < store->finest_base ? store->working : store->finest_base;
}

int store_finest_base(const struct store *store)
{
	return store->finest_base;
}

bool store_has_working_level(const struct store *store, int *level)
{
	if (store->has_working && level != NULL)
		*level = store->working;
	return store->has_working;
}

enum status store_set_working_level(struct store *store, int level)
{
	const struct extent *extent = &store->meta.extent;
	const struct store *first = store; /* whose ruts those of overlays are over */
	while (first->under != NULL && first->under->has_working)
		first = first->under;
	if (level < TILE_LEVEL_MIN || level > extent_coarsest(extent))
		return fail_with(STATUS_INPUT, "%s: level %d cannot be deformed; give one from %d to %d", store->path,
				 level, TILE_LEVEL_MIN, extent_coarsest(extent));
	if (store->has_working && store->working != level)
		return fail_with(STATUS_INPUT, "%s: it is deformed at a spacing of %s m, not %s m; use that spacing, "
				 "or furrow reset %s", first->path, number_exact(extent_spacing(extent, store->working)).text,
				 number_exact(extent_spacing(extent, level)).text, shell_path(first->path).text);
	if (store->history.has_level && store->history.level != level)
		return fail_with(STATUS_INPUT, "%s: its history is of ground that was deformed at a spacing of %s m, not %s m; use that spacing, or "
				 "furrow reset %s", store->path, number_exact(extent_spacing(extent, store->history.level)).text,
				 number_exact(extent_spacing(extent, level)).text, shell_path(store->path).text);
	store->has_working = true;
	store->working = level;
	return STATUS_OK;
}
