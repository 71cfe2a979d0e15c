/*
 * Makes and opens overlays. An overlay is a store without base tiles; it names another store, the base, which has them.
 *
 * Invariants:
 *   1. The base is opened for reading only. The base is not an overlay.
 *   2. A base is refused if its hash or its header differs from what the overlay has.
 *   3. The path to the base starts at the overlay's folder, so that both can be moved together. It is absolute if they share
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

static const struct store_options reading = {.mode = STORE_READ};

bool store_overlay_path_fits(const char *path, size_t length)
{
	bool fits = length > 0 && length < PATH_MAX && strlen(path) == length;
	for (const char *c = path; fits && *c != '\0'; c++)
		fits = (unsigned char)*c >= ' ' && *c != 0x7f;
	return fits;
}

/* --- to the base and back --- */

/* Returns the relative path from `folder` to `file`; both are real paths. NULL: out of memory. */
static char *path_between(const char *folder, const char *file)
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

/* Returns the path of the base by the overlay's header. If the file exists, it is the real path. NULL: out of memory. */
static char *base_file(const struct store *store)
{
	char there[PATH_MAX];
	char *named = NULL, *folder = mem_strdup(store->real_path);
	if (folder == NULL)
		return NULL;
	size_t room = strlen(folder) + strlen(store->base_path) + 2;
	if (store->base_path[0] == '/')
		named = mem_strdup(store->base_path);
	else if ((named = mem_alloc(room, 1)) != NULL)
		snprintf(named, room, "%s/%s", dirname(folder), store->base_path);
	mem_free(folder);
	if (named == NULL || realpath(named, there) == NULL)
		return named;
	mem_free(named);
	return mem_strdup(there);
}

/* Turns the base's error message into one about the overlay. */
static enum status base_unusable(const struct store *store, enum status status)
{
	struct failure failure;
	failure_capture(&failure, status);
	char *advice = strstr(failure.message, "; ");
	if (status != STATUS_INPUT)
		return status;
	if (advice != NULL)
		*advice = '\0';
	return fail_with(STATUS_INPUT, "%s: its base cannot be used: %.320s; put the base back, or drive with another "
			 "--overlay", store->path, failure.message);
}

static bool same_real(double a, double b)
{
	return memcmp(&a, &b, sizeof a) == 0 || (a != a && b != b);
}

/* Returns true if both headers describe the same terrain. They must agree, since the base's tiles are read with the overlay's
 * header. */
static bool same_terrain(const struct store_meta *a, const struct store_meta *b)
{
	return a->extent.width == b->extent.width && a->extent.height == b->extent.height &&
	       a->extent.cells == b->extent.cells && same_real(a->extent.spacing, b->extent.spacing) &&
	       same_real(a->step, b->step) && same_real(a->origin[0], b->origin[0]) &&
	       same_real(a->origin[1], b->origin[1]) && same_real(a->low, b->low) &&
	       same_real(a->high, b->high) && strcmp(a->srs, b->srs) == 0 &&
	       strcmp(a->vertical, b->vertical) == 0;
}

enum status store_overlay_connect(struct store *store)
{
	char *path = base_file(store);
	if (path == NULL)
		return fail_memory("an overlay");
	enum status status = store_open_as(path, &reading, true, &store->under);
	mem_free(path);
	if (status != STATUS_OK)
		return base_unusable(store, status);
	store->base = &store->under->rows;
	if (store->under->base_hash != store->base_hash)
		return fail_with(STATUS_INPUT, "%s: its base %s is another one now (base_hash %016llx, not %016llx); put the "
				 "first one back, or drive with another --overlay", store->path, store->under->path,
				 (unsigned long long)store->under->base_hash, (unsigned long long)store->base_hash);
	if (!same_terrain(&store->meta, &store->under->meta))
		return fail_with(STATUS_INPUT, "%s: its header is not that of its base %s; it is damaged, drive with another "
				 "--overlay", store->path, store->under->path);
	return STATUS_OK;
}

const char *store_base_path(const struct store *store)
{
	return store->under != NULL ? store->under->path : NULL;
}

/* --- making one --- */

static enum status name_base(struct store *store, const struct store *base)
{
	store->meta.low = base->meta.low;
	store->meta.high = base->meta.high;
	store->base_hash = base->base_hash;
	char *folder = mem_strdup(store->real_path);
	if (folder != NULL)
		store->base_path = path_between(dirname(folder), base->real_path);
	mem_free(folder);
	if (store->base_path == NULL)
		return fail_memory("an overlay");
	return store_overlay_path_fits(store->base_path, strlen(store->base_path))
		       ? STATUS_OK
		       : fail_with(STATUS_INPUT, "%s: its path has control characters; rename it", base->path);
}

enum status store_create_overlay(const char *path, const char *base_path)
{
	struct store *base = NULL, *store = NULL;
	enum status status = store_open_as(base_path, &reading, true, &base);
	if (status == STATUS_OK && base->has_working)
		status = fail_with(STATUS_INPUT, "%s: it is deformed itself; furrow reset it first, or drive without "
				   "--overlay", base_path);
	if (status == STATUS_OK)
		status = store_create(path, &base->meta, false, &store);
	if (status == STATUS_OK)
		status = name_base(store, base);
	if (status == STATUS_OK)
		status = store_publish(store);
	store_close(store);
	store_close(base);
	return status;
}

/* --- one to write to --- */

/* Before it is opened for writing, which would change a store that is none. */
static enum status check_overlay(const char *path, const char *base_path)
{
	struct store *store = NULL, *base = NULL;
	enum status status = store_open(path, &reading, &store);
	if (status == STATUS_OK && store->under == NULL)
		status = fail_with(STATUS_INPUT, "%s: it is a store of its own, not an overlay; name a file that is not "
				   "there yet", path);
	if (status == STATUS_OK)
		status = store_open_as(base_path, &reading, true, &base);
	if (status == STATUS_OK && base->base_hash != store->base_hash)
		status = fail_with(STATUS_INPUT, "%s: it is an overlay of %s, not of %s; give another name", path,
				   store->under->path, base_path);
	store_close(base);
	store_close(store);
	return status;
}

enum status store_open_overlay(const char *path, const char *base_path, const struct store_options *options,
			       struct store **out)
{
	struct stat file;
	bool absent = stat(path, &file) != 0 && errno == ENOENT;
	enum status status = absent ? store_create_overlay(path, base_path) : check_overlay(path, base_path);
	if (status == STATUS_OK)
		status = store_open(path, options, out);
	if (status == STATUS_OK)
		(*out)->made = absent;
	return status;
}
