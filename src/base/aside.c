#include "base/aside.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "base/memory.h"

enum status aside_name(struct aside *aside, const char *path)
{
	size_t room = strlen(path) + sizeof ".part";
	*aside = (struct aside){.path = path, .part = mem_alloc(room, 1)};
	if (aside->part == NULL)
		return fail_memory(path);
	snprintf(aside->part, room, "%s.part", path);
	return STATUS_OK;
}

enum status aside_begin(struct aside *aside, const char *path)
{
	enum status status = aside_name(aside, path);
	if (status != STATUS_OK)
		return status;
	aside->file = fopen(aside->part, "w");
	aside->begun = aside->file != NULL;
	return aside->begun ? STATUS_OK
			    : fail_with(STATUS_FAILED, "%s: %s; give a file that can be written", aside->path, strerror(errno));
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
	if (status == STATUS_OK)
		status = aside_whole(aside, synced);
	if (status == STATUS_OK)
		status = aside_publish(aside);
	aside_finish(aside);
	return status;
}
