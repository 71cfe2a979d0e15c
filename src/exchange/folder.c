/*
 * The files of a folder of tiles. A file is written aside and renamed, so a kill leaves whole files only. A file that has the right
 * bytes is left alone: its time tells when the tile last changed.
 */
#include "exchange/internal.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/aside.h"
#include "base/limits.h"

static const struct {
	const char *folder, *ending;
} sets[EXCHANGE_SETS] = {
	[EXCHANGE_TERRAIN] = {"terrain", "png"}, [EXCHANGE_HILLSHADE] = {"hillshade", "png"}, [EXCHANGE_RUTS] = {"ruts", "png"},
	[EXCHANGE_MESH] = {"mesh", "terrain"}, [EXCHANGE_IMAGERY] = {"imagery", "webp"},
};

enum status exchange_tile_path(const char *directory, enum exchange_set set, struct tile tile, char path[EXCHANGE_PATH])
{
	int length = snprintf(path, EXCHANGE_PATH, "%s/%s/%d/%u/%u.%s", directory, sets[set].folder, tile.level, tile.x, tile.y, sets[set].ending);
	return length < EXCHANGE_PATH - 8 ? STATUS_OK : fail_with(STATUS_INPUT, "%.80s...: the path is too long; give a shorter one", directory);
}

enum status exchange_file_get(const char *path, size_t most, struct exchange_bytes *out, bool *found)
{
	*found = false;
	out->size = 0;
	FILE *file = input_open(path);
	if (file == NULL)
		return errno == ENOENT || errno == ENOTDIR
			       ? STATUS_OK
			       : fail_with(STATUS_FAILED, "%s: cannot be read: %s; check its permissions", path, input_problem());
	uint8_t block[16384];
	size_t size;
	enum status status = STATUS_OK;
	while (out->size <= most && (size = fread(block, 1, sizeof block, file)) > 0)
		TRY_OR(done, exchange_bytes_add(out, block, size));
	if (ferror(file))
		TRY_OR(done, fail_with(STATUS_FAILED, "%s: cannot be read: %s; check the disk", path, strerror(errno)));
	*found = out->size <= most;
done:
	fclose(file);
	return status;
}

/* True if the file has just these bytes. */
static bool same(const char *path, const struct exchange_bytes *bytes)
{
	FILE *file = input_open(path);
	if (file == NULL)
		return false;
	uint8_t block[16384];
	size_t at = 0, size;
	bool equal = true;
	while (equal && (size = fread(block, 1, sizeof block, file)) > 0) {
		equal = size <= bytes->size - at && memcmp(block, bytes->data + at, size) == 0;
		at += size;
	}
	equal = equal && !ferror(file) && at == bytes->size;
	fclose(file);
	return equal;
}

/* Makes the folders above a file. */
static enum status make_folders(const char *path)
{
	char part[EXCHANGE_PATH];
	snprintf(part, sizeof part, "%s", path);
	for (char *slash = strchr(part + 1, '/'); slash != NULL; slash = strchr(slash + 1, '/')) {
		*slash = '\0';
		if (mkdir(part, 0777) != 0 && errno != EEXIST)
			return fail_with(STATUS_FAILED, "%s: cannot be made: %s; %s", part, strerror(errno),
					 limits_advice(errno, "give a folder that can be written"));
		*slash = '/';
	}
	return STATUS_OK;
}

enum status exchange_file_folder(const char *directory)
{
	char path[EXCHANGE_PATH];
	if (snprintf(path, sizeof path, "%s/", directory) >= (int)sizeof path - 64)
		return fail_with(STATUS_INPUT, "%.80s...: the path is too long; give a shorter one", directory);
	return make_folders(path);
}

/* Opens a file aside, and makes the folders above it if they are not there. */
static enum status begin_file(struct aside *aside, const char *path)
{
	errno = 0;
	enum status status = aside_begin(aside, path);
	if (status == STATUS_OK || errno != ENOENT)
		return status;
	aside_finish(aside);
	TRY(make_folders(path));
	return aside_begin(aside, path);
}

enum status exchange_file_put(const char *path, const struct exchange_bytes *bytes, bool *written)
{
	*written = false;
	if (same(path, bytes))
		return STATUS_OK;
	struct aside aside;
	enum status status;
	TRY_OR(done, begin_file(&aside, path));
	if (bytes->size > 0)
		(void)fwrite(bytes->data, 1, bytes->size, aside.file); /* aside_whole tells a failure */
done:
	TRY(aside_end(&aside, false, status));
	*written = true;
	return STATUS_OK;
}

enum status exchange_file_remove(const char *path, bool *removed)
{
	*removed = unlink(path) == 0;
	return *removed || errno == ENOENT || errno == ENOTDIR
		       ? STATUS_OK
		       : fail_with(STATUS_FAILED, "%s: cannot be removed: %s; check the folder's permissions", path, strerror(errno));
}

/* --- listing --- */

/* The number that a name is: "12", or with an ending "12.png". */
static bool number_of(const char *name, const char *ending, uint32_t *number)
{
	char *end;
	if (name[0] < '0' || name[0] > '9')
		return false;
	errno = 0;
	unsigned long long value = strtoull(name, &end, 10);
	if (errno != 0 || value >= 1u << 28)
		return false;
	*number = (uint32_t)value;
	return ending == NULL ? *end == '\0' : *end == '.' && strcmp(end + 1, ending) == 0;
}

struct walk {
	enum exchange_set set;
	exchange_tile_fn fn;
	void *user;
	uint32_t numbers[3]; /* z, x, y */
};

static enum status walk(struct walk *walked, const char *path, int depth)
{
	DIR *folder = opendir(path);
	if (folder == NULL)
		return errno == ENOENT || errno == ENOTDIR
			       ? STATUS_OK
			       : fail_with(STATUS_FAILED, "%s: cannot be listed: %s; check its permissions", path, strerror(errno));
	enum status status = STATUS_OK;
	const struct dirent *entry;
	while ((entry = readdir(folder)) != NULL) {
		if (!number_of(entry->d_name, depth == 2 ? sets[walked->set].ending : NULL, &walked->numbers[depth]))
			continue;
		char below[EXCHANGE_PATH];
		if (depth == 2) {
			const uint32_t *n = walked->numbers;
			if (n[0] <= EXCHANGE_ZOOM_MOST)
				TRY_OR(done, walked->fn(walked->user, (struct tile){(int)n[0], n[1], n[2]}));
		} else if (snprintf(below, sizeof below, "%s/%s", path, entry->d_name) < (int)sizeof below) {
			TRY_OR(done, walk(walked, below, depth + 1));
		}
	}
done:
	closedir(folder);
	return status;
}

enum status exchange_folder_each(const char *directory, enum exchange_set set, exchange_tile_fn fn, void *user)
{
	char path[EXCHANGE_PATH];
	struct walk walked = {.set = set, .fn = fn, .user = user};
	snprintf(path, sizeof path, "%s/%s", directory, sets[set].folder);
	return walk(&walked, path, 0);
}
