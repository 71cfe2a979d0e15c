/*
 * Makes and opens overlays. An overlay is a store without base tiles. It names another store, its parent, which has them or is an
 * overlay itself. At the end of such a chain is a plain store, the base.
 *
 * An overlay of an untouched plain store has only its base tiles from it. Any other overlay inherits: it shows the deformation of its
 * parent, too, as it was when the overlay was made (store_lineage.c).
 *
 * Invariants:
 *   1. All files but the overlay itself are opened for reading only. No chain is longer than STORE_DEPTH_MOST, and none has a loop.
 *   2. A parent is refused if its base's hash, its header or the hash of its state differs from what the overlay has. If the parent has gone on,
 *      the state is the pinned one (store_pinned.c).
 *   3. While an overlay that inherits is open, its parent stays as it is to each connection.
 *   4. The path to the parent starts at the overlay's folder, so that both can be moved together. It is absolute if they share
 *      no folder.
 */
#include "store/internal.h"

#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define TRIES 8 /* of an overlay of a store that another process drives: it commits about once a second */

static const struct store_options reading = {.mode = STORE_READ};

bool store_overlay_path_fits(const char *path, size_t length)
{
	bool fits = length > 0 && length < PATH_MAX && strlen(path) == length;
	for (const char *c = path; fits && *c != '\0'; c++)
		fits = (unsigned char)*c >= ' ' && *c != 0x7f;
	return fits;
}

/* --- to the base and back --- */

char *store_overlay_path_between(const char *folder, const char *file)
{
	size_t same = 0, at = 0, up = 0;
	while (folder[at] != '\0' && folder[at] == file[at]) {
		same = folder[at] == '/' ? at : same;
		at++;
	}
	if (folder[at] == '\0' && file[at] == '/')
		same = at;
	for (const char *c = folder + same; *c != '\0'; c++)
		up += *c == '/';
	size_t room = 3 * up + strlen(file + same) + 1;
	if (same == 0 || room > PATH_MAX)
		return mem_strdup(file);
	char *path = mem_alloc(room, 1), *to = path;
	if (path == NULL)
		return NULL;
	for (size_t i = 0; i < up; i++)
		to += sprintf(to, "../");
	memcpy(to, file + same + 1, strlen(file + same));
	return path;
}

char *store_overlay_parent_file(const struct store *store)
{
	char there[PATH_MAX];
	const char *given = store->parent_given != NULL ? store->parent_given : store->base_path;
	char *named = NULL, *folder = mem_strdup(store->real_path);
	if (folder == NULL)
		return NULL;
	size_t room = strlen(folder) + strlen(given) + 2;
	if (given[0] == '/' || store->parent_given != NULL)
		named = mem_strdup(given);
	else if ((named = mem_alloc(room, 1)) != NULL)
		snprintf(named, room, "%s/%s", dirname(folder), given);
	mem_free(folder);
	if (named == NULL || realpath(named, there) == NULL)
		return named;
	mem_free(named);
	return mem_strdup(there);
}

/* Turns the parent's error message into one about the overlay. */
static enum status parent_unusable(const struct store *store, enum status status)
{
	struct failure failure;
	failure_capture(&failure, status);
	char *advice = strstr(failure.message, "; ");
	if (status != STATUS_INPUT || store->parent_given != NULL) /* who relinks asks about the parent */
		return status;
	if (store->over_told) /* an overlay further down said it all */
		return store->over != NULL ? status : fail_with(STATUS_INPUT, "%s: it is over %s", store->path, failure.message);
	if (advice != NULL)
		*advice = '\0';
	return fail_with(STATUS_INPUT, "%s: its base cannot be used: %s; put the base back, tell where it is with "
			 "furrow relink, or drive with another --overlay", store->path, failure.message);
}

static bool same_real(double a, double b)
{
	return memcmp(&a, &b, sizeof a) == 0 || (a != a && b != b);
}

/* They must agree, since the base's tiles are read with the overlay's header. */
bool store_overlay_same_terrain(const struct store_meta *a, const struct store_meta *b)
{
	return a->extent.width == b->extent.width && a->extent.height == b->extent.height &&
	       a->extent.cells == b->extent.cells && same_real(a->extent.spacing, b->extent.spacing) &&
	       same_real(a->step, b->step) && same_real(a->origin[0], b->origin[0]) &&
	       same_real(a->origin[1], b->origin[1]) && same_real(a->low, b->low) &&
	       same_real(a->high, b->high) && strcmp(a->srs, b->srs) == 0 &&
	       strcmp(a->vertical, b->vertical) == 0;
}

/* A chain of overlays has an end, and it is not longer than a reader can hold open. */
static enum status check_chain(const struct store *store)
{
	int files = 1;
	for (const struct store *over = store->over; over != NULL; over = over->over, files++)
		if (strcmp(over->real_path, store->real_path) == 0)
			return fail_with(STATUS_INPUT, "%s: it is an overlay of itself: %s names it as its parent; put back the "
					 "store that it was made from", store->path, store->over->path);
	return files <= STORE_DEPTH_MOST ? STATUS_OK
					 : fail_with(STATUS_INPUT, "%s: more than %d overlays lie one over another; drive or branch one "
						     "further down", store->path, STORE_DEPTH_MOST);
}

/* What the parent was when the overlay was made, it still is. */
static enum status check_parent(struct store *store)
{
	struct store *under = store->under;
	uint64_t hash;
	TRY(store_overlay_hold(under, under->db));
	TRY(store_lineage_make(under, store->parent_revision, &store->lineage));
	TRY(store_lineage_hash(under, &store->lineage, &hash));
	if (hash == store->parent_hash)
		return STATUS_OK;
	if (store->parent_given != NULL)
		return fail_with(STATUS_INPUT, "%s: it is not over %s, whose ruts are others: it was made at revision %lld of its parent, and "
				 "this file is at %lld; name the file that it was made from, at that revision", store->path, under->path,
				 (long long)store->parent_revision, (long long)under->commit);
	return fail_with(STATUS_INPUT, "%s: its parent %s has changed since: it was at revision %lld, and is at %lld; restore the "
			 "parent to that revision, or make another branch of it", store->path, under->path,
			 (long long)store->parent_revision, (long long)under->commit);
}

static enum status connect_parent(struct store *store)
{
	if (store->over != NULL && !store->over->inherits)
		return fail_with(STATUS_INPUT, "%s: it is an overlay itself, and %s was not made from one; name the store that it is over",
				 store->path, store->over->path);
	TRY(check_chain(store));
	char *path = store_overlay_parent_file(store);
	TRY_MEM(path, "an overlay");
	enum status status = store_open_as(path, &(struct store_options){.mode = STORE_READ, .staged = store->staged}, store, NULL, &store->under);
	mem_free(path);
	if (status != STATUS_OK)
		return parent_unusable(store, status);
	store->under->over = NULL;
	store->depth = store->under->depth + 1;
	store->base = store->under->base;
	if (store->under->base_hash != store->base_hash && store->parent_given != NULL)
		return fail_with(STATUS_INPUT, "%s: it was not made over %s, whose terrain is another one (base_hash %016llx, not %016llx); name the "
				 "store that it was made over", store->path, store->under->path,
				 (unsigned long long)store->under->base_hash, (unsigned long long)store->base_hash);
	if (store->under->base_hash != store->base_hash)
		return fail_with(STATUS_INPUT, "%s: its base %s is another one now (base_hash %016llx, not %016llx); put the "
				 "first one back, tell where it is with furrow relink, or drive with another --overlay", store->path, store->under->path,
				 (unsigned long long)store->under->base_hash, (unsigned long long)store->base_hash);
	if (!store_overlay_same_terrain(&store->meta, &store->under->meta))
		return fail_with(STATUS_INPUT, "%s: its header is not that of its base %s; it is damaged, drive with another "
				 "--overlay", store->path, store->under->path);
	return store->inherits ? check_parent(store) : STATUS_OK;
}

enum status store_overlay_connect(struct store *store)
{
	enum status status = connect_parent(store);
	if (status != STATUS_OK && store->over != NULL)
		store->over->over_told = true;
	return status;
}

void store_overlay_inherit(struct store *store)
{
	for (struct store *under = store->under; under != NULL; under = under->under)
		store->layers[under->depth] = &under->rows;
	if (!store->inherits)
		return;
	store->rows.lineage = &store->lineage;
	store->rows.statements = &store->statements;
	store->rows.layers = store->layers;
}

enum status store_overlay_hold(const struct store *store, sqlite3 *db)
{
	int64_t commit;
	TRY(store_sql_exec(db, store->path, "opening it", "BEGIN"));
	TRY(store_sql_integer(db, store->path, "SELECT coalesce(max(epoch), 0) FROM run", &commit));
	if (commit != store->commit)
		return fail_with(STATUS_INPUT, "%s: it is driven while an overlay of it is open; wait for the drive to end, or branch "
				 "again", store->path);
	return STATUS_OK;
}

const char *store_file_path(const struct store *store)
{
	return store->path;
}

/* Returns the path of a file itself, also where a copy is read. */
static const char *path_of(const struct store *store)
{
	return store->copied_from != NULL ? store->copied_from : store->path;
}

const char *store_base_path(const struct store *store)
{
	const struct store *base = store;
	while (base->under != NULL)
		base = base->under;
	return base != store ? path_of(base) : NULL;
}

const char *store_copy_path(const struct store *store)
{
	const struct store *base = store;
	while (base->under != NULL)
		base = base->under;
	return base->copied_from != NULL ? base->path : NULL;
}

int store_depth(const struct store *store)
{
	return store->depth;
}

const char *store_parent(const struct store *store, int64_t *revision)
{
	*revision = store->parent_revision;
	return store->under != NULL ? path_of(store->under) : NULL;
}

/* --- making one --- */

enum status store_overlay_name_parent(struct store *store, const struct store *parent)
{
	store->meta.low = parent->meta.low;
	store->meta.high = parent->meta.high;
	store->base_hash = parent->base_hash;
	mem_free(store->base_path);
	store->base_path = NULL;
	char *folder = mem_strdup(store->real_path);
	if (folder != NULL)
		store->base_path = store_overlay_path_between(dirname(folder), parent->real_path);
	mem_free(folder);
	TRY_MEM(store->base_path, "an overlay");
	return store_overlay_path_fits(store->base_path, strlen(store->base_path))
		       ? STATUS_OK
		       : fail_with(STATUS_INPUT, "%s: its path has control characters; rename it", parent->path);
}

enum status store_overlay_begin_as(struct store *store, const struct store *parent, const struct store_run_copy *run, const char *what)
{
	if (parent->working_stored)
		TRY(store_meta_put_working(store, parent->working, parent->relief_text));
	if (parent->compacted != 0)
		TRY(store_meta_put_integer(store, "compacted", parent->compacted));
	if (parent->added != 0)
		TRY(store_meta_put_added(store, parent->added));
	store->commit = run->commit - 1;
	return store_run_put_back(store, run, what);
}

enum status store_overlay_begin(struct store *store)
{
	struct store_run_copy run = {0};
	enum status status;
	TRY_OR(done, store_run_copy(store->under, &run));
	run.commit = store->parent_revision;
	TRY_OR(done, store_overlay_begin_as(store, store->under, &run, "branch"));
done:
	store_run_copy_finish(&run);
	return status;
}

static enum status inherit_from(struct store *store, struct store *parent)
{
	struct store_run_copy run = {0};
	store->inherits = true;
	enum status status = store_overlay_hold(parent, parent->db);
	parent->moved_on = status == STATUS_INPUT;
	TRY(status);
	TRY(store_lineage_state(parent, &store->parent_hash));
	store->parent_revision = parent->commit;
	TRY_OR(done, store_run_copy(parent, &run));
	TRY_OR(done, store_overlay_begin_as(store, parent, &run, "branch"));
done:
	store_run_copy_finish(&run);
	return status;
}

/* Lets a new overlay read what it inherits before it is published. Afterwards the overlay owns the parent. */
static enum status go_over(struct store *store, struct store *parent)
{
	store->under = parent;
	store->depth = parent->depth + 1;
	store->base = parent->base;
	store->commit = store->parent_revision;
	if (store->inherits)
		TRY(store_lineage_make(parent, parent->commit, &store->lineage));
	store_overlay_inherit(store);
	return STATUS_OK;
}

/* The parent knows of the overlay before that is there. A part ends with its run. */
static enum status pin_parent(struct store *store, struct store *parent)
{
	const struct pin pin = {
		.revision = store->parent_revision,
		.hash = store->inherits ? store->parent_hash : store->base_hash,
		.base = !store->inherits,
	};
	return store->part.count > 0 ? STATUS_OK : store_pins_add(parent, store->real_path, &pin);
}

/* *again: the parent was committed to meanwhile. */
static enum status publish(struct store *store, const struct store *parent)
{
	enum status status = store_publish(store);
	if (status != STATUS_OK && store->part_path != NULL && store->part.count == 0)
		store_pins_withdraw_from(store, parent);
	return status;
}

/* *again: the parent was committed to meanwhile. */
static enum status make_once(const char *path, const char *parent_path, const uint64_t *state, const struct store_part *part,
			     enum status (*fill)(struct store *store, void *user), void *user, bool *again)
{
	struct store *parent = NULL, *store = NULL;
	struct store *own = NULL; /* the parent, until the overlay owns it */
	enum status status;
	TRY_OR(done, state != NULL ? store_open_state(parent_path, *state, &parent) : store_open(parent_path, &reading, &parent));
	own = parent;
	if (parent->depth == STORE_DEPTH_MOST)
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: %d overlays lie one over another already, and no more can; drive it, or branch one further down",
				       parent_path, STORE_DEPTH_MOST));
	TRY_OR(done, store_create(path, &parent->meta, false, &store));
	TRY_OR(done, store_overlay_name_parent(store, parent));
	if (part != NULL)
		store->part = *part;
	if (parent->under != NULL || parent->working_stored || part != NULL)
		TRY_OR(done, inherit_from(store, parent));
	if (fill != NULL) {
		own = NULL;
		TRY_OR(done, go_over(store, parent));
		TRY_OR(done, fill(store, user));
	}
	TRY_OR(done, pin_parent(store, parent));
	TRY_OR(done, publish(store, parent));
done:
	*again = status != STATUS_OK && parent != NULL && parent->moved_on;
	store_close(store);
	store_close(own);
	return status;
}

enum status store_overlay_make(const char *path, const char *parent_path, const uint64_t *state, const struct store_part *part,
			       enum status (*fill)(struct store *store, void *user), void *user)
{
	bool again = true;
	enum status status = STATUS_OK;
	for (int i = 0; i < TRIES && again; i++)
		status = make_once(path, parent_path, state, part, fill, user, &again);
	return status;
}

enum status store_create_overlay(const char *path, const char *parent_path)
{
	return store_overlay_make(path, parent_path, NULL, NULL, NULL, NULL);
}

/* --- one to write to --- */

/* Returns true if `base` is a file that the overlay is over, or one with the same content: terrain and ruts. */
static bool is_over(struct store *overlay, const struct store *base, uint64_t state)
{
	if (overlay->base_hash != base->base_hash || strcmp(overlay->real_path, base->real_path) == 0)
		return false;
	bool over = base->under == NULL && !base->working_stored; /* terrain alone */
	for (const struct store *at = overlay; at->under != NULL; at = at->under)
		over |= (at->inherits && at->parent_hash == state) || strcmp(at->under->real_path, base->real_path) == 0;
	return over;
}

static enum status check_same(struct store *overlay, struct store *base)
{
	uint64_t state = 0;
	TRY(store_lineage_state(base, &state));
	if (!is_over(overlay, base, state))
		return fail_with(STATUS_INPUT, "%s: it is an overlay of %s, not of %s; give another name", overlay->path,
				 overlay->under->path, base->path);
	return STATUS_OK;
}

/* A file of another kind, or a folder, has the name. The advice differs from that for a store. */
static enum status check_kind(const char *path)
{
	static const char magic[] = "SQLite format 3";
	char begins[sizeof magic] = "";
	struct stat is;
	if (stat(path, &is) != 0)
		return fail_with(STATUS_INPUT, "%s: %s; name an overlay, or a file that is not there yet, in a folder that can be read", path, strerror(errno));
	FILE *file = S_ISREG(is.st_mode) ? fopen(path, "rb") : NULL;
	const size_t got = file != NULL ? fread(begins, 1, sizeof begins, file) : 0;
	if (file != NULL)
		fclose(file);
	if (S_ISREG(is.st_mode) && memcmp(begins, magic, got) == 0) /* store_open tells if it is empty or cannot be read */
		return STATUS_OK;
	return fail_with(STATUS_INPUT, "%s: it is %s, not an overlay; name an overlay, or a file that is not there yet", path,
			 S_ISDIR(is.st_mode) ? "a folder" : "another file");
}

/* Before it is opened for writing, which would change a store that is none. */
static enum status check_overlay(const char *path, const char *base_path)
{
	struct store *store = NULL, *base = NULL;
	enum status status;
	TRY_OR(done, check_kind(path));
	TRY_OR(done, store_open(path, &reading, &store));
	if (store->under == NULL)
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: it is a whole store, not an overlay; name a file that is not there yet%s", path,
				       strcmp(path, base_path) == 0 ? ", or leave --overlay out to keep the ruts in the store" : ""));
	TRY_OR(done, store_open(base_path, &reading, &base));
	TRY_OR(done, check_same(store, base));
done:
	store_close(base);
	store_close(store);
	return status;
}

enum status store_open_overlay(const char *path, const char *base_path, const struct store_options *options,
			       struct store **out)
{
	struct stat file;
	bool absent = stat(path, &file) != 0 && errno == ENOENT;
	if (absent && options->mode == STORE_READ)
		return fail_with(STATUS_INPUT, "%s: there is no such overlay, and none is made where everything is only read; check the path", path);
	TRY(absent ? store_create_overlay(path, base_path) : check_overlay(path, base_path));
	TRY(store_open(path, options, out));
	(*out)->made = absent;
	return STATUS_OK;
}
