#include "fault_vfs.h"

#include <assert.h>
#include <errno.h>
#include <sqlite3.h>
#include <stdatomic.h>
#include <string.h>

#include "base/base.h"
#include "calls.h"

static sqlite3_vfs *real, shim;
static sqlite3_mem_methods real_memory;
static _Atomic int armed;
static _Atomic uint64_t made, failing;
static _Atomic bool failing_forever;

static bool hit(enum fault_kind kind)
{
	if (atomic_load(&armed) != (int)kind)
		return false;
	uint64_t number = atomic_fetch_add(&made, 1) + 1, nth = atomic_load(&failing);
	return number == nth || (number > nth && atomic_load(&failing_forever));
}

void fault_arm(enum fault_kind kind, uint64_t nth, bool forever)
{
	atomic_store(&made, 0);
	atomic_store(&failing, nth);
	atomic_store(&failing_forever, forever);
	mem_fail_nth(kind == FAULT_MEMORY ? nth : 0, forever);
	atomic_store(&armed, (int)kind);
}

uint64_t fault_disarm(void)
{
	int kind = atomic_exchange(&armed, FAULT_NONE);
	uint64_t allocations = mem_fail_nth(0, 0);
	return kind == FAULT_MEMORY ? allocations : atomic_load(&made);
}

const char *fault_name(enum fault_kind kind)
{
	static const char *const names[] = {
		"none",	   "read",   "write",	 "write: disk full", "torn write",    "sync",
		"truncate", "open",   "delete", "access",	     "size",	      "lock",
		"shared",   "own open", "own sync", "own rename",	     "own unlink", "memory",
		"SQLite's memory", "short read",
	};
	return names[kind];
}

/* --- files --- */

struct file {
	sqlite3_file base;
	sqlite3_file *real; /* behind this */
};

static sqlite3_file *real_of(sqlite3_file *file)
{
	return ((struct file *)file)->real;
}

static int file_close(sqlite3_file *file)
{
	return real_of(file)->pMethods->xClose(real_of(file));
}

static int file_read(sqlite3_file *file, void *bytes, int count, sqlite3_int64 at)
{
	if (hit(FAULT_READ))
		return SQLITE_IOERR_READ;
	int code = real_of(file)->pMethods->xRead(real_of(file), bytes, count, at);
	if (code == SQLITE_OK && hit(FAULT_SHORT_READ)) {
		memset((char *)bytes + count / 2, 0, (size_t)(count - count / 2));
		return SQLITE_IOERR_SHORT_READ;
	}
	return code;
}

static int file_write(sqlite3_file *file, const void *bytes, int count, sqlite3_int64 at)
{
	if (hit(FAULT_WRITE))
		return SQLITE_IOERR_WRITE;
	if (hit(FAULT_FULL))
		return SQLITE_FULL;
	if (hit(FAULT_TORN_WRITE)) {
		real_of(file)->pMethods->xWrite(real_of(file), bytes, count / 2, at);
		return SQLITE_IOERR_WRITE;
	}
	return real_of(file)->pMethods->xWrite(real_of(file), bytes, count, at);
}

static int file_truncate(sqlite3_file *file, sqlite3_int64 size)
{
	return hit(FAULT_TRUNCATE) ? SQLITE_IOERR_TRUNCATE : real_of(file)->pMethods->xTruncate(real_of(file), size);
}

static int file_sync(sqlite3_file *file, int flags)
{
	return hit(FAULT_SYNC) ? SQLITE_IOERR_FSYNC : SQLITE_OK;
}

static int file_size(sqlite3_file *file, sqlite3_int64 *size)
{
	return hit(FAULT_SIZE) ? SQLITE_IOERR_FSTAT : real_of(file)->pMethods->xFileSize(real_of(file), size);
}

static int file_lock(sqlite3_file *file, int level)
{
	return hit(FAULT_LOCK) ? SQLITE_IOERR_LOCK : real_of(file)->pMethods->xLock(real_of(file), level);
}

static int file_unlock(sqlite3_file *file, int level)
{
	return real_of(file)->pMethods->xUnlock(real_of(file), level);
}

static int file_check_lock(sqlite3_file *file, int *reserved)
{
	return hit(FAULT_LOCK) ? SQLITE_IOERR_CHECKRESERVEDLOCK
			       : real_of(file)->pMethods->xCheckReservedLock(real_of(file), reserved);
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
	return hit(FAULT_SHARED) ? SQLITE_IOERR_SHMMAP
				 : real_of(file)->pMethods->xShmMap(real_of(file), page, size, extend, memory);
}

static int file_shared_lock(sqlite3_file *file, int first, int count, int flags)
{
	if ((flags & SQLITE_SHM_LOCK) && hit(FAULT_SHARED))
		return SQLITE_IOERR_SHMLOCK;
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
	.iVersion = 2, /* no mapping of the file itself: every read is seen */
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

/* --- names --- */

static int shim_open(sqlite3_vfs *vfs, const char *name, sqlite3_file *file, int flags, int *out)
{
	struct file *opened = (struct file *)file;
	opened->base.pMethods = NULL;
	opened->real = (sqlite3_file *)(opened + 1);
	if (hit(FAULT_OPEN))
		return SQLITE_CANTOPEN;
	int code = real->xOpen(real, name, opened->real, flags, out);
	if (opened->real->pMethods != NULL)
		opened->base.pMethods = &methods;
	return code;
}

static int shim_delete(sqlite3_vfs *vfs, const char *name, int sync)
{
	return hit(FAULT_DELETE) ? SQLITE_IOERR_DELETE : real->xDelete(real, name, 0);
}

static int shim_access(sqlite3_vfs *vfs, const char *name, int flags, int *out)
{
	return hit(FAULT_ACCESS) ? SQLITE_IOERR_ACCESS : real->xAccess(real, name, flags, out);
}

/* --- SQLite's memory --- */

static void *memory_alloc(int size)
{
	return hit(FAULT_SQLITE_MEMORY) ? NULL : real_memory.xMalloc(size);
}

static void *memory_realloc(void *memory, int size)
{
	return hit(FAULT_SQLITE_MEMORY) ? NULL : real_memory.xRealloc(memory, size);
}

/* --- the store's own calls --- */

static int call_open(const char *path, int flags, mode_t mode)
{
	if (!hit(FAULT_CALL_OPEN))
		return calls_real.open(path, flags, mode);
	errno = EACCES;
	return -1;
}

static int call_fsync(int file)
{
	errno = EIO;
	return hit(FAULT_CALL_SYNC) ? -1 : 0;
}

static int call_rename(const char *from, const char *to)
{
	if (!hit(FAULT_CALL_RENAME))
		return calls_real.rename(from, to);
	errno = EIO;
	return -1;
}

static int call_unlink(const char *path)
{
	if (!hit(FAULT_CALL_UNLINK))
		return calls_real.unlink(path);
	errno = EIO;
	return -1;
}

void fault_install(void)
{
	static const struct calls calls = {call_open, call_fsync, call_rename, call_unlink};
	int code = sqlite3_config(SQLITE_CONFIG_GETMALLOC, &real_memory);
	assert(code == SQLITE_OK);
	sqlite3_mem_methods memory = real_memory;
	memory.xMalloc = memory_alloc;
	memory.xRealloc = memory_realloc;
	code = sqlite3_config(SQLITE_CONFIG_MALLOC, &memory);
	assert(code == SQLITE_OK);
	real = sqlite3_vfs_find(NULL);
	shim = *real;
	shim.szOsFile = (int)sizeof(struct file) + real->szOsFile;
	shim.zName = "fault";
	shim.xOpen = shim_open;
	shim.xDelete = shim_delete;
	shim.xAccess = shim_access;
	code = sqlite3_vfs_register(&shim, 1);
	assert(code == SQLITE_OK);
	(void)code;
	calls_now = &calls;
}
