/*
 * Tells a store that an overlay depends on it.
 *
 *   the parent is held (BEGIN IMMEDIATE: no commit now) -> it is still what the overlay depends on -> the line, synced -> the overlay
 *   gets its name
 */
#include "store/internal.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static bool may_list(const char *real_path)
{
	char folder[PATH_MAX];
	struct stat file;
	snprintf(folder, sizeof folder, "%s%s", real_path, PINS_SUFFIX);
	if (lstat(folder, &file) == 0 && S_ISREG(file.st_mode) && access(folder, W_OK) != 0)
		return false;
	return access(dirname(folder), W_OK) == 0;
}

/* Commits of a writer that does not sync them could be lost with the power, but not what an overlay depends on. */
static enum status sync_wal(const struct store *parent)
{
	char path[PATH_MAX + 8];
	snprintf(path, sizeof path, "%s-wal", parent->real_path);
	if (!store_connect_has_wal(parent->real_path))
		return STATUS_OK;
	int file = open(path, O_RDONLY | O_CLOEXEC);
	bool synced = file >= 0 && fsync(file) == 0;
	if (file >= 0)
		close(file);
	return synced ? STATUS_OK : fail_with(STATUS_FAILED, "%s: cannot be synced: %s; check the disk", path, strerror(errno));
}

/* Begins a transaction in which nobody commits to the parent. *db NULL: its file cannot be written. */
static enum status hold(struct store *parent, sqlite3 **db)
{
	int64_t commit = 0;
	*db = NULL;
	if (access(parent->real_path, W_OK) != 0)
		return STATUS_OK;
	TRY(store_connect_file(parent->real_path, parent->path, true, db));
	sqlite3_db_config(*db, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, (int *)NULL);
	parent->moved_on = false;
	TRY(store_sql_begin(*db, parent->path, "noting an overlay of it"));
	TRY(store_sql_integer(*db, parent->path, "SELECT coalesce(max(epoch), 0) FROM run", &commit));
	/* A pinned revision stays. */
	parent->moved_on = parent->shown < 0 && commit != parent->commit;
	if (parent->moved_on)
		return fail_with(STATUS_FAILED, "%s: it was driven on while an overlay of it was made; try again", parent->path);
	return STATUS_OK;
}

/* What lies beside the store and depends on its base alone is found without a list. */
static bool needs_no_list(const struct pin *pin, const char *from)
{
	return pin->base && strchr(from, '/') == NULL;
}

/* Puts the line, while the parent is held. *db: that which holds it, also after a failure; NULL: none. */
static enum status add_line(struct store *parent, const char *real_path, const struct pin *pin, sqlite3 **db)
{
	if (!store_overlay_path_fits(pin->path, strlen(pin->path)))
		return fail_with(STATUS_INPUT, "%s: its list of overlays takes no path with control characters; give the overlay another name", parent->path);
	if (!may_list(parent->real_path)) {
		if (!pin->base)
			note("%s: it cannot be told of %s, since its list of overlays cannot be written; whoever drives it makes that overlay unusable",
			     parent->path, real_path);
		return STATUS_OK;
	}
	if (!pin->base) {
		TRY(hold(parent, db));
		TRY(sync_wal(parent));
	}
	return store_pins_put(parent->real_path, pin);
}

enum status store_pins_add(struct store *parent, const char *real_path, const struct pin *pin)
{
	char *folder = mem_strdup(parent->real_path), *from = NULL;
	sqlite3 *db = NULL;
	if (folder != NULL)
		from = store_overlay_path_between(dirname(folder), real_path);
	mem_free(folder);
	TRY_MEM(from, "a list of overlays");
	struct pin named = *pin;
	named.path = from;
	named.made = (int64_t)time(NULL);
	enum status status = needs_no_list(pin, from) ? STATUS_OK : add_line(parent, real_path, &named, &db);
	if (db != NULL)
		store_sql_undo(db);
	sqlite3_close(db);
	mem_free(from);
	return status;
}

struct seeking {
	const char *path;
	const struct pin *pin;
	bool found;
};

static enum status seek(void *user, const struct pin *pin)
{
	struct seeking *seeking = user;
	seeking->found |= strcmp(pin->path, seeking->path) == 0 && pin->hash == seeking->pin->hash && pin->base == seeking->pin->base;
	return STATUS_OK;
}

enum status store_pins_tell_parent(struct store *store)
{
	struct store *parent = store->under;
	const struct pin pin = {
		.revision = store->parent_revision,
		.hash = store->inherits ? store->parent_hash : store->base_hash,
		.base = !store->inherits,
	};
	char *folder = mem_strdup(parent->real_path);
	char *from = folder != NULL ? store_overlay_path_between(dirname(folder), store->real_path) : NULL;
	struct seeking seeking = {.path = from, .pin = &pin};
	mem_free(folder);
	TRY_MEM(from, "a list of overlays");
	seeking.found = needs_no_list(&pin, from);
	enum status status = seeking.found ? STATUS_OK : store_pins_each(parent->real_path, seek, &seeking);
	mem_free(from);
	TRY(status);
	if (seeking.found || !may_list(parent->real_path))
		return STATUS_OK;
	return store_pins_add(parent, store->real_path, &pin);
}

void store_pins_withdraw_from(const struct store *store, const struct store *parent)
{
	char *folder = mem_strdup(parent->real_path);
	char *from = folder != NULL ? store_overlay_path_between(dirname(folder), store->real_path) : NULL;
	struct failure failure;
	failure_capture(&failure, STATUS_FAILED);
	enum status dropped = from != NULL && may_list(parent->real_path) ? store_pins_drop(parent->real_path, from) : STATUS_OK;
	(void)dropped;
	failure_restore(&failure);
	mem_free_all(from, folder);
}

void store_pins_withdraw(const struct store *store)
{
	if (store->under != NULL && store->part.count == 0)
		store_pins_withdraw_from(store, store->under);
}
