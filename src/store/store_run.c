/* Reads and writes the record of the run that made the last commit. The record is the only row of its table. */
#include "store/internal.h"

#include <pwd.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

void store_who(char *name, size_t room)
{
	char buffer[1024];
	struct passwd entry, *found = NULL;
	if (getpwuid_r(getuid(), &entry, buffer, sizeof buffer, &found) == 0 && found != NULL)
		snprintf(name, room, "%s", found->pw_name);
	else
		snprintf(name, room, "user %ld", (long)getuid());
}

static enum status keep_text(char **kept, const unsigned char *text)
{
	mem_free(*kept);
	return mem_text(kept, text != NULL ? (const char *)text : "", "the run's record");
}

void store_run_copy_finish(struct store_run_copy *copy)
{
	mem_free_all(copy->scene_hash, copy->state, copy->who, copy->what);
	*copy = (struct store_run_copy){0};
}

static enum status take_run(struct store_run_copy *copy, sqlite3_stmt *statement)
{
	TRY(keep_text(&copy->scene_hash, sqlite3_column_text(statement, 1)));
	TRY(keep_text(&copy->state, sqlite3_column_text(statement, 4)));
	TRY(keep_text(&copy->who, sqlite3_column_text(statement, 6)));
	TRY(keep_text(&copy->what, sqlite3_column_text(statement, 7)));
	copy->found = true;
	copy->made = sqlite3_column_int64(statement, 5);
	copy->commit = sqlite3_column_int64(statement, 0);
	copy->step = sqlite3_column_int64(statement, 2);
	copy->time = sqlite3_column_double(statement, 3);
	return STATUS_OK;
}

enum status store_run_copy(struct store *store, struct store_run_copy *copy)
{
	sqlite3_stmt *statement = NULL;
	enum status status = STATUS_OK;
	copy->commit = 0;
	copy->found = false;
	TRY(store_sql_prepare(store->db, store->path, &statement,
			      "SELECT epoch, scene_hash, step, time, state, made, who, what FROM run WHERE id = 1"));
	int code = sqlite3_step(statement);
	if (code == SQLITE_ROW)
		status = take_run(copy, statement);
	else if (code != SQLITE_DONE)
		status = store_sql_fail(store->db, code, store->path, "reading the run's record");
	sqlite3_finalize(statement);
	return status;
}

static enum status take_kept(struct store_run_copy *copy, struct store_run_header *header, sqlite3_stmt *statement)
{
	TRY(keep_text(&copy->scene_hash, sqlite3_column_text(statement, 0)));
	TRY(keep_text(&copy->state, sqlite3_column_text(statement, 1)));
	TRY(keep_text(&copy->what, sqlite3_column_text(statement, 4)));
	copy->found = true;
	copy->step = sqlite3_column_int64(statement, 2);
	copy->time = sqlite3_column_double(statement, 3);
	header->has_working = sqlite3_column_type(statement, 5) != SQLITE_NULL;
	header->compacted = sqlite3_column_int64(statement, 6);
	return STATUS_OK;
}

enum status store_run_copy_kept(struct store *store, int64_t revision, struct store_run_copy *copy, struct store_run_header *header)
{
	sqlite3_stmt *statement = NULL;
	enum status status;
	copy->commit = revision;
	copy->found = false;
	TRY(store_sql_prepare(store->db, store->path, &statement,
			      "SELECT scene_hash, state, step, time, what, working, compacted FROM revision WHERE revision = ?1"));
	sqlite3_bind_int64(statement, 1, revision);
	int code = sqlite3_step(statement);
	if (code == SQLITE_ROW)
		status = take_kept(copy, header, statement);
	else if (code == SQLITE_DONE)
		status = fail_with(STATUS_INPUT, "%s: it keeps no revision %lld, though it should; it is damaged, restore it", store->path,
				   (long long)revision);
	else
		status = store_sql_fail(store->db, code, store->path, "reading its history");
	sqlite3_finalize(statement);
	TRY(status);
	return store_meta_added_at(store->db, store->path, revision, &header->added);
}

enum status store_run_put(struct store *store, const struct store_run *run, const char *state)
{
	TRY(store_sql_prepare(store->db, store->path, &store->run_statement,
			      "INSERT OR REPLACE INTO run(id, epoch, scene_hash, step, time, state, made, who, what) "
			      "VALUES(1, ?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)"));
	sqlite3_stmt *statement = store->run_statement;
	sqlite3_bind_int64(statement, 1, store->commit + 1);
	sqlite3_bind_text(statement, 2, run->scene_hash, -1, SQLITE_STATIC);
	sqlite3_bind_int64(statement, 3, run->step);
	sqlite3_bind_double(statement, 4, run->time);
	sqlite3_bind_text(statement, 5, state, -1, SQLITE_STATIC);
	sqlite3_bind_int64(statement, 6, (int64_t)time(NULL));
	sqlite3_bind_text(statement, 7, store->who, -1, SQLITE_STATIC);
	sqlite3_bind_text(statement, 8, run->what != NULL ? run->what : store->scene != NULL ? store->scene : "", -1, SQLITE_STATIC);
	int code = sqlite3_step(statement);
	enum status status = code == SQLITE_DONE ? STATUS_OK : store_sql_fail(store->db, code, store->path, "writing the run's record");
	sqlite3_reset(statement);
	sqlite3_clear_bindings(statement);
	return status;
}

enum status store_run_put_back(struct store *store, const struct store_run_copy *copy, const char *what)
{
	const struct history *history = &store->history;
	if (!copy->found && !history->each && history->kept < 0)
		return store_sql_exec(store->db, store->path, "removing the run's record", "DELETE FROM run");
	/* Revisions that are kept stay before the present one: its number must not be lost. */
	const struct store_run none = {.scene_hash = "", .what = what};
	const struct store_run run = {.scene_hash = copy->scene_hash, .step = copy->step, .time = copy->time, .what = what};
	return copy->found ? store_run_put(store, &run, copy->state) : store_run_put(store, &none, "");
}

enum status store_last_run(struct store *store, struct store_run *run)
{
	struct store_run_copy *copy = &store->last_run;
	TRY(store_run_copy(store, copy));
	*run = (struct store_run){0};
	if (copy->found && copy->scene_hash[0] != '\0')
		*run = (struct store_run){
			.scene_hash = copy->scene_hash, .step = copy->step, .time = copy->time, .state = copy->state, .what = copy->what,
		};
	return STATUS_OK;
}

bool store_run_inherited(const struct store *store)
{
	const int64_t commit = store->last_run.commit;
	if (!store->last_run.found || store->under == NULL)
		return false;
	/* A rank's part that has no commit of its own: what counts is the file under it. */
	const struct store *file = store->part.count > 0 && commit == store->parent_revision ? store->under : store;
	return file->under != NULL && commit == file->parent_revision;
}
