/* Removes all deformation from a store at once. The base stays. */
#include "store/internal.h"

#include <assert.h>

enum status store_reset(struct store *store)
{
	assert(store->writing);
	enum status status = store_sql_begin(store->db, store->path, "resetting it");
	if (status != STATUS_OK)
		return status;
	status = store_sql_exec(store->db, store->path, "resetting it",
			  "DELETE FROM \"offset\"; DELETE FROM dirt; DELETE FROM heaped; DELETE FROM pressed; "
			  "DELETE FROM shear; DELETE FROM dug; DELETE FROM run; "
			  "DELETE FROM meta WHERE key IN ('working', 'compacted'); COMMIT");
	if (status != STATUS_OK) {
		store_sql_undo(store->db);
		return status;
	}
	store->has_working = store->working_stored = false;
	store->working = 0;
	store->compacted = 0;
	for (int table = 0; table < ROW_TABLES; table++)
		store->state_rows[table] = STATE_UNKNOWN;
	store->commit = 0;
	store->marked = false;
	store_changes_restart(&store->changes, 0);
	/* The pages that are free now are given back to the disk; the base's mostly lie before them. */
	status = store_sql_exec(store->db, store->path, "resetting it", "PRAGMA incremental_vacuum");
	return status == STATUS_OK ? store_checkpoint(store) : status;
}
