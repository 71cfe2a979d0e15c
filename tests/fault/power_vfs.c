/*
 * Invariants: (1) the folder's files themselves are as the program sees them; only the disk knows
 * what was synced; (2) what is done to a file of the folder is done to the disk first, and to the
 * file only if the power did not go with it.
 */
#include "power_vfs.h"

#include <assert.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <sqlite3.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "calls.h"
#include "power_disk.h"
#include "through.h"

static sqlite3_vfs *real, shim;
static bool kept; /* between begin and end */
static char folder[128];

static bool stopped(void)
{
	return kept && power_disk_stopped();
}

/* In the folder, or NULL; always NULL when nothing is kept. */
static const char *name_in_folder(const char *path)
{
	size_t length = strlen(folder);
	if (!kept || path == NULL || strncmp(path, folder, length) != 0 || path[length] != '/')
		return NULL;
	return path + length + 1;
}

/* The same, of a file that is there. */
static const char *name_of_file(const char *path)
{
	const char *name = name_in_folder(path);
	return name != NULL && power_disk_find(name) >= 0 ? name : NULL;
}

/* The same, of a file that is not there yet. */
static const char *name_to_make(const char *path)
{
	const char *name = name_in_folder(path);
	return name != NULL && power_disk_find(name) < 0 ? name : NULL;
}

/* --- files of SQLite --- */

struct file {
	struct through through;
	int inode; /* -1: not kept */
};

static struct file *file_of(sqlite3_file *file)
{
	return (struct file *)file;
}

static bool is_kept(sqlite3_file *file)
{
	return kept && file_of(file)->inode >= 0;
}

static int file_read(sqlite3_file *file, void *bytes, int count, sqlite3_int64 at)
{
	return stopped() ? SQLITE_IOERR_READ : through_methods.xRead(file, bytes, count, at);
}

static int file_write(sqlite3_file *file, const void *bytes, int count, sqlite3_int64 at)
{
	if (stopped())
		return SQLITE_IOERR_WRITE;
	if (is_kept(file) && !power_disk_write(file_of(file)->inode, (size_t)at, (size_t)count, bytes))
		return SQLITE_IOERR_WRITE;
	return through_methods.xWrite(file, bytes, count, at);
}

static int file_truncate(sqlite3_file *file, sqlite3_int64 size)
{
	if (stopped())
		return SQLITE_IOERR_TRUNCATE;
	if (is_kept(file) && !power_disk_truncate(file_of(file)->inode, (size_t)size))
		return SQLITE_IOERR_TRUNCATE;
	return through_methods.xTruncate(file, size);
}

static int file_sync(sqlite3_file *file, int flags)
{
	if (stopped())
		return SQLITE_IOERR_FSYNC;
	if (is_kept(file) && !power_disk_sync(file_of(file)->inode, POWER_SQLITE))
		return SQLITE_IOERR_FSYNC;
	return SQLITE_OK;
}

static int file_size(sqlite3_file *file, sqlite3_int64 *size)
{
	return stopped() ? SQLITE_IOERR_FSTAT : through_methods.xFileSize(file, size);
}

static int file_lock(sqlite3_file *file, int level)
{
	return stopped() ? SQLITE_IOERR_LOCK : through_methods.xLock(file, level);
}

static sqlite3_io_methods methods;

static void make_methods(void)
{
	methods = through_methods;
	methods.xRead = file_read;
	methods.xWrite = file_write;
	methods.xTruncate = file_truncate;
	methods.xSync = file_sync;
	methods.xFileSize = file_size;
	methods.xLock = file_lock;
}

static int shim_open(sqlite3_vfs *vfs, const char *path, sqlite3_file *file, int flags, int *out)
{
	struct file *opened = (struct file *)file;
	*opened = (struct file){.through.real = (sqlite3_file *)(opened + 1), .inode = -1};
	if (stopped())
		return SQLITE_CANTOPEN;
	const char *made = (flags & SQLITE_OPEN_CREATE) != 0 ? name_to_make(path) : NULL;
	if (made != NULL && !power_disk_make(made, POWER_SQLITE))
		return SQLITE_CANTOPEN;
	const char *name = name_in_folder(path);
	if (name != NULL)
		opened->inode = power_disk_find(name);
	int code = real->xOpen(real, path, opened->through.real, flags, out);
	if (opened->through.real->pMethods != NULL)
		opened->through.base.pMethods = &methods;
	return code;
}

static int shim_delete(sqlite3_vfs *vfs, const char *path, int sync)
{
	if (stopped())
		return SQLITE_IOERR_DELETE;
	const char *name = name_of_file(path);
	if (name != NULL && !power_disk_remove(name, sync != 0))
		return SQLITE_IOERR_DELETE;
	return real->xDelete(real, path, 0);
}

static int shim_access(sqlite3_vfs *vfs, const char *path, int flags, int *out)
{
	return stopped() ? SQLITE_IOERR_ACCESS : real->xAccess(real, path, flags, out);
}

/* --- the store's own calls --- */

static int call_stopped(void)
{
	errno = EIO;
	return -1;
}

static int call_open(const char *path, int flags, mode_t mode)
{
	if (stopped())
		return call_stopped();
	const char *made = (flags & O_CREAT) != 0 ? name_to_make(path) : NULL;
	if (made != NULL && !power_disk_make(made, POWER_STORE))
		return call_stopped();
	return calls_real.open(path, flags, mode);
}

static int call_fsync(int file)
{
	char link[64], path[512];
	if (stopped())
		return call_stopped();
	snprintf(link, sizeof link, "/proc/self/fd/%d", file);
	ssize_t length = readlink(link, path, sizeof path - 1);
	assert(length > 0);
	path[length] = '\0';
	const char *name = name_in_folder(path);
	if (kept && strcmp(path, folder) == 0)
		return power_disk_sync_names() ? 0 : call_stopped();
	if (name != NULL)
		return power_disk_sync(power_disk_find(name), POWER_STORE) ? 0 : call_stopped();
	return 0;
}

static int call_rename(const char *from, const char *to)
{
	const char *old = name_in_folder(from), *new = name_in_folder(to);
	if (stopped())
		return call_stopped();
	if (old != NULL && new != NULL && !power_disk_rename(old, new))
		return call_stopped();
	return calls_real.rename(from, to);
}

static int call_unlink(const char *path)
{
	if (stopped())
		return call_stopped();
	const char *name = name_of_file(path);
	if (name != NULL && !power_disk_remove(name, false))
		return call_stopped();
	return calls_real.unlink(path);
}

/* --- life --- */

void power_install(void)
{
	make_methods();
	static const struct calls calls = {call_open, call_fsync, call_rename, call_unlink};
	real = sqlite3_vfs_find(NULL);
	shim = *real;
	shim.szOsFile = (int)sizeof(struct file) + real->szOsFile;
	shim.zName = "power";
	shim.xOpen = shim_open;
	shim.xDelete = shim_delete;
	shim.xAccess = shim_access;
	int code = sqlite3_vfs_register(&shim, 1);
	assert(code == SQLITE_OK);
	(void)code;
	calls_now = &calls;
}

void power_begin(const char *path, uint64_t cut_at)
{
	assert(!kept);
	power_disk_empty(cut_at);
	snprintf(folder, sizeof folder, "%s", path);
	DIR *dir = opendir(folder);
	assert(dir != NULL);
	for (struct dirent *entry; (entry = readdir(dir)) != NULL;) {
		char file[512];
		if (entry->d_name[0] == '.')
			continue;
		snprintf(file, sizeof file, "%s/%s", folder, entry->d_name);
		power_disk_put(entry->d_name, file);
	}
	closedir(dir);
	kept = true;
}

uint64_t power_end(void)
{
	kept = false;
	return power_disk_operations();
}
