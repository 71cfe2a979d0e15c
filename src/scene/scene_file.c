/* Reads or hashes whole files, up to a limit. */
#include "scene/scene_file.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

/* Fails for a file that cannot be read, and tells where it was looked for: a scene's paths are relative to its folder. */
static enum status fail_missing(const char *path, const char *told)
{
	char folder[PATH_MAX] = "";
	const char *why = input_problem();
	if (strcmp(path, told) == 0)
		return fail_with(STATUS_INPUT, "%s: %s; name a file that can be read", told, why);
	if (path[0] != '/' && getcwd(folder, sizeof folder - 1) != NULL)
		strcat(folder, "/");
	return fail_with(STATUS_INPUT, "%s: %s; name a file that can be read; it was looked for at %.500s%.500s", told, why, folder, path);
}

enum status scene_file_read(const char *path, const char *told, size_t limit, char **bytes,
			    size_t *length)
{
	enum status status = STATUS_OK;
	char *text = NULL;
	size_t used = 0, size = 0;
	FILE *file = input_open(path);
	if (file == NULL)
		return fail_missing(path, told);
	for (;;) {
		status = mem_grow(&text, &size, used == 0 ? 16384 : used + 2, 1, "reading the scene");
		if (status != STATUS_OK)
			break;
		size_t got = fread(text + used, 1, size - used - 1, file);
		used += got;
		if (used > limit) {
			status = fail_with(STATUS_INPUT, "%s: the file is too large; allowed: %zu bytes",
					   told, limit);
			break;
		}
		if (got == 0) {
			if (ferror(file))
				status = fail_with(STATUS_INPUT,
						   "%s: %s; name a file that can be read", told,
						   strerror(errno));
			break;
		}
	}
	fclose(file);
	if (status != STATUS_OK) {
		mem_free(text);
		return status;
	}
	text[used] = '\0';
	*bytes = text;
	*length = used;
	return STATUS_OK;
}

static enum status hash_bytes(FILE *file, const char *told, uint64_t limit, XXH3_state_t *state)
{
	char bytes[16384];
	uint64_t used = 0;
	size_t got;
	while ((got = fread(bytes, 1, sizeof bytes, file)) > 0) {
		used += got;
		if (used > limit)
			return fail_with(STATUS_INPUT, "%s: the file is too large; allowed: %llu bytes", told,
					 (unsigned long long)limit);
		XXH3_128bits_update(state, bytes, got);
	}
	if (ferror(file))
		return fail_with(STATUS_INPUT, "%s: %s; name a file that can be read", told, strerror(errno));
	return STATUS_OK;
}

enum status scene_file_hash(const char *path, const char *told, uint64_t limit, uint64_t hash[2])
{
	FILE *file = input_open(path);
	if (file == NULL)
		return fail_missing(path, told);
	XXH3_state_t *state = XXH3_createState();
	if (state == NULL) {
		fclose(file);
		return fail_memory("hashing a file");
	}
	XXH3_128bits_reset(state);
	enum status status = hash_bytes(file, told, limit, state);
	XXH128_hash_t all = XXH3_128bits_digest(state);
	hash[0] = all.low64;
	hash[1] = all.high64;
	XXH3_freeState(state);
	fclose(file);
	return status;
}

char *scene_file_beside(const char *file, const char *name)
{
	const char *slash = strrchr(file, '/');
	if (name[0] == '/' || slash == NULL)
		return mem_strdup(name);
	size_t folder = (size_t)(slash - file) + 1;
	char *path = mem_alloc(folder + strlen(name) + 1, 1);
	if (path == NULL)
		return NULL;
	memcpy(path, file, folder);
	memcpy(path + folder, name, strlen(name) + 1);
	return path;
}

enum status scene_folder_of(const char *file, bool whole, char **folder)
{
	const char *slash = strrchr(file, '/');
	size_t length = slash != NULL ? (size_t)(slash - file) + 1 : 0;
	char here[PATH_MAX] = "";
	if (whole && file[0] != '/' && getcwd(here, sizeof here - 1) == NULL)
		return fail_with(STATUS_INPUT, "%s: the current folder cannot be found: %s; name a file by its whole path", file,
				 strerror(errno));
	size_t used = strlen(here);
	if (used > 0 && here[used - 1] != '/')
		here[used++] = '/';
	*folder = mem_alloc(used + length + 1, 1);
	if (*folder == NULL)
		return fail_memory("reading the scene");
	memcpy(*folder, here, used);
	memcpy(*folder + used, file, length);
	(*folder)[used + length] = '\0';
	return STATUS_OK;
}
