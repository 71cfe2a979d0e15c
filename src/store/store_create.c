/*
 * Makes a store. It is written as PATH.part, with commits in between (store_put.c). When it is complete, it is renamed to PATH.
 *
 *   create: PATH.part, locked -> put_base... -> publish: COMMIT, fsync, remove files beside PATH,
 *   fsync of the folder, rename, fsync of the folder
 *
 * A failure before the rename leaves PATH as it was, and close removes PATH.part. A kill or store_suspend leaves PATH.part.
 * store_resume continues with it if it was begun by the same request. A resumed PATH.part is never removed: it was there before,
 * and may be hours of work.
 */
#include "store/internal.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define COMMIT_BYTES (16 << 20)

static enum status check_meta(const char *path, const struct store_meta *meta)
{
	const char *problem = extent_problem(&meta->extent);
	if (problem != NULL)
		return fail_with(STATUS_INPUT, "%s: %s; import another size", path, problem);
	if (!(meta->step >= 0) || !isfinite(meta->step) || !isfinite(meta->max_error) ||
	    !isfinite(meta->origin[0]) || !isfinite(meta->origin[1]))
		return fail_with(STATUS_INPUT, "%s: its step, error and origin must be finite; give others", path);
	return STATUS_OK;
}

/* Finds the real path of the file. The file need not exist, but its folder must. */
static enum status resolve(const char *path, char **real)
{
	char there[PATH_MAX];
	if (realpath(path, there) != NULL) {
		return mem_text(real, there, "a store");
	}
	char *folder = mem_strdup(path), *name = mem_strdup(path);
	enum status status = STATUS_OK;
	*real = NULL;
	if (folder == NULL || name == NULL) {
		status = fail_memory("a store");
	} else if (realpath(dirname(folder), there) == NULL) {
		status = fail_with(STATUS_INPUT, "%s: cannot be made: %s; name a folder that is there", path,
				   strerror(errno));
	} else {
		size_t room = strlen(there) + strlen(path) + 2;
		*real = mem_alloc(room, 1);
		if (*real == NULL)
			status = fail_memory("a store");
		else
			snprintf(*real, room, "%s/%s", there, basename(name));
	}
	mem_free_all(folder, name);
	return status;
}

/* Finds out whether the file at PATH is a store, by SQLite's header and Furrow's application id in it. This is also true for a store
 * of another version, and for one that is damaged behind its header. */
static enum status looks_like_a_store(const struct store *store, bool *looks)
{
	static const uint8_t id[4] = {STORE_APPLICATION_ID >> 24, STORE_APPLICATION_ID >> 16 & 0xff,
				      STORE_APPLICATION_ID >> 8 & 0xff, STORE_APPLICATION_ID & 0xff};
	uint8_t header[72];
	int file = open(store->real_path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
	ssize_t length = file >= 0 ? read(file, header, sizeof header) : -1;
	int error = errno;
	if (file >= 0)
		close(file);
	if (length < 0)
		return fail_with(STATUS_FAILED, "%s: what is to be replaced cannot be read: %s; check its permissions",
				 store->path, strerror(error));
	*looks = length == 0 || (length == (ssize_t)sizeof header && memcmp(header, "SQLite format 3", 16) == 0 &&
				 memcmp(header + 68, id, sizeof id) == 0);
	return STATUS_OK;
}

/* Fails if the store at PATH, which is to be replaced, has what others need. One that cannot be opened has nothing. */
static enum status refuse_losses(const struct store *store)
{
	struct store *there = NULL;
	char text[1400];
	int64_t count = 0;
	enum status status = store_open(store->path, &(struct store_options){.mode = STORE_READ}, &there);
	if (status == STATUS_INPUT)
		return STATUS_OK;
	TRY(status);
	if (store->overwrite != STORE_OVERWRITE_FORCE)
		TRY_OR(done, store_losses_refuse(there, true));
	else if (store->part_path == NULL) /* at first, before anything is done */
		TRY_OR(done, store_losses(there, true, text, sizeof text, &count));
	if (count > 0)
		note("%s: %s; that is lost when the new store is there", store->path, text);
done:
	store_close(there);
	return status;
}

/* Fails if there is a file at PATH, unless it is a store and may be overwritten. So a wrong name never destroys a DEM, for example. */
static enum status refuse_existing(const struct store *store)
{
	struct stat file;
	if (lstat(store->real_path, &file) != 0)
		return STATUS_OK;
	if (S_ISDIR(file.st_mode))
		return fail_with(STATUS_INPUT, "%s: it is a folder, no Furrow store; name a file, as in %s/terrain.furrow", store->path, store->path);
	if (store->overwrite == STORE_OVERWRITE_NOT)
		return fail_with(STATUS_INPUT, "%s: it exists; give --overwrite to replace it, or another name",
				 store->path);
	bool looks = false;
	if (S_ISREG(file.st_mode))
		TRY(looks_like_a_store(store, &looks));
	if (looks)
		return refuse_losses(store);
	return fail_with(STATUS_INPUT, "%s: it is no Furrow store, and --overwrite replaces nothing else; give another "
			 "name, or remove it", store->path);
}

bool store_create_remove_part(const struct store *store)
{
	char journal[PATH_MAX + 16];
	int length = snprintf(journal, sizeof journal, "%s-journal", store->part_path);
	return (unlink(store->part_path) == 0 || errno == ENOENT) &&
	       (length >= (int)sizeof journal || unlink(journal) == 0 || errno == ENOENT);
}

static enum status connect_part(struct store *store)
{
	TRY(store_connect_file(store->part_path, store->path, true, &store->db));
	return store_sql_exec(store->db, store->path, "making the store",
			      "PRAGMA page_size=8192; PRAGMA auto_vacuum=INCREMENTAL; "
			      "PRAGMA journal_mode=DELETE; PRAGMA synchronous=FULL; "
			      "PRAGMA locking_mode=EXCLUSIVE; PRAGMA cache_size=-16000");
}

static enum status begin_part(struct store *store)
{
	struct stat left;
	store->keeps_part = false;
	if (store->meta.request[0] != '\0' && lstat(store->part_path, &left) == 0 && S_ISREG(left.st_mode) && left.st_size > 0)
		note("%s: an earlier import was broken off with %.3g MB done, which is thrown away; with --resume the same import goes on there", store->path,
		     (double)left.st_size / 1e6);
	if (!store_create_remove_part(store)) /* an import that was killed left it; this process has the lock, so none uses it */
		return fail_with(STATUS_FAILED, "%s: what an earlier import left beside it cannot be removed: %s; make its "
				 "folder writable", store->path, strerror(errno));
	int file = open(store->part_path, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
	if (file < 0)
		return fail_with(STATUS_FAILED, "%s: cannot be made: %s; make its folder writable", store->path,
				 strerror(errno));
	close(file);
	TRY(connect_part(store));
	TRY(store_put_begin(store));
	TRY(store_schema_create(store->db, store->path));
	return store->meta.request[0] != '\0' ? store_meta_put_request(store) : STATUS_OK;
}

/* Opens an existing PATH.part to continue with it. *resumed is false if there is none, or if it has no commit yet. */
static enum status resume_part(struct store *store, bool *resumed)
{
	struct stat file;
	*resumed = false;
	if (lstat(store->part_path, &file) != 0 || !S_ISREG(file.st_mode) || file.st_size == 0)
		return STATUS_OK;
	int64_t tables;
	TRY(connect_part(store));
	TRY(store_sql_integer(store->db, store->path, "SELECT count(*) FROM sqlite_schema", &tables));
	if (tables == 0) { /* it was killed before its first commit, and SQLite has undone the rest */
		sqlite3_close(store->db);
		store->db = NULL;
		return STATUS_OK;
	}
	bool same = false;
	int version = STORE_VERSION;
	TRY(store_schema_check(store->db, store->path, &version));
	if (version < STORE_VERSION)
		TRY(store_schema_raise(store->db, store->path, version));
	TRY(store_meta_same_request(store, &same));
	if (!same)
		return fail_with(STATUS_INPUT, "%s: what was broken off was another import (sources that have changed, "
				 "other options, another furrow); give the same again, or leave out --resume to begin anew", store->path);
	TRY(store_misfit_read(store));
	*resumed = true;
	return store_put_begin(store);
}

static enum status open_part(struct store *store, bool resume)
{
	bool resumed = false;
	store->keeps_part = resume;
	store->part_path = store_path_with(store->real_path, ".part");
	TRY_MEM(store->part_path, "a store");
	if (resume)
		TRY(resume_part(store, &resumed));
	return resumed ? STATUS_OK : begin_part(store);
}

/* Takes the lock, and begins PATH.part or goes on with it. */
static enum status begin(struct store *store, const char *path, const struct store_meta *meta, bool resume)
{
	TRY(mem_text(&store->path, path, "a store"));
	TRY(store_meta_copy(&store->meta, meta));
	TRY(resolve(path, &store->real_path));
	TRY(refuse_existing(store));
	store->lock_path = store_path_with(store->real_path, "-lock");
	TRY_MEM(store->lock_path, "a store");
	TRY(store_lock_take(store->lock_path, path, &store->lock));
	TRY(open_part(store, resume));
	return store_rows_init(&store->rows, store->db, store->path, &store->meta.extent, meta->pack == STORE_PACK_SMALL ? CODEC_SMALL : CODEC_FAST);
}

static enum status make(const char *path, const struct store_meta *meta, enum store_overwrite overwrite, bool resume,
			struct store **out)
{
	TRY(check_meta(path, meta));
	struct store *store = mem_calloc(1, sizeof *store);
	TRY_MEM(store, "a store");
	store->lock = -1;
	store->base = &store->rows;
	store_changes_begin(&store->changes);
	store->overwrite = overwrite;
	store->history.kept = store->history.label = -1;
	store->pins.newest = store->pins.label = store->shown = -1;
	store->version = STORE_VERSION;
	store_who(store->who, sizeof store->who);
	store->commit_bytes = COMMIT_BYTES;
	enum status status = begin(store, path, meta, resume);
	if (status != STATUS_OK)
		store_close(store);
	else
		*out = store;
	return status;
}

enum status store_create(const char *path, const struct store_meta *meta, enum store_overwrite overwrite, struct store **out)
{
	return make(path, meta, overwrite, false, out);
}

enum status store_resume(const char *path, const struct store_meta *meta, enum store_overwrite overwrite, struct store **out,
			 int64_t *tiles)
{
	TRY(make(path, meta, overwrite, true, out));
	enum status status = store_sql_integer((*out)->db, path, "SELECT count(*) FROM base", tiles);
	if (status != STATUS_OK) {
		store_close(*out);
		*out = NULL;
	}
	return status;
}

/* --- publishing --- */

static enum status check_whole(struct store *store)
{
	const struct extent *extent = &store->meta.extent;
	int64_t want = 0, have;
	for (int level = 0; level <= extent_coarsest(extent); level++)
		want += (int64_t)extent_tiles_x(extent, level) * extent_tiles_y(extent, level);
	char sql[64];
	uint64_t first, last;
	level_keys(0, &first, &last); /* tiles of insets may be any */
	snprintf(sql, sizeof sql, "SELECT count(*) FROM base WHERE key >= %llu", (unsigned long long)first);
	TRY(store_sql_integer(store->db, store->path, sql, &have));
	if (have != want)
		return fail_with(STATUS_FAILED, "%s: %lld of %lld tiles were made; import it again", store->path, (long long)have, (long long)want);
	return STATUS_OK;
}

static enum status take_range(struct store *store)
{
	struct row top;
	bool found;
	struct tile tile = {extent_coarsest(&store->meta.extent), 0, 0};
	TRY(store_rows_head(&store->rows, ROW_BASE, tile, &top, &found));
	assert(found);
	store->meta.low = top.low;
	store->meta.high = top.high;
	return STATUS_OK;
}

static enum status take_base(struct store *store)
{
	TRY(check_whole(store));
	TRY(take_range(store));
	return store_identity_compute(store, &store->base_hash);
}

static enum status sync_part(const struct store *store)
{
	int file = open(store->part_path, O_RDONLY | O_CLOEXEC);
	bool synced = file >= 0 && fsync(file) == 0;
	int error = errno;
	if (file >= 0)
		close(file);
	return synced ? STATUS_OK
		      : fail_with(STATUS_FAILED, "%s: cannot be synced: %s; check the disk", store->path,
				  strerror(error));
}

/* Removes files beside a store that is replaced. Otherwise they would be taken for files of the new store. */
static enum status remove_beside(const struct store *store)
{
	static const char *const suffixes[] = {"-wal", "-shm", "-journal", PINS_SUFFIX, PINS_SUFFIX "-journal"};
	TRY(store_replace_settle(store->real_path, store->path));
	for (size_t i = 0; i < sizeof suffixes / sizeof *suffixes; i++) {
		char *beside = store_path_with(store->real_path, suffixes[i]);
		TRY_MEM(beside, "a store");
		bool removed = unlink(beside) == 0 || errno == ENOENT;
		int error = errno;
		mem_free(beside);
		if (!removed)
			return fail_with(STATUS_FAILED, "%s: its %s file cannot be removed: %s; remove it", store->path, suffixes[i], strerror(error));
	}
	return STATUS_OK;
}

/* Renames PATH.part to PATH. base/aside is not used, since a suspended or resumed PATH.part must stay, and since removing it also
 * removes its journal.
 *
 * The folder is synced before the rename, so that no power cut brings back files of the older store. It is synced again after the
 * rename. Once the rename is done, only this last sync can fail. */
static enum status rename_part(struct store *store, int folder)
{
	TRY(refuse_existing(store));
	TRY(remove_beside(store));
	if (fsync(folder) != 0)
		return fail_with(STATUS_FAILED, "%s: its folder cannot be synced: %s; check the disk", store->path,
				 strerror(errno));
	if (rename(store->part_path, store->real_path) != 0)
		return fail_with(STATUS_FAILED, "%s: cannot be renamed into place: %s; make its folder writable",
				 store->path, strerror(errno));
	(void)store_create_remove_part(store); /* SQLite may leave its journal where a sync failed */
	mem_free(store->part_path);
	store->part_path = NULL;
	if (fsync(folder) != 0)
		return fail_with(STATUS_FAILED, "%s: is in place, but its folder cannot be synced: %s; check the disk, "
				 "a power cut may undo it", store->path, strerror(errno));
	return STATUS_OK;
}

static enum status put_in_place(struct store *store)
{
	char *path = mem_strdup(store->real_path);
	TRY_MEM(path, "a store");
	int folder = open(dirname(path), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
	int error = errno;
	mem_free(path);
	if (folder < 0)
		return fail_with(STATUS_FAILED, "%s: its folder cannot be opened: %s; make it readable", store->path,
				 strerror(error));
	enum status status = rename_part(store, folder);
	close(folder);
	return status;
}

enum status store_publish(struct store *store)
{
	assert(store->part_path != NULL);
	/* The description of an overlay's base was written when the overlay was made. */
	if (store->base_path == NULL)
		TRY(take_base(store));
	TRY(store_meta_write(store));
	TRY(store_sql_exec(store->db, store->path, "writing it", "COMMIT"));
	store_rows_finish(&store->rows);
	sqlite3_finalize(store->meta_statement);
	sqlite3_finalize(store->run_statement);
	store->meta_statement = store->run_statement = NULL;
	int code = sqlite3_close(store->db);
	store->db = NULL;
	assert(code == SQLITE_OK);
	(void)code;
	TRY(sync_part(store));
	return put_in_place(store);
}
