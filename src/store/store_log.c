/* Names the present revision, and tells the revisions that a store and the files under it keep. */
#include "store/internal.h"

#include <assert.h>
#include <string.h>
#include <time.h>

#define NAME_MOST 64

static bool name_fits(const char *name)
{
	size_t length = strlen(name);
	bool fits = length > 0 && length <= NAME_MOST && strspn(name, "0123456789") < length && name[0] != '-';
	for (const char *c = name; fits && *c != '\0'; c++)
		fits = (unsigned char)*c > ' ' && *c != 0x7f && *c != ',';
	return fits;
}

static enum status put_name(struct store *store, const char *name)
{
	sqlite3_stmt *statement = NULL;
	enum status status = STATUS_OK;
	TRY(store_sql_prepare(store->db, store->path, &statement, "INSERT INTO snapshot VALUES(?1, ?2, ?3, ?4)"));
	sqlite3_bind_text(statement, 1, name, -1, SQLITE_STATIC);
	sqlite3_bind_int64(statement, 2, store->commit);
	sqlite3_bind_int64(statement, 3, (int64_t)time(NULL));
	sqlite3_bind_text(statement, 4, store->who, -1, SQLITE_STATIC);
	int code = sqlite3_step(statement);
	if ((code & 0xff) == SQLITE_CONSTRAINT)
		status = fail_with(STATUS_INPUT, "%s: it has a snapshot %s already; give another name", store->path, name);
	else if (code != SQLITE_DONE)
		status = store_sql_fail(store->db, code, store->path, "naming a revision");
	sqlite3_finalize(statement);
	return status;
}

enum status store_snapshot(struct store *store, const char *name)
{
	assert(store->writing);
	if (!name_fits(name))
		return fail_with(STATUS_INPUT, "%s: '%.80s' names no snapshot; give 1 to %d characters without blanks and commas, not all digits",
				 store->path, name, NAME_MOST);
	enum status status;
	TRY_OR(failed, store_sql_begin(store->db, store->path, "naming a revision"));
	TRY_OR(failed, store_history_keep(store));
	TRY_OR(failed, put_name(store, name));
	TRY_OR(failed, store_sql_exec(store->db, store->path, "naming a revision", "COMMIT"));
	store->history.kept = store->commit;
	return STATUS_OK;
failed:
	store_sql_undo(store->db);
	return status;
}

/* --- the log --- */

/* Kept revisions, with the names of their snapshots; then the present one, which may be kept, too. */
static const char text[] =
	"SELECT revision, made, who, what, scene_hash, step, time, "
	"(SELECT group_concat(name, ',') FROM snapshot WHERE snapshot.revision = kept.revision) FROM "
	"(SELECT revision, made, who, what, scene_hash, step, time FROM revision "
	"WHERE revision NOT IN (SELECT epoch FROM run) "
	"UNION ALL SELECT epoch, made, who, what, scene_hash, step, time FROM run) AS kept "
	"WHERE revision <= ?1 ORDER BY revision DESC";

static const char *column_text(sqlite3_stmt *statement, int column)
{
	const char *found = (const char *)sqlite3_column_text(statement, column);
	return found != NULL ? found : "";
}

static enum status log_file(const struct store *store, int64_t newest, bool present, store_log_fn fn, void *user)
{
	sqlite3_stmt *statement = NULL;
	enum status status = STATUS_OK;
	int code;
	TRY(store_sql_prepare(store->db, store->path, &statement, text));
	sqlite3_bind_int64(statement, 1, newest);
	while ((code = sqlite3_step(statement)) != SQLITE_DONE) {
		if (code != SQLITE_ROW)
			TRY_OR(done, store_sql_fail(store->db, code, store->path, "reading its history"));
		const struct store_revision revision = {
			.file = store->path,
			.revision = sqlite3_column_int64(statement, 0),
			.made = sqlite3_column_int64(statement, 1),
			.who = column_text(statement, 2),
			.what = column_text(statement, 3),
			.scene_hash = column_text(statement, 4),
			.step = sqlite3_column_int64(statement, 5),
			.time = sqlite3_column_double(statement, 6),
			.names = column_text(statement, 7),
			.present = present && sqlite3_column_int64(statement, 0) == store->commit,
		};
		TRY_OR(done, fn(user, &revision));
	}
done:
	sqlite3_finalize(statement);
	return status;
}

enum status store_log(const struct store *store, store_log_fn fn, void *user)
{
	int64_t newest = INT64_MAX;
	for (const struct store *file = store; file != NULL; file = file->inherits ? file->under : NULL) {
		TRY(log_file(file, newest, file == store, fn, user));
		newest = file->parent_revision;
	}
	return STATUS_OK;
}
