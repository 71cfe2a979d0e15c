/* Follows a store that another process writes, while this one only reads it. */
#include "store/internal.h"

#include <assert.h>

/* Each connection sees the last commit in its next statement. So only what is kept in memory is old. */
static enum status read_latest(struct store_reader *reader, int64_t *commit, bool *deformed, int *working)
{
	TRY(store_reader_begin(reader));
	TRY(store_sql_integer(reader->db, reader->rows.path, "SELECT coalesce(max(epoch), 0) FROM run", commit));
	return store_meta_working(reader->db, reader->rows.path, &reader->store->meta.extent, deformed, working);
}

static enum status latest(struct store_reader *reader, int64_t *commit, bool *deformed, int *working)
{
	enum status status = read_latest(reader, commit, deformed, working);
	return store_reader_outdated(reader) ? latest(reader, commit, deformed, working) : status;
}

static enum status open_again(const struct store *store, const char *why)
{
	return fail_with(STATUS_INPUT, "%s: since it was opened, %s; open it again", store->path, why);
}

/* The first deformation fits if it is at the level that was set for this opening, over the same ground. */
static enum status first(struct store_reader *reader, int working)
{
	struct store *store = reader->store;
	int64_t relief = 0;
	TRY(store_sql_integer(reader->db, reader->rows.path, "SELECT count(*) FROM meta WHERE key = 'relief'", &relief));
	if (!store->has_working || working != store->working || relief != 0 || store->relief_text != NULL)
		return open_again(store, "it was driven for the first time, at another spacing or over relief");
	store->working_stored = true;
	return STATUS_OK;
}

enum status store_follow(struct store_reader *reader, store_key_fn fn, void *user, bool *moved)
{
	struct store *store = reader->store;
	int64_t commit = 0, since = store->commit, now;
	bool deformed = false;
	int working = 0;
	assert(!store->writing);
	*moved = false;
	TRY(latest(reader, &commit, &deformed, &working));
	if (commit == since)
		return STATUS_OK;
	if (commit < since || (!deformed && store->working_stored))
		return open_again(store, "it was reset");
	if (deformed && store->working_stored && working != store->working)
		return open_again(store, "it was reset, and driven at another spacing");
	if (deformed && !store->working_stored)
		TRY(first(reader, working));
	*moved = true;
	store->commit = commit;
	store_changes_restart(&store->changes, commit);
	return fn != NULL ? store_each_changed(reader, since, fn, user, &now) : STATUS_OK;
}

enum status store_has_moved(struct store_reader *reader, bool *moved)
{
	int64_t commit = 0;
	bool deformed;
	int working;
	enum status status = latest(reader, &commit, &deformed, &working);
	*moved = commit != reader->store->commit;
	return status;
}
