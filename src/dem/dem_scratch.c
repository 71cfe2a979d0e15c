/* Makes and uses the temporary files of dem. They are in the folder TMPDIR, or in /tmp. */
#define _GNU_SOURCE
#include "dem_scratch.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char *folder(void)
{
	const char *named = getenv("TMPDIR");
	return named != NULL && named[0] != '\0' ? named : "/tmp";
}

enum status dem_scratch_open(struct dem_scratch *scratch, const char *doing)
{
	char name[512];
	int length = snprintf(name, sizeof name, "%s/furrow-XXXXXX", folder());
	errno = ENAMETOOLONG;
	scratch->file = length < (int)sizeof name ? mkostemp(name, O_CLOEXEC) : -1;
	if (scratch->file < 0)
		return fail_with(STATUS_FAILED, "%s: no temporary file in %s: %s; set TMPDIR to a folder with room", doing,
				 folder(), strerror(errno));
	(void)unlink(name); /* without a name the file exists only as long as it is open */
	return STATUS_OK;
}

void dem_scratch_close(struct dem_scratch *scratch)
{
	if (scratch->file >= 0)
		close(scratch->file);
	scratch->file = -1;
}

static enum status failed(const char *why)
{
	return fail_with(STATUS_FAILED, "%s: the temporary file failed: %s; make room there, or set TMPDIR to a folder "
			 "with room", folder(), why);
}

enum status dem_scratch_move(const struct dem_scratch *scratch, bool write, void *data, size_t bytes, int64_t offset)
{
	for (char *at = data; bytes > 0;) {
		ssize_t done = write ? pwrite(scratch->file, at, bytes, (off_t)offset)
				     : pread(scratch->file, at, bytes, (off_t)offset);
		if (done < 0 && errno == EINTR)
			continue;
		if (done <= 0)
			return failed(done < 0 ? strerror(errno) : write ? "it takes no more" : "it ends early");
		at += done;
		bytes -= (size_t)done;
		offset += done;
	}
	return STATUS_OK;
}
