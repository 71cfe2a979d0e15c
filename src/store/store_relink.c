/*
 * Tells an overlay where its parent is, after either was moved or renamed.
 *
 *   the overlay, opened with the given file as its parent -> all checks of an opening -> the path, in one transaction
 *
 * The checks are those of every opening (store_overlay.c): they compare hashes, not names. So a file that passes them is the parent,
 * or has the same content.
 */
#include "store/internal.h"

static enum status put_path(struct store *store)
{
	enum status status;
	TRY_OR(failed, store_sql_begin(store->db, store->path, "naming its base"));
	TRY_OR(failed, store_meta_put_base_path(store));
	TRY_OR(failed, store_sql_exec(store->db, store->path, "naming its base", "COMMIT"));
	return STATUS_OK;
failed:
	store_sql_undo(store->db);
	return status;
}

enum status store_relink(const char *path, const char *parent_path)
{
	struct store *store = NULL;
	const struct store_options options = {.mode = STORE_WRITE, .durable_full = true};
	enum status status;
	TRY_OR(done, store_open_as(path, &options, NULL, parent_path, &store));
	TRY_OR(done, store_overlay_name_parent(store, store->under));
	TRY_OR(done, store_pins_tell_parent(store)); /* before it is named: a kill leaves a line too many, not one too few */
	TRY_OR(done, put_path(store));
done:
	store_close(store);
	return status;
}
