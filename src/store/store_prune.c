/*
 * Finds out which overlays still depend on a store, and drops what is kept for those that are gone.
 *
 *   lines of the list -> the file that each names -> where that is gone: files in its folder and in the store's, by hash
 *
 * An overlay names what it depends on by a hash of the store's state. So a file that was moved or copied is found by that hash. Files are
 * opened alone: only what they say of themselves is read, and nothing is written.
 */
#include "store/internal.h"

#include <dirent.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct standing {
	struct store_pin pin;
	char *path, *found, *line; /* owned; line: as the list has it */
};

struct finding {
	struct store *store;
	char *folder; /* of the store */
	struct standing *all;
	size_t count;
	bool has_state;
	uint64_t state; /* of the store now */
};

static void finding_finish(struct finding *finding)
{
	for (size_t i = 0; i < finding->count; i++)
		mem_free_all(finding->all[i].path, finding->all[i].found, finding->all[i].line);
	mem_free_all(finding->all, finding->folder);
}

static char *path_in(const char *folder, const char *name)
{
	size_t room = strlen(folder) + strlen(name) + 2;
	char there[PATH_MAX], *path = mem_alloc(room, 1);
	if (path == NULL)
		return NULL;
	snprintf(path, room, "%s%s%s", name[0] == '/' ? "" : folder, name[0] == '/' ? "" : "/", name);
	if (realpath(path, there) == NULL)
		return path;
	mem_free(path);
	return mem_strdup(there);
}

static enum status add(struct finding *finding, const struct store_pin *pin, const char *line)
{
	TRY(mem_resize(&finding->all, finding->count + 1, sizeof *finding->all, "the overlays of a store"));
	struct standing *standing = &finding->all[finding->count++];
	*standing = (struct standing){.pin = *pin};
	if (line == NULL)
		return STATUS_OK;
	standing->line = mem_strdup(line);
	standing->path = path_in(finding->folder, line);
	return standing->line != NULL && standing->path != NULL ? STATUS_OK : fail_memory("the overlays of a store");
}

static enum status add_line(void *user, const struct pin *pin)
{
	const struct store_pin known = {.revision = pin->revision, .hash = pin->hash, .base = pin->base, .made = pin->made, .state = STORE_PIN_GONE};
	return add(user, &known, pin->path);
}

/* --- what a file says of itself --- */

/* Opens an overlay that may depend on the store: it names the store, or a file that is not there. *out NULL: it is none. */
static enum status open_overlay(const struct finding *finding, const char *path, struct store **out)
{
	static const uint8_t id[4] = {STORE_APPLICATION_ID >> 24, STORE_APPLICATION_ID >> 16 & 0xff,
				      STORE_APPLICATION_ID >> 8 & 0xff, STORE_APPLICATION_ID & 0xff};
	char head[72] = "";
	struct stat file;
	struct store *overlay = NULL;
	*out = NULL;
	if (strcmp(path, finding->store->real_path) == 0 || lstat(path, &file) != 0 || !S_ISREG(file.st_mode))
		return STATUS_OK;
	FILE *in = fopen(path, "rb");
	bool may = in != NULL && fread(head, 1, sizeof head, in) == sizeof head && memcmp(head, "SQLite format 3", 16) == 0 &&
		   memcmp(head + 68, id, sizeof id) == 0; /* what is no store is not opened */
	if (in != NULL)
		fclose(in);
	enum status status = may ? store_open_alone(path, &overlay) : STATUS_INPUT;
	if (status == STATUS_INPUT) /* it is no store, or damaged */
		return STATUS_OK;
	TRY(status);
	bool names = overlay->base_path != NULL && overlay->part.count == 0 && overlay->base_hash == finding->store->base_hash;
	char *parent = names ? store_overlay_parent_file(overlay) : NULL;
	bool lacks = names && parent == NULL;
	bool there = parent != NULL && (strcmp(parent, finding->store->real_path) == 0 || access(parent, F_OK) != 0);
	mem_free(parent);
	if (there)
		*out = overlay;
	else
		store_close(overlay);
	return lacks ? fail_memory("the overlays of a store") : STATUS_OK;
}

static bool depends_on(const struct store *overlay, const struct store_pin *pin)
{
	return overlay->inherits == !pin->base && (pin->base || overlay->parent_hash == pin->hash);
}

static enum status look_at(const struct finding *finding, struct standing *standing)
{
	struct store *overlay = NULL;
	enum status status = open_overlay(finding, standing->path, &overlay);
	if (overlay != NULL && depends_on(overlay, &standing->pin))
		standing->pin.state = STORE_PIN_THERE;
	store_close(overlay);
	return status;
}

/* --- files that no line names --- */

static bool is_known(const struct finding *finding, const char *path)
{
	for (size_t i = 0; i < finding->count; i++)
		if ((finding->all[i].path != NULL && strcmp(finding->all[i].path, path) == 0) ||
		    (finding->all[i].found != NULL && strcmp(finding->all[i].found, path) == 0))
			return true;
	return false;
}

static enum status is_kept(struct finding *finding, const struct store *overlay, bool *kept)
{
	int64_t revision = -1;
	*kept = !overlay->inherits;
	if (*kept)
		return STATUS_OK;
	if (!finding->has_state)
		TRY(store_lineage_state(finding->store, &finding->state));
	finding->has_state = true;
	TRY(store_pinned_find(finding->store, overlay->parent_hash, &revision));
	*kept = revision >= 0 || finding->state == overlay->parent_hash;
	return STATUS_OK;
}

static bool same_folder(const char *a, const char *b)
{
	const char *end = a != NULL ? strrchr(a, '/') : NULL;
	return end != NULL && strncmp(a, b, (size_t)(end - a) + 1) == 0 && strchr(b + (end - a) + 1, '/') == NULL;
}

/* A line whose file is gone may be of this one. Otherwise the list lacks it. */
static enum status take(struct finding *finding, const struct store *overlay, const char *path)
{
	bool kept = false;
	for (size_t i = 0; i < 2 * finding->count; i++) { /* first one that was in the same folder */
		struct standing *standing = &finding->all[i % finding->count];
		if (standing->pin.state != STORE_PIN_GONE || standing->found != NULL || !depends_on(overlay, &standing->pin) ||
		    (i < finding->count && !same_folder(standing->path, path)))
			continue;
		standing->found = mem_strdup(path);
		standing->pin.state = STORE_PIN_MOVED;
		return standing->found != NULL ? STATUS_OK : fail_memory("the overlays of a store");
	}
	TRY(is_kept(finding, overlay, &kept));
	if (!kept)
		return STATUS_OK;
	const struct store_pin pin = {
		.revision = overlay->parent_revision,
		.hash = overlay->inherits ? overlay->parent_hash : overlay->base_hash,
		.base = !overlay->inherits,
		.state = overlay->inherits ? STORE_PIN_FOUND : STORE_PIN_THERE, /* the list names only those elsewhere that need the base alone */
	};
	return add(finding, &pin, path);
}

static enum status look_into(struct finding *finding, const char *path)
{
	struct store *overlay = NULL;
	if (is_known(finding, path))
		return STATUS_OK;
	TRY(open_overlay(finding, path, &overlay));
	if (overlay == NULL)
		return STATUS_OK;
	enum status status = take(finding, overlay, path);
	store_close(overlay);
	return status;
}

static enum status search(struct finding *finding, const char *folder)
{
	enum status status = STATUS_OK;
	DIR *directory = opendir(folder);
	if (directory == NULL)
		return STATUS_OK;
	for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
		char path[PATH_MAX + 256];
		snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
		TRY_OR(done, look_into(finding, path));
	}
done:
	closedir(directory);
	return status;
}

/* Where the folder of a file that is gone is another one. */
static enum status search_elsewhere(struct finding *finding)
{
	for (size_t i = 0, count = finding->count; i < count; i++) {
		if (finding->all[i].pin.state != STORE_PIN_GONE || finding->all[i].path == NULL)
			continue;
		char *path = mem_strdup(finding->all[i].path);
		TRY_MEM(path, "the overlays of a store");
		const char *folder = dirname(path);
		enum status status = strcmp(folder, finding->folder) != 0 ? search(finding, folder) : STATUS_OK;
		mem_free(path);
		TRY(status);
	}
	return STATUS_OK;
}

/* --- all --- */

/* A revision may be kept for an overlay that the list has lost. */
static enum status add_unlisted(struct finding *finding)
{
	sqlite3_stmt *statement = NULL;
	int code = SQLITE_DONE;
	struct store *store = finding->store;
	if (store->version < STORE_VERSION_PINS)
		return STATUS_OK;
	enum status status;
	TRY_OR(done, store_sql_prepare(store->db, store->path, &statement, "SELECT revision, hash FROM main.pinned ORDER BY revision"));
	while ((code = sqlite3_step(statement)) == SQLITE_ROW) {
		const struct store_pin pin = {
			.revision = sqlite3_column_int64(statement, 0), .hash = (uint64_t)sqlite3_column_int64(statement, 1), .state = STORE_PIN_GONE,
		};
		bool listed = false;
		for (size_t i = 0; i < finding->count; i++)
			listed |= !finding->all[i].pin.base && finding->all[i].pin.hash == pin.hash;
		if (!listed)
			TRY_OR(done, add(finding, &pin, NULL));
	}
	if (code != SQLITE_DONE)
		TRY_OR(done, store_sql_fail(store->db, code, store->path, "reading what overlays depend on"));
done:
	sqlite3_finalize(statement);
	return status;
}

static enum status finding_make(struct store *store, struct finding *finding)
{
	char *path = mem_strdup(store->real_path);
	*finding = (struct finding){.store = store};
	finding->folder = path != NULL ? mem_strdup(dirname(path)) : NULL;
	mem_free(path);
	TRY_MEM(finding->folder, "the overlays of a store");
	TRY(store_pins_each(store->real_path, add_line, finding));
	for (size_t i = 0; i < finding->count; i++)
		TRY(look_at(finding, &finding->all[i]));
	TRY(add_unlisted(finding));
	TRY(search(finding, finding->folder));
	TRY(search_elsewhere(finding));
	for (size_t i = 0; i < finding->count; i++) {
		finding->all[i].pin.path = finding->all[i].path;
		finding->all[i].pin.found = finding->all[i].found;
	}
	return STATUS_OK;
}

enum status store_each_pin(struct store *store, store_pin_fn fn, void *user)
{
	struct finding finding;
	enum status status;
	TRY_OR(done, finding_make(store, &finding));
	for (size_t i = 0; i < finding.count; i++)
		TRY_OR(done, fn(user, &finding.all[i].pin));
done:
	finding_finish(&finding);
	return status;
}

/* --- pruning --- */

static bool is_wanted(void *user, int64_t revision, uint64_t hash)
{
	const struct finding *finding = user;
	for (size_t i = 0; i < finding->count; i++)
		if (finding->all[i].pin.state != STORE_PIN_GONE && !finding->all[i].pin.base && finding->all[i].pin.hash == hash)
			return true;
	return false;
}

static enum status put_line(struct finding *finding, const struct standing *standing)
{
	const char *at = standing->found != NULL ? standing->found : standing->path;
	char *line = store_overlay_path_between(finding->folder, at);
	TRY_MEM(line, "the overlays of a store");
	const struct pin pin = {.path = line, .revision = standing->pin.revision, .hash = standing->pin.hash, .base = standing->pin.base, .made = standing->pin.made};
	enum status status = store_overlay_path_fits(line, strlen(line)) ? store_pins_put(finding->store->real_path, &pin) : STATUS_OK;
	mem_free(line);
	return status;
}

static enum status prune_list(struct finding *finding)
{
	for (size_t i = 0; i < finding->count; i++) {
		const struct standing *standing = &finding->all[i];
		if (standing->pin.state == STORE_PIN_MOVED || standing->pin.state == STORE_PIN_FOUND)
			TRY(put_line(finding, standing));
		if (standing->line != NULL && (standing->pin.state == STORE_PIN_MOVED || standing->pin.state == STORE_PIN_GONE))
			TRY(store_pins_drop(finding->store->real_path, standing->line));
	}
	return STATUS_OK;
}

static enum status prune_all(struct store *store, struct finding *finding, int64_t *dropped)
{
	enum status status;
	TRY_OR(failed, store_sql_begin(store->db, store->path, "pruning it"));
	TRY_OR(failed, finding_make(store, finding));
	TRY_OR(failed, prune_list(finding));
	TRY_OR(failed, store_pinned_drop(store, is_wanted, finding, dropped));
	TRY_OR(failed, store_sql_exec(store->db, store->path, "pruning it", "COMMIT"));
	return STATUS_OK;
failed:
	store_sql_undo(store->db);
	return status;
}

static enum status prune(struct store *store, store_pin_fn fn, void *user)
{
	struct finding finding = {0};
	int64_t dropped = 0;
	enum status status;
	TRY_OR(done, prune_all(store, &finding, &dropped));
	if (dropped > 0)
		TRY_OR(done, store_sql_exec(store->db, store->path, "pruning it", "PRAGMA incremental_vacuum"));
	for (size_t i = 0; i < finding.count; i++)
		TRY_OR(done, fn(user, &finding.all[i].pin));
done:
	finding_finish(&finding);
	return status;
}

/* Tells the overlays, if all of them are *there: then nothing needs to be written. */
static enum status tell_if_there(const char *path, store_pin_fn fn, void *user, bool *there)
{
	struct store *store = NULL;
	struct finding finding = {0};
	enum status status;
	*there = true;
	TRY(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	TRY_OR(done, finding_make(store, &finding));
	for (size_t i = 0; i < finding.count; i++)
		*there &= finding.all[i].pin.state == STORE_PIN_THERE;
	for (size_t i = 0; i < finding.count && *there; i++)
		TRY_OR(done, fn(user, &finding.all[i].pin));
done:
	finding_finish(&finding);
	store_close(store);
	return status;
}

enum status store_prune(const char *path, store_pin_fn fn, void *user)
{
	struct store *store = NULL;
	bool there;
	TRY(tell_if_there(path, fn, user, &there));
	if (there)
		return STATUS_OK;
	TRY(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store));
	enum status status = prune(store, fn, user);
	store_close(store);
	return status;
}
