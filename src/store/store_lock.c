/*
 * Makes sure that a store has only one writer. The writer locks a file beside the store. The kernel releases this lock when the
 * process ends.
 *
 * The store itself is not locked: closing any descriptor of it would release SQLite's own locks. The writer removes the lock file
 * at the end. So a process that has locked a removed file must start again.
 */
#include "store/internal.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

static bool still_there(const char *lock_path, int descriptor)
{
	struct stat held, named;
	return fstat(descriptor, &held) == 0 && stat(lock_path, &named) == 0 &&
	       held.st_ino == named.st_ino && held.st_dev == named.st_dev;
}

enum status store_lock_try(const char *lock_path, const char *named, int *descriptor, bool *taken)
{
	*taken = false;
	for (;;) {
		int lock = output_create(lock_path, O_RDWR | O_NONBLOCK);
		if (lock < 0)
			return fail_with(STATUS_FAILED, errno == ELOOP ? "%s: cannot be written: %s: %s; remove that link" :
					 "%s: cannot be written: %s: %s; make its folder writable", named, lock_path, input_problem());
		if (flock(lock, LOCK_EX | LOCK_NB) != 0) {
			int error = errno;
			close(lock);
			if (error == EINTR)
				continue;
			if (error == EWOULDBLOCK)
				return STATUS_OK;
			return fail_with(STATUS_FAILED, "%s: cannot be locked: %s; use a file system with locks",
					 named, strerror(error));
		}
		if (still_there(lock_path, lock)) {
			*descriptor = lock;
			*taken = true;
			return STATUS_OK;
		}
		close(lock);
	}
}

enum status store_lock_take(const char *lock_path, const char *named, int *descriptor)
{
	bool taken;
	enum status status = store_lock_try(lock_path, named, descriptor, &taken);
	return status != STATUS_OK || taken ? status : fail_with(STATUS_FAILED, "%s: another process is writing it; wait for it to end", named);
}

void store_lock_drop(const char *lock_path, int descriptor)
{
	if (descriptor < 0)
		return;
	unlink(lock_path); /* while it is held; a failure leaves an empty file that locks nothing */
	close(descriptor);
}
