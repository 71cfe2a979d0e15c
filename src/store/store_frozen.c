/*
 * Reads a store that nobody writes, and makes no file beside it.
 *
 * A writer that was killed leaves a header that says WAL. SQLite then makes FILE-wal and FILE-shm beside it for each reader, and needs a folder
 * that may be written. Where no process has them open, a reader takes one of two other ways:
 *
 * - IMMUTABLE: there is no WAL, or an empty one. The file alone is read.
 * - ASIDE: there is a WAL with pages. Its index is made in memory, under a VFS that neither locks nor writes.
 *
 * Both are right only as long as nobody writes. So a reader keeps what file and WAL looked like. It asks before and after it reads whether
 * they still look so (store_frozen_changed), and connects again where they do not.
 */
#include "store/internal.h"

#include <limits.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#define VFS "furrow-aside"

/* --- what the files look like --- */

static bool look_at(const char *path, const char *suffix, int64_t numbers[STORE_FILE_NUMBERS])
{
	char beside[PATH_MAX + 16];
	struct stat file;
	snprintf(beside, sizeof beside, "%s%s", path, suffix);
	memset(numbers, 0, STORE_FILE_NUMBERS * sizeof *numbers);
	if (stat(beside, &file) != 0)
		return false;
	numbers[0] = (int64_t)file.st_ino;
	numbers[1] = (int64_t)file.st_size;
	numbers[2] = (int64_t)file.st_mtim.tv_sec;
	numbers[3] = (int64_t)file.st_mtim.tv_nsec;
	return true;
}

enum store_way store_frozen_way(const char *path, struct store_frozen *frozen)
{
	int64_t shm[STORE_FILE_NUMBERS];
	*frozen = (struct store_frozen){.is = false};
	look_at(path, "", frozen->file);
	if (!look_at(path, "-wal", frozen->wal))
		return STORE_IMMUTABLE;
	if (look_at(path, "-shm", shm))
		return STORE_PLAIN;
	return frozen->wal[1] == 0 ? STORE_IMMUTABLE : STORE_ASIDE;
}

bool store_frozen_changed(const char *path, const struct store_frozen *frozen)
{
	int64_t file[STORE_FILE_NUMBERS], wal[STORE_FILE_NUMBERS];
	if (!frozen->is)
		return false;
	look_at(path, "", file);
	look_at(path, "-wal", wal);
	return memcmp(file, frozen->file, sizeof file) != 0 || memcmp(wal, frozen->wal, sizeof wal) != 0;
}

bool store_frozen_says_wal(sqlite3 *db)
{
	sqlite3_file *file = NULL;
	unsigned char versions[2] = {0, 0};
	if (sqlite3_file_control(db, "main", SQLITE_FCNTL_FILE_POINTER, &file) != SQLITE_OK || file == NULL || file->pMethods == NULL)
		return false;
	return file->pMethods->xRead(file, versions, sizeof versions, 18) == SQLITE_OK && versions[1] == 2;
}

/* --- the VFS --- */

/* A file of the VFS below, which lies behind this struct. */
struct aside {
	sqlite3_file head;
};

static sqlite3_file *below(sqlite3_file *file)
{
	return (sqlite3_file *)((struct aside *)file + 1);
}

static int aside_close(sqlite3_file *file)
{
	return below(file)->pMethods->xClose(below(file));
}

static int aside_read(sqlite3_file *file, void *bytes, int count, sqlite3_int64 at)
{
	return below(file)->pMethods->xRead(below(file), bytes, count, at);
}

static int aside_write(sqlite3_file *file, const void *bytes, int count, sqlite3_int64 at)
{
	return SQLITE_READONLY;
}

static int aside_truncate(sqlite3_file *file, sqlite3_int64 size)
{
	return SQLITE_READONLY;
}

static int aside_sync(sqlite3_file *file, int flags)
{
	return SQLITE_OK;
}

static int aside_size(sqlite3_file *file, sqlite3_int64 *size)
{
	return below(file)->pMethods->xFileSize(below(file), size);
}

static int aside_lock(sqlite3_file *file, int lock)
{
	return SQLITE_OK;
}

static int aside_reserved(sqlite3_file *file, int *reserved)
{
	*reserved = 0;
	return SQLITE_OK;
}

static int aside_control(sqlite3_file *file, int what, void *argument)
{
	return SQLITE_NOTFOUND;
}

static int aside_sector(sqlite3_file *file)
{
	return below(file)->pMethods->xSectorSize(below(file));
}

static int aside_characteristics(sqlite3_file *file)
{
	return below(file)->pMethods->xDeviceCharacteristics(below(file));
}

static const sqlite3_io_methods methods = {
	.iVersion = 1,
	.xClose = aside_close,
	.xRead = aside_read,
	.xWrite = aside_write,
	.xTruncate = aside_truncate,
	.xSync = aside_sync,
	.xFileSize = aside_size,
	.xLock = aside_lock,
	.xUnlock = aside_lock,
	.xCheckReservedLock = aside_reserved,
	.xFileControl = aside_control,
	.xSectorSize = aside_sector,
	.xDeviceCharacteristics = aside_characteristics,
};

/* Temporary files are those of the VFS below. */
static int aside_open(sqlite3_vfs *vfs, const char *path, sqlite3_file *file, int flags, int *opened)
{
	sqlite3_vfs *real = vfs->pAppData;
	if (!(flags & (SQLITE_OPEN_MAIN_DB | SQLITE_OPEN_WAL)))
		return real->xOpen(real, path, file, flags, opened);
	flags = (flags & ~(SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE)) | SQLITE_OPEN_READONLY;
	int code = real->xOpen(real, path, below(file), flags, opened);
	file->pMethods = code == SQLITE_OK ? &methods : NULL;
	return code;
}

/* SQLite removes a WAL that it is done with. This one is not its own. */
static int aside_delete(sqlite3_vfs *vfs, const char *path, int sync)
{
	return SQLITE_OK;
}

static void register_once(void)
{
	static sqlite3_vfs aside;
	sqlite3_vfs *real = sqlite3_vfs_find(NULL);
	if (real == NULL)
		return;
	aside = *real;
	aside.zName = VFS;
	aside.pNext = NULL;
	aside.pAppData = real;
	aside.szOsFile = (int)sizeof(struct aside) + real->szOsFile;
	aside.xOpen = aside_open;
	aside.xDelete = aside_delete;
	sqlite3_vfs_register(&aside, 0);
}

const char *store_frozen_vfs(void)
{
	static pthread_once_t once = PTHREAD_ONCE_INIT;
	pthread_once(&once, register_once);
	return VFS;
}
