#include "base/aside.h"
#include "base/limits.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/input.h"
#include "base/memory.h"

enum status aside_name(struct aside *aside, const char *path)
{
	size_t room = strlen(path) + sizeof ".part";
	*aside = (struct aside){.path = path, .part = mem_alloc(room, 1)};
	TRY_MEM(aside->part, path);
	snprintf(aside->part, room, "%s.part", path);
	return STATUS_OK;
}

/* Returns the folder of a file, as a length of its path. 0: it is the present one. */
static int folder_length(const char *path)
{
	const char *slash = strrchr(path, '/');
	return slash == NULL ? 0 : slash == path ? 1 : (int)(slash - path);
}

/* Fails for what cannot be opened, by errno. `file`: the name of what was to be opened for the file at `path`. */
static enum status fail_open(enum status status, const char *path, const char *file, int reason)
{
	const int folder = folder_length(path);
	if (reason == ENOENT && folder > 0)
		return fail_with(status, "%s: the folder %.*s is not there; make it, or give a file in another", path, folder, path);
	errno = reason;
	if (reason == ELOOP) /* the link is to be removed, so it is named */
		return fail_with(status, "%s: %s: %s; give a file that can be written", path, file, input_problem());
	return fail_with(status, "%s: %s; %s", path, input_problem(), limits_advice(reason, "give a file that can be written"));
}

/* A device or a pipe: a renamed file would take its place. errno stays: callers look at that of what they do. */
static bool is_special(const char *path)
{
	const int before = errno;
	struct stat file;
	const bool special = stat(path, &file) == 0 && !S_ISREG(file.st_mode) && !S_ISDIR(file.st_mode);
	errno = before;
	return special;
}

static enum status fail_special(enum status status, const char *path)
{
	return fail_with(status, "%s: is a device or a pipe, and would be replaced; give a file", path);
}

enum status aside_check(const char *path)
{
	char folder[4096];
	struct stat file;
	if (is_special(path))
		return fail_special(STATUS_INPUT, path);
	if (stat(path, &file) == 0 && S_ISDIR(file.st_mode))
		return fail_open(STATUS_INPUT, path, path, EISDIR);
	const int length = folder_length(path);
	if (length >= (int)sizeof folder)
		return fail_open(STATUS_INPUT, path, path, ENAMETOOLONG);
	snprintf(folder, sizeof folder, "%.*s", length > 0 ? length : 1, length > 0 ? path : ".");
	return access(folder, W_OK | X_OK) == 0 ? STATUS_OK : fail_open(STATUS_INPUT, path, path, errno);
}

enum status aside_begin(struct aside *aside, const char *path)
{
	*aside = (struct aside){.path = NULL};
	if (is_special(path))
		return fail_special(STATUS_FAILED, path);
	TRY(aside_name(aside, path));
	const int file = output_create(aside->part, O_WRONLY | O_TRUNC);
	aside->file = file >= 0 ? fdopen(file, "w") : NULL;
	aside->begun = aside->file != NULL;
	if (aside->begun)
		return STATUS_OK;
	const enum status status = fail_open(STATUS_FAILED, aside->path, aside->part, errno);
	if (file >= 0)
		close(file);
	aside_finish(aside);
	return status;
}

enum status aside_whole(struct aside *aside, bool synced)
{
	FILE *file = aside->file;
	bool written = !ferror(file) && fflush(file) == 0 && (!synced || fsync(fileno(file)) == 0);
	int reason = errno;
	aside->file = NULL;
	if (fclose(file) != 0 && written) {
		written = false;
		reason = errno;
	}
	return written ? STATUS_OK
		       : fail_with(STATUS_FAILED, "%s: cannot be written: %s; free some disk space", aside->path,
				   strerror(reason));
}

enum status aside_publish(struct aside *aside)
{
	if (rename(aside->part, aside->path) != 0)
		return fail_with(STATUS_FAILED, "%s: cannot be put in place: %s; check the folder's permissions",
				 aside->path, strerror(errno));
	aside->begun = false;
	return STATUS_OK;
}

void aside_finish(struct aside *aside)
{
	if (aside->file != NULL)
		fclose(aside->file);
	if (aside->begun)
		(void)unlink(aside->part);
	mem_free(aside->part);
	*aside = (struct aside){.path = NULL};
}

enum status aside_end(struct aside *aside, bool synced, enum status status)
{
	TRY_OR(done, status);
	TRY_OR(done, aside_whole(aside, synced));
	TRY_OR(done, aside_publish(aside));
done:
	aside_finish(aside);
	return status;
}
