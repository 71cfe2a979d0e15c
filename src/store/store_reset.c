/* Removes all deformation from a store at once. The base stays, and of an overlay what its parent has. */
#include "store/internal.h"

#include <assert.h>

static enum status remove_all(struct store *store, bool force)
{
	TRY(store_sql_begin(store->db, store->path, "resetting it"));
	if (!force)
		TRY(store_losses_refuse(store, false));
	TRY(store_sql_exec(store->db, store->path, "resetting it",
			   "DELETE FROM \"offset\"; DELETE FROM dirt; DELETE FROM heaped; "
			   "DELETE FROM pressed; "
			   "DELETE FROM shear; DELETE FROM dug; DELETE FROM settled; DELETE FROM loose; DELETE FROM floor; DELETE FROM density; DELETE FROM slope; "
			   "DELETE FROM healed; DELETE FROM risen; DELETE FROM grown; DELETE FROM run; DELETE FROM "
			   "history; DELETE FROM revision; "
			   "DELETE FROM snapshot; "
			   "DELETE FROM meta WHERE key IN ('working', 'compacted', 'added', 'relief') OR key GLOB 'added [0-9]*'; "
			   "INSERT OR REPLACE INTO meta(key, value) SELECT 'resets', 1 + coalesce(max(value), 0) FROM meta WHERE key = 'resets'"));
	TRY(store_pinned_clear(store));
	if (store->inherits)
		TRY(store_overlay_begin(store));
	return store_sql_exec(store->db, store->path, "resetting it", "COMMIT");
}

enum status store_resets(const struct store *store, int64_t *count)
{
	return store_sql_integer(store->db, store->path, "SELECT coalesce(max(value), 0) FROM meta WHERE key = 'resets'", count);
}

enum status store_reset(struct store *store, bool force)
{
	assert(store->writing);
	const struct store *parent = store->inherits ? store->under : NULL;
	int64_t commit = store->commit;
	enum status status = remove_all(store, force);
	if (status != STATUS_OK) {
		store_sql_undo(store->db);
		store->commit = commit;
		return status;
	}
	store->has_working = store->working_stored = parent != NULL && parent->working_stored;
	store->working = parent != NULL ? parent->working : 0;
	store->compacted = parent != NULL ? parent->compacted : 0;
	store->added = parent != NULL ? parent->added : 0;
	mem_free(store->relief_text);
	store->relief_text = NULL;
	if (parent != NULL && parent->relief_text != NULL &&
	    (store->relief_text = mem_strdup(parent->relief_text)) == NULL)
		return fail_memory("relief");
	TRY(store_relief_settle(store));
	for (int table = 0; table < ROW_TABLES; table++)
		store->state_rows[table] = STATE_UNKNOWN;
	store->commit = parent != NULL ? store->parent_revision : 0;
	store->marked = store->history.has_level = false;
	store->history.kept = store->pins.newest = -1;
	store_changes_restart(&store->changes, store->commit);
	/* The pages that are free now are given back to the disk; the base's mostly lie before them. */
	TRY(store_sql_exec(store->db, store->path, "resetting it", "PRAGMA incremental_vacuum"));
	TRY(store_pins_clear(store->real_path));
	return store_checkpoint(store);
}
