#include "aside.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

enum status aside_begin(struct aside *aside, const char *path)
{
	size_t room = strlen(path) + sizeof ".part";
	char *part = mem_alloc(room, 1);
	if (part == NULL)
		return fail_memory(path);
	snprintf(part, room, "%s.part", path);
	FILE *file = fopen(part, "w");
	if (file == NULL) {
		enum status status = fail_with(STATUS_FAILED, "%s: %s; give a file that can be written", path,
					       strerror(errno));
		mem_free(part);
		return status;
	}
	*aside = (struct aside){path, part, file};
	return STATUS_OK;
}

enum status aside_whole(struct aside *aside)
{
	FILE *file = aside->file;
	bool written = !ferror(file) && fflush(file) == 0 && fsync(fileno(file)) == 0;
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
	mem_free(aside->part);
	aside->part = NULL;
	return STATUS_OK;
}

void aside_finish(struct aside *aside)
{
	if (aside->file != NULL)
		fclose(aside->file);
	if (aside->part != NULL)
		(void)unlink(aside->part);
	mem_free(aside->part);
}
