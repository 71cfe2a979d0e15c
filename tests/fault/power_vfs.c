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
	sqlite3_file base;
	sqlite3_file *real;
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

static sqlite3_file *real_of(sqlite3_file *file)
{
	return file_of(file)->real;
}

static int file_close(sqlite3_file *file)
{
	return real_of(file)->pMethods->xClose(real_of(file));
}

static int file_read(sqlite3_file *file, void *bytes, int count, sqlite3_int64 at)
{
	return stopped() ? SQLITE_IOERR_READ : real_of(file)->pMethods->xRead(real_of(file), bytes, count, at);
}

static int file_write(sqlite3_file *file, const void *bytes, int count, sqlite3_int64 at)
{
	if (stopped())
		return SQLITE_IOERR_WRITE;
	if (is_kept(file) && !power_disk_write(file_of(file)->inode, (size_t)at, (size_t)count, bytes))
		return SQLITE_IOERR_WRITE;
	return real_of(file)->pMethods->xWrite(real_of(file), bytes, count, at);
}

static int file_truncate(sqlite3_file *file, sqlite3_int64 size)
{
	if (stopped())
		return SQLITE_IOERR_TRUNCATE;
	if (is_kept(file) && !power_disk_truncate(file_of(file)->inode, (size_t)size))
		return SQLITE_IOERR_TRUNCATE;
	return real_of(file)->pMethods->xTruncate(real_of(file), size);
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
	return stopped() ? SQLITE_IOERR_FSTAT : real_of(file)->pMethods->xFileSize(real_of(file), size);
}

static int file_lock(sqlite3_file *file, int level)
{
	return stopped() ? SQLITE_IOERR_LOCK : real_of(file)->pMethods->xLock(real_of(file), level);
}

static int file_unlock(sqlite3_file *file, int level)
{
	return real_of(file)->pMethods->xUnlock(real_of(file), level);
}

static int file_check_lock(sqlite3_file *file, int *reserved)
{
	return real_of(file)->pMethods->xCheckReservedLock(real_of(file), reserved);
}

static int file_control(sqlite3_file *file, int what, void *argument)
{
	return real_of(file)->pMethods->xFileControl(real_of(file), what, argument);
}

static int file_sector(sqlite3_file *file)
{
	return real_of(file)->pMethods->xSectorSize(real_of(file));
}

static int file_device(sqlite3_file *file)
{
	return real_of(file)->pMethods->xDeviceCharacteristics(real_of(file));
}

static int file_shared_map(sqlite3_file *file, int page, int size, int extend, void volatile **memory)
{
	return real_of(file)->pMethods->xShmMap(real_of(file), page, size, extend, memory);
}

static int file_shared_lock(sqlite3_file *file, int first, int count, int flags)
{
	return real_of(file)->pMethods->xShmLock(real_of(file), first, count, flags);
}

static void file_shared_barrier(sqlite3_file *file)
{
	real_of(file)->pMethods->xShmBarrier(real_of(file));
}

static int file_shared_unmap(sqlite3_file *file, int remove)
{
	return real_of(file)->pMethods->xShmUnmap(real_of(file), remove);
}

static const sqlite3_io_methods methods = {
	.iVersion = 2,
	.xClose = file_close,
	.xRead = file_read,
	.xWrite = file_write,
	.xTruncate = file_truncate,
	.xSync = file_sync,
	.xFileSize = file_size,
	.xLock = file_lock,
	.xUnlock = file_unlock,
	.xCheckReservedLock = file_check_lock,
	.xFileControl = file_control,
	.xSectorSize = file_sector,
	.xDeviceCharacteristics = file_device,
	.xShmMap = file_shared_map,
	.xShmLock = file_shared_lock,
	.xShmBarrier = file_shared_barrier,
	.xShmUnmap = file_shared_unmap,
};

static int shim_open(sqlite3_vfs *vfs, const char *path, sqlite3_file *file, int flags, int *out)
{
	struct file *opened = (struct file *)file;
	*opened = (struct file){.real = (sqlite3_file *)(opened + 1), .inode = -1};
	if (stopped())
		return SQLITE_CANTOPEN;
	const char *made = (flags & SQLITE_OPEN_CREATE) != 0 ? name_to_make(path) : NULL;
	if (made != NULL && !power_disk_make(made, POWER_SQLITE))
		return SQLITE_CANTOPEN;
	const char *name = name_in_folder(path);
	if (name != NULL)
		opened->inode = power_disk_find(name);
	int code = real->xOpen(real, path, opened->real, flags, out);
	if (opened->real->pMethods != NULL)
		opened->base.pMethods = &methods;
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
