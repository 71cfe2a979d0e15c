/*
 * Whether the files that a store writes are still where it opened them.
 *
 * SQLite goes on writing to a file that was moved, replaced or deleted. It says nothing, and what it writes is not where anybody
 * looks for it.
 */
#include "store/internal.h"

#include <unistd.h>

/* True if the file of the WAL is gone. It is there from the first commit of this connection to its end. */
static bool wal_gone(struct store *store)
{
	const char *wal = sqlite3_filename_wal(sqlite3_db_filename(store->db, "main"));
	const bool there = wal != NULL && access(wal, F_OK) == 0;
	store->wal_seen |= there;
	return store->wal_seen && !there;
}

/* The overlay is whole without its base, and cannot be read. */
static void look_for_base(struct store *store)
{
	for (const struct store *at = store->under; at != NULL && !store->base_told; at = at->under)
		if (at->copied_from == NULL && access(at->real_path, F_OK) != 0) {
			note("%s: %s was moved or deleted while it was in use; put it back, or tell where it is with furrow relink", store->path, at->real_path);
			store->base_told = true;
		}
}

enum status store_place_check(struct store *store)
{
	int moved = 0;
	if (sqlite3_file_control(store->db, "main", SQLITE_FCNTL_HAS_MOVED, &moved) == SQLITE_OK && moved != 0)
		return fail_with(STATUS_FAILED, "%s: the file was moved, replaced or deleted while it was being written; put it back, then go on "
				 "with --resume: it has all until its last commit", store->path);
	if (wal_gone(store))
		return fail_with(STATUS_FAILED, "%s-wal: the file was deleted while the store was being written; leave it there until the writer "
				 "ends, and go on with --resume", store->path);
	look_for_base(store);
	return STATUS_OK;
}
