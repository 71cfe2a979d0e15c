/* The folder of a run: makes it, locks it, and removes the files of an earlier run. */
#define _GNU_SOURCE /* nftw */
#include <errno.h>
#include <ftw.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "api/internal.h"

enum status api_folder_make(const char *path)
{
	struct stat found;
	if (mkdir(path, 0777) != 0 && errno != EEXIST)
		return fail_with(STATUS_FAILED, "%s: %s; give a folder that can be made", path, strerror(errno));
	if (stat(path, &found) != 0 || !S_ISDIR(found.st_mode))
		return fail_with(STATUS_FAILED, "%s: is not a folder; give another", path);
	return STATUS_OK;
}

/* The log also shows that a run writes into this folder. Its lock ends with the process. */
enum status api_folder_commits(const char *directory, FILE **out)
{
	char path[4096];
	snprintf(path, sizeof path, "%s/epochs.log", directory);
	*out = fopen(path, "a+");
	if (*out == NULL)
		return fail_with(STATUS_FAILED, "%s: %s; give a folder that can be written", path, strerror(errno));
	if (flock(fileno(*out), LOCK_EX | LOCK_NB) == 0)
		return STATUS_OK;
	fclose(*out);
	*out = NULL;
	return fail_with(STATUS_FAILED, "%s: another drive writes into this folder; give another, or wait for it to end", directory);
}

enum status api_folder_clear(const struct world *world, const char *directory)
{
	char path[4096];
	FILE *commit_log = world->commit_log;
	long whole = 0;
	for (int c; world->resumed.is && (c = getc(commit_log)) != EOF;) /* a kill may have torn the last line */
		if (c == '\n')
			whole = ftell(commit_log);
	if (whole < 0 || ferror(commit_log) || ftruncate(fileno(commit_log), whole) != 0)
		return fail_with(STATUS_FAILED, "%s/epochs.log: %s; give a folder that can be written", directory, strerror(errno));
	rewind(commit_log);
	snprintf(path, sizeof path, "%s/run.json", directory);
	unlink(path);
	snprintf(path, sizeof path, "%s/map.png", directory);
	unlink(path);
	return STATUS_OK;
}

static int remove_entry(const char *path, const struct stat *stats, int kind, struct FTW *where)
{
	(void)stats, (void)kind, (void)where;
	(void)remove(path);
	return 0;
}

void api_folder_remove(const char *directory)
{
	(void)nftw(directory, remove_entry, 16, FTW_DEPTH | FTW_PHYS);
}
