/*
 * Makes sure that a store has only one writer. The writer locks a file beside the store. The kernel releases this lock when the
 * process ends.
 *
 * The store itself is not locked: closing any descriptor of it would release SQLite's own locks. The writer removes the lock file
 * at the end. So a process that has locked a removed file must start again.
 *
 * Who finds a lock taken wants to know whether to wait for another process. So this process keeps a list of the locks that it has.
 */
#include "store/internal.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* --- the locks of this process --- */

struct held {
	dev_t device;
	ino_t file;
	pid_t process; /* a child by fork inherits the list, and not the locks */
	struct held *next;
};

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static struct held *all;

/* Returns where the lock's entry hangs; if there is none, the list's end. */
static struct held **find_locked(const struct stat *file)
{
	struct held **at = &all;
	while (*at != NULL && ((*at)->device != file->st_dev || (*at)->file != file->st_ino))
		at = &(*at)->next;
	return at;
}

static enum status note_held(int lock)
{
	struct stat file;
	if (fstat(lock, &file) != 0)
		return STATUS_OK; /* then only a message is less exact */
	struct held *held = mem_calloc(1, sizeof *held);
	TRY_MEM(held, "a store's lock");
	*held = (struct held){.device = file.st_dev, .file = file.st_ino, .process = getpid()};
	pthread_mutex_lock(&mutex);
	held->next = all;
	all = held;
	pthread_mutex_unlock(&mutex);
	return STATUS_OK;
}

static void forget_held(int lock)
{
	struct stat file;
	if (fstat(lock, &file) != 0)
		return;
	pthread_mutex_lock(&mutex);
	struct held **at = find_locked(&file), *held = *at;
	if (held != NULL)
		*at = held->next;
	pthread_mutex_unlock(&mutex);
	mem_free(held);
}

static bool is_own(const char *lock_path)
{
	struct stat file;
	if (stat(lock_path, &file) != 0)
		return false;
	pthread_mutex_lock(&mutex);
	const struct held *held = *find_locked(&file);
	const bool own = held != NULL && held->process == getpid();
	pthread_mutex_unlock(&mutex);
	return own;
}

/* --- locking --- */

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
					 "%s: cannot be written: %s: %s; make its folder writable, or only look at it (readonly)", named, lock_path, input_problem());
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
			const enum status status = note_held(lock);
			if (status != STATUS_OK) {
				store_lock_drop(lock_path, lock);
				return status;
			}
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
	TRY(store_lock_try(lock_path, named, descriptor, &taken));
	if (taken)
		return STATUS_OK;
	if (is_own(lock_path))
		return fail_with(STATUS_FAILED, "%s: this process has it open for writing already; close that world or end that import first, or open it "
						"readonly", named);
	return fail_with(STATUS_FAILED, "%s: another process is writing it; wait for it to end, or only look at it (readonly)", named);
}

void store_lock_drop(const char *lock_path, int descriptor)
{
	if (descriptor < 0)
		return;
	forget_held(descriptor);
	if (lock_path != NULL)
		unlink(lock_path); /* while it is held; a failure leaves an empty file that locks nothing */
	close(descriptor);
}
