#include "through.h"

#define REAL(file) through_real(file)->pMethods

static int through_close(sqlite3_file *file)
{
	return REAL(file)->xClose(through_real(file));
}

static int through_read(sqlite3_file *file, void *bytes, int count, sqlite3_int64 at)
{
	return REAL(file)->xRead(through_real(file), bytes, count, at);
}

static int through_write(sqlite3_file *file, const void *bytes, int count, sqlite3_int64 at)
{
	return REAL(file)->xWrite(through_real(file), bytes, count, at);
}

static int through_truncate(sqlite3_file *file, sqlite3_int64 size)
{
	return REAL(file)->xTruncate(through_real(file), size);
}

/* Nothing of a test has to outlive the machine. */
static int through_sync(sqlite3_file *file, int flags)
{
	return SQLITE_OK;
}

static int through_size(sqlite3_file *file, sqlite3_int64 *size)
{
	return REAL(file)->xFileSize(through_real(file), size);
}

static int through_lock(sqlite3_file *file, int level)
{
	return REAL(file)->xLock(through_real(file), level);
}

static int through_unlock(sqlite3_file *file, int level)
{
	return REAL(file)->xUnlock(through_real(file), level);
}

static int through_check_lock(sqlite3_file *file, int *reserved)
{
	return REAL(file)->xCheckReservedLock(through_real(file), reserved);
}

static int through_control(sqlite3_file *file, int what, void *argument)
{
	return REAL(file)->xFileControl(through_real(file), what, argument);
}

static int through_sector(sqlite3_file *file)
{
	return REAL(file)->xSectorSize(through_real(file));
}

static int through_device(sqlite3_file *file)
{
	return REAL(file)->xDeviceCharacteristics(through_real(file));
}

static int through_shared_map(sqlite3_file *file, int page, int size, int extend, void volatile **memory)
{
	return REAL(file)->xShmMap(through_real(file), page, size, extend, memory);
}

static int through_shared_lock(sqlite3_file *file, int first, int count, int flags)
{
	return REAL(file)->xShmLock(through_real(file), first, count, flags);
}

static void through_shared_barrier(sqlite3_file *file)
{
	REAL(file)->xShmBarrier(through_real(file));
}

static int through_shared_unmap(sqlite3_file *file, int remove)
{
	return REAL(file)->xShmUnmap(through_real(file), remove);
}

const sqlite3_io_methods through_methods = {
	.iVersion = 2, /* no mapping of the file itself: every read is seen */
	.xClose = through_close,
	.xRead = through_read,
	.xWrite = through_write,
	.xTruncate = through_truncate,
	.xSync = through_sync,
	.xFileSize = through_size,
	.xLock = through_lock,
	.xUnlock = through_unlock,
	.xCheckReservedLock = through_check_lock,
	.xFileControl = through_control,
	.xSectorSize = through_sector,
	.xDeviceCharacteristics = through_device,
	.xShmMap = through_shared_map,
	.xShmLock = through_shared_lock,
	.xShmBarrier = through_shared_barrier,
	.xShmUnmap = through_shared_unmap,
};
