/*
 * Stages a base: a copy of it on a faster disk, from which tiles are read in place of the original.
 *
 *   absent --store_copy--> PATH.part --published--> there --checked--> used, by this run and by later ones
 *
 * The copy's name has a hash of what the original shows, so that it belongs to one state of one base. Overlays go on naming the original:
 * only the path of the file that is read differs (store_open.c).
 *
 * Invariants:
 *   1. A copy that is used has the base and the ruts of the original. Its name has the hash of both. Its base rows and its ruts have that
 *      hash, and each row has its own.
 *      It has no imagery: no run reads that.
 *   2. A file that is there and is not that copy is never replaced.
 */
#include "store/internal.h"

#include <errno.h>
#include <inttypes.h>
#include <libgen.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#define SUFFIX ".furrow"
#define WAIT_NS 50000000 /* between two looks at the lock of a process that makes the copy */

static const struct store_options reading = {.mode = STORE_READ};

/* --- names --- */

/* FOLDER/NAME-HASH.furrow */
static char *copy_name(const char *folder, const char *original, uint64_t state)
{
	char *whole = mem_strdup(original);
	if (whole == NULL)
		return NULL;
	char *name = basename(whole);
	size_t length = strlen(name);
	if (length > strlen(SUFFIX) && strcmp(name + length - strlen(SUFFIX), SUFFIX) == 0)
		length -= strlen(SUFFIX);
	const size_t room = strlen(folder) + length + sizeof "/-0123456789abcdef" SUFFIX;
	char *path = mem_alloc(room, 1);
	if (path != NULL)
		snprintf(path, room, "%s/%.*s-%016" PRIx64 SUFFIX, folder, (int)length, name, state);
	mem_free(whole);
	return path;
}

static enum status name_copy(struct store *store, const char *folder, struct store_staged *out)
{
	struct store *plain = store;
	while (plain->under != NULL)
		plain = plain->under;
	TRY(store_lineage_state(plain, &out->state));
	out->original = mem_strdup(plain->real_path);
	out->copy = copy_name(folder, plain->real_path, out->state);
	return out->original != NULL && out->copy != NULL ? STATUS_OK : fail_memory("a base's copy");
}

enum status store_stage_name(const char *path, const char *folder, struct store_staged *out)
{
	struct store *store = NULL;
	*out = (struct store_staged){.original = NULL};
	TRY(store_open(path, &reading, &store));
	enum status status = name_copy(store, folder, out);
	store_close(store);
	if (status != STATUS_OK)
		store_staged_finish(out);
	return status;
}

void store_staged_finish(struct store_staged *staged)
{
	mem_free_all(staged->original, staged->copy);
	*staged = (struct store_staged){.original = NULL};
}

/* --- a copy that is there --- */

struct checking {
	struct rows *rows;
	enum row_table table;
	int64_t done, total;
	store_progress_fn progress;
	void *user;
};

static enum status has_bytes(void *user, const struct row *row)
{
	const struct checking *checking = user;
	return row != NULL ? STATUS_OK : fail_with(STATUS_INPUT, "%s: it lists a row that cannot be found", checking->rows->path);
}

static enum status check_row(void *user, const struct row_entry *entry)
{
	struct checking *checking = user;
	TRY(store_rows_bytes(checking->rows, checking->table, tile_from_key(entry->key), has_bytes, checking));
	checking->done++;
	if (checking->progress != NULL)
		TRY(checking->progress(checking->user, checking->done, checking->total));
	return STATUS_OK;
}

static enum status check_rows(struct store *copy, store_progress_fn progress, void *user)
{
	struct checking checking = {.rows = &copy->rows, .progress = progress, .user = user};
	for (int table = 0; table < ROW_TABLES; table++) {
		int64_t rows = 0, bytes;
		TRY(store_rows_count(&copy->rows, (enum row_table)table, &rows, &bytes));
		checking.total += rows;
	}
	for (int table = 0; table < ROW_TABLES; table++) {
		checking.table = (enum row_table)table;
		TRY(store_rows_each(&copy->rows, checking.table, 0, INT64_MAX, check_row, &checking));
	}
	return STATUS_OK;
}

static enum status check_copy(const struct store_staged *staged, store_progress_fn progress, void *user)
{
	struct store *copy = NULL;
	uint64_t state = 0, base = 0;
	enum status status;
	TRY_OR(done, store_open(staged->copy, &reading, &copy));
	if (copy->under != NULL)
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: it is an overlay", staged->copy));
	TRY_OR(done, store_overlay_hold(copy, copy->db));
	TRY_OR(done, store_lineage_state(copy, &state));
	TRY_OR(done, store_identity_compute(copy, &base));
	if (state != staged->state || base != copy->base_hash)
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: it has another base, or other ruts", staged->copy));
	TRY_OR(done, check_rows(copy, progress, user));
done:
	store_close(copy);
	if (status != STATUS_INPUT)
		return status;
	struct failure failure;
	failure_capture(&failure, status);
	char *advice = strstr(failure.message, "; ");
	if (advice != NULL)
		*advice = '\0';
	return fail_with(STATUS_INPUT, "%s: it is not the whole copy of %s that its name promises: %s; remove that file, or stage in another folder",
			 staged->copy, staged->original, failure.message);
}

/* --- a new copy --- */

static enum status make_folder(const char *copy)
{
	char *path = mem_strdup(copy);
	TRY_MEM(path, "a base's copy");
	const char *folder = dirname(path);
	struct stat file;
	enum status status = STATUS_OK;
	if (mkdir(folder, 0777) != 0 && (errno != EEXIST || stat(folder, &file) != 0 || !S_ISDIR(file.st_mode)))
		status = fail_with(STATUS_FAILED, "%s: %s; give a folder for the copy of the base that can be made and written", folder, strerror(errno));
	mem_free(path);
	return status;
}

static enum status make_copy(const struct store_staged *staged, store_progress_fn progress, void *user)
{
	struct store *original = NULL;
	uint64_t state = 0;
	enum status status;
	TRY_OR(done, store_open_state(staged->original, staged->state, &original));
	TRY_OR(done, store_lineage_state(original, &state));
	if (state != staged->state)
		TRY_OR(done, fail_with(STATUS_FAILED, "%s: it was driven since this run began; start again", staged->original));
	TRY_OR(done, store_copy(original, staged->copy, false, "stage", false, progress, user));
done:
	store_close(original);
	return status;
}

/* Makes the copy, unless another process is at it: then waits a moment. */
static enum status make_in_turn(const struct store_staged *staged, const char *lock_path, store_progress_fn progress, void *user, bool *made)
{
	const struct timespec nap = {.tv_nsec = WAIT_NS};
	struct stat file;
	int lock = -1;
	bool taken = false;
	enum status status = STATUS_OK;
	TRY(store_lock_try(lock_path, staged->copy, &lock, &taken));
	if (!taken) {
		nanosleep(&nap, NULL);
		return progress != NULL ? progress(user, 0, 0) : STATUS_OK;
	}
	if (lstat(staged->copy, &file) != 0) { /* nobody made it since the last look */
		status = make_copy(staged, progress, user);
		*made = status == STATUS_OK;
	}
	store_lock_drop(lock_path, lock);
	return status;
}

enum status store_stage(const struct store_staged *staged, store_progress_fn progress, void *user, bool *made)
{
	struct stat file;
	*made = false;
	char *lock_path = store_path_with(staged->copy, "-stage");
	TRY_MEM(lock_path, "a base's copy");
	enum status status;
	TRY_OR(done, make_folder(staged->copy));
	while (!*made && lstat(staged->copy, &file) != 0)
		TRY_OR(done, make_in_turn(staged, lock_path, progress, user, made));
	if (!*made)
		TRY_OR(done, check_copy(staged, progress, user));
done:
	mem_free(lock_path);
	return status;
}
