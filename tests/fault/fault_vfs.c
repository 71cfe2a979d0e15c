#include "fault_vfs.h"

#include <assert.h>
#include <errno.h>
#include <sqlite3.h>
#include <stdatomic.h>
#include <string.h>

#include "base/base.h"
#include "calls.h"
#include "through.h"

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

static int file_read(sqlite3_file *file, void *bytes, int count, sqlite3_int64 at)
{
	if (hit(FAULT_READ))
		return SQLITE_IOERR_READ;
	int code = through_methods.xRead(file, bytes, count, at);
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
		through_methods.xWrite(file, bytes, count / 2, at);
		return SQLITE_IOERR_WRITE;
	}
	return through_methods.xWrite(file, bytes, count, at);
}

static int file_truncate(sqlite3_file *file, sqlite3_int64 size)
{
	return hit(FAULT_TRUNCATE) ? SQLITE_IOERR_TRUNCATE : through_methods.xTruncate(file, size);
}

static int file_sync(sqlite3_file *file, int flags)
{
	return hit(FAULT_SYNC) ? SQLITE_IOERR_FSYNC : SQLITE_OK;
}

static int file_size(sqlite3_file *file, sqlite3_int64 *size)
{
	return hit(FAULT_SIZE) ? SQLITE_IOERR_FSTAT : through_methods.xFileSize(file, size);
}

static int file_lock(sqlite3_file *file, int level)
{
	return hit(FAULT_LOCK) ? SQLITE_IOERR_LOCK : through_methods.xLock(file, level);
}

static int file_check_lock(sqlite3_file *file, int *reserved)
{
	return hit(FAULT_LOCK) ? SQLITE_IOERR_CHECKRESERVEDLOCK
			       : through_methods.xCheckReservedLock(file, reserved);
}

static int file_shared_map(sqlite3_file *file, int page, int size, int extend, void volatile **memory)
{
	return hit(FAULT_SHARED) ? SQLITE_IOERR_SHMMAP
				 : through_methods.xShmMap(file, page, size, extend, memory);
}

static int file_shared_lock(sqlite3_file *file, int first, int count, int flags)
{
	if ((flags & SQLITE_SHM_LOCK) && hit(FAULT_SHARED))
		return SQLITE_IOERR_SHMLOCK;
	return through_methods.xShmLock(file, first, count, flags);
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
	methods.xCheckReservedLock = file_check_lock;
	methods.xShmMap = file_shared_map;
	methods.xShmLock = file_shared_lock;
}

/* --- names --- */

static int shim_open(sqlite3_vfs *vfs, const char *name, sqlite3_file *file, int flags, int *out)
{
	struct through *opened = (struct through *)file;
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
	make_methods();
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
	shim.szOsFile = (int)sizeof(struct through) + real->szOsFile;
	shim.zName = "fault";
	shim.xOpen = shim_open;
	shim.xDelete = shim_delete;
	shim.xAccess = shim_access;
	code = sqlite3_vfs_register(&shim, 1);
	assert(code == SQLITE_OK);
	(void)code;
	calls_now = &calls;
}
