/*
 * Invariants: (1) the folder's files themselves are as the program sees them; only this memory knows
 * what is on the disk; (2) an operation is kept before it is done, and it is kept when the cut comes
 * with it; (3) a file that has no name any more is kept until the end, since its removal may be
 * undone.
 */
#include "power_vfs.h"

#include <assert.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <sqlite3.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "calls.h"

#define SECTOR 512
#define FILES 64
#define NAMES 256

/* A write, or (bytes NULL) a new size. */
struct change {
	size_t at, size;
	unsigned char *bytes;
};

struct content {
	unsigned char *bytes;
	size_t size;
};

struct inode {
	struct content synced;
	struct change *changes; /* since then */
	size_t count;
	bool names_with_it; /* its next sync is one of the folder too */
};

/* A name that now is a file's, or (-1) nobody's; with it, `was` is nobody's ("": no such name). */
struct name {
	char name[80], was[80];
	int inode;
};

struct names {
	struct name names[NAMES];
	size_t count;
};

static sqlite3_vfs *real, shim;
static bool kept;
static char folder[128];
static struct inode inodes[FILES];
static int inode_count;
static struct names synced_names, live_names, name_changes;
static uint64_t operations, cut;

static bool stopped(void)
{
	return kept && operations >= cut;
}

/* False: the power goes with this one. */
static bool operate(void)
{
	return ++operations < cut;
}

/* --- contents --- */

static void content_resize(struct content *content, size_t size)
{
	if (size > content->size) {
		content->bytes = realloc(content->bytes, size);
		assert(content->bytes != NULL);
		memset(content->bytes + content->size, 0, size - content->size);
	}
	content->size = size;
}

/* Sectors of it for which `torn` has a bit, all of them with 0. */
static void content_apply(struct content *content, const struct change *change, uint32_t torn)
{
	if (change->bytes == NULL) {
		content_resize(content, change->size);
		return;
	}
	if (change->at + change->size > content->size)
		content_resize(content, change->at + change->size);
	for (size_t at = change->at, next; at < change->at + change->size; at = next) {
		next = (at / SECTOR + 1) * SECTOR;
		next = next < change->at + change->size ? next : change->at + change->size;
		if (torn == 0 || (torn >> at / SECTOR % 32 & 1) != 0)
			memcpy(content->bytes + at, change->bytes + (at - change->at), next - at);
	}
}

static void inode_change(int number, size_t at, size_t size, const void *bytes)
{
	struct inode *inode = &inodes[number];
	inode->changes = realloc(inode->changes, (inode->count + 1) * sizeof *inode->changes);
	assert(inode->changes != NULL);
	struct change *change = &inode->changes[inode->count++];
	*change = (struct change){at, size, NULL};
	if (bytes == NULL)
		return;
	change->bytes = malloc(size > 0 ? size : 1);
	assert(change->bytes != NULL);
	memcpy(change->bytes, bytes, size);
}

static void inode_sync(int number)
{
	struct inode *inode = &inodes[number];
	for (size_t i = 0; i < inode->count; i++) {
		content_apply(&inode->synced, &inode->changes[i], 0);
		free(inode->changes[i].bytes);
	}
	inode->count = 0;
}

/* --- names --- */

/* In the folder, or NULL. */
static const char *name_in_folder(const char *path)
{
	size_t length = strlen(folder);
	return kept && path != NULL && strncmp(path, folder, length) == 0 && path[length] == '/' ? path + length + 1
												    : NULL;
}

static int names_find(const struct names *names, const char *name)
{
	for (size_t i = 0; i < names->count; i++)
		if (strcmp(names->names[i].name, name) == 0)
			return names->names[i].inode;
	return -1;
}

static void names_add(struct names *names, const char *name, int inode)
{
	assert(names->count < NAMES && strlen(name) < sizeof names->names[0].name);
	strcpy(names->names[names->count].name, name);
	names->names[names->count].was[0] = '\0';
	names->names[names->count++].inode = inode;
}

static void names_set(struct names *names, const char *name, int inode)
{
	for (size_t i = 0; i < names->count; i++)
		if (strcmp(names->names[i].name, name) == 0) {
			names->names[i].inode = inode;
			return;
		}
	names_add(names, name, inode);
}

static void names_apply(struct names *names, const struct name *change)
{
	names_set(names, change->name, change->inode);
	if (change->was[0] != '\0')
		names_set(names, change->was, -1);
}

static void name_change(const char *name, int inode, const char *was)
{
	names_add(&name_changes, name, inode);
	struct name *change = &name_changes.names[name_changes.count - 1];
	strcpy(change->was, was);
	names_apply(&live_names, change);
}

static void names_sync(void)
{
	for (size_t i = 0; i < name_changes.count; i++)
		names_apply(&synced_names, &name_changes.names[i]);
	name_changes.count = 0;
}

static int inode_make(void)
{
	assert(inode_count < FILES);
	inodes[inode_count] = (struct inode){0};
	return inode_count++;
}

/* The file of that name; one that is made now is not on the disk yet. */
static int inode_open(const char *name)
{
	int inode = names_find(&live_names, name);
	if (inode < 0) {
		inode = inode_make();
		name_change(name, inode, "");
	}
	return inode;
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
	if (kept && file_of(file)->inode >= 0) {
		inode_change(file_of(file)->inode, (size_t)at, (size_t)count, bytes);
		if (!operate())
			return SQLITE_IOERR_WRITE;
	}
	return real_of(file)->pMethods->xWrite(real_of(file), bytes, count, at);
}

static int file_truncate(sqlite3_file *file, sqlite3_int64 size)
{
	if (stopped())
		return SQLITE_IOERR_TRUNCATE;
	if (kept && file_of(file)->inode >= 0) {
		inode_change(file_of(file)->inode, 0, (size_t)size, NULL);
		if (!operate())
			return SQLITE_IOERR_TRUNCATE;
	}
	return real_of(file)->pMethods->xTruncate(real_of(file), size);
}

static int file_sync(sqlite3_file *file, int flags)
{
	int number = file_of(file)->inode;
	if (stopped())
		return SQLITE_IOERR_FSYNC;
	if (!kept || number < 0)
		return SQLITE_OK;
	if (!operate())
		return SQLITE_IOERR_FSYNC;
	inode_sync(number);
	if (inodes[number].names_with_it)
		names_sync();
	inodes[number].names_with_it = false;
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
	const char *name = name_in_folder(path);
	bool made = name != NULL && names_find(&live_names, name) < 0 && (flags & SQLITE_OPEN_CREATE) != 0;
	*opened = (struct file){.real = (sqlite3_file *)(opened + 1), .inode = -1};
	if (stopped())
		return SQLITE_CANTOPEN;
	if (name != NULL && (made || names_find(&live_names, name) >= 0))
		opened->inode = inode_open(name);
	if (made) {
		inodes[opened->inode].names_with_it = true;
		if (!operate())
			return SQLITE_CANTOPEN;
	}
	int code = real->xOpen(real, path, opened->real, flags, out);
	if (opened->real->pMethods != NULL)
		opened->base.pMethods = &methods;
	return code;
}

static int shim_delete(sqlite3_vfs *vfs, const char *path, int sync)
{
	const char *name = name_in_folder(path);
	if (stopped())
		return SQLITE_IOERR_DELETE;
	if (name != NULL && names_find(&live_names, name) >= 0) {
		name_change(name, -1, "");
		if (!operate())
			return SQLITE_IOERR_DELETE;
		if (sync)
			names_sync();
	}
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
	const char *name = name_in_folder(path);
	if (stopped())
		return call_stopped();
	if (name != NULL && (flags & O_CREAT) && names_find(&live_names, name) < 0) {
		inode_open(name);
		if (!operate())
			return call_stopped();
	}
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
	bool is_folder = kept && strcmp(path, folder) == 0;
	const char *name = name_in_folder(path);
	if (!is_folder && name == NULL)
		return 0;
	if (!operate())
		return call_stopped();
	if (is_folder)
		names_sync();
	else if (names_find(&live_names, name) >= 0)
		inode_sync(names_find(&live_names, name));
	return 0;
}

static int call_rename(const char *from, const char *to)
{
	const char *old = name_in_folder(from), *new = name_in_folder(to);
	if (stopped())
		return call_stopped();
	if (old != NULL && new != NULL) {
		int inode = names_find(&live_names, old);
		name_change(new, inode, old);
		if (!operate())
			return call_stopped();
	}
	return calls_real.rename(from, to);
}

static int call_unlink(const char *path)
{
	const char *name = name_in_folder(path);
	if (stopped())
		return call_stopped();
	if (name != NULL && names_find(&live_names, name) >= 0) {
		name_change(name, -1, "");
		if (!operate())
			return call_stopped();
	}
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

static void read_whole(const char *path, struct content *content)
{
	FILE *file = fopen(path, "rb");
	assert(file != NULL);
	fseek(file, 0, SEEK_END);
	content_resize(content, (size_t)ftell(file));
	rewind(file);
	size_t size = content->size > 0 ? fread(content->bytes, 1, content->size, file) : 0;
	assert(size == content->size);
	(void)size;
	fclose(file);
}

static void forget(void)
{
	for (int i = 0; i < inode_count; i++) {
		inode_sync(i);
		free(inodes[i].changes);
		free(inodes[i].synced.bytes);
	}
	inode_count = 0;
	synced_names.count = live_names.count = name_changes.count = 0;
}

void power_begin(const char *path, uint64_t cut_at)
{
	assert(!kept);
	forget();
	snprintf(folder, sizeof folder, "%s", path);
	DIR *dir = opendir(folder);
	assert(dir != NULL);
	for (struct dirent *entry; (entry = readdir(dir)) != NULL;) {
		char file[512];
		if (entry->d_name[0] == '.')
			continue;
		snprintf(file, sizeof file, "%s/%s", folder, entry->d_name);
		int inode = inode_make();
		read_whole(file, &inodes[inode].synced);
		names_set(&synced_names, entry->d_name, inode);
		names_set(&live_names, entry->d_name, inode);
	}
	closedir(dir);
	operations = 0;
	cut = cut_at;
	kept = true;
}

uint64_t power_end(void)
{
	kept = false;
	return operations;
}

/* --- what the disk may hold --- */

static uint32_t draw(uint32_t *state)
{
	*state ^= *state << 13;
	*state ^= *state >> 17;
	*state ^= *state << 5;
	return *state;
}

/* How much of what was not synced is there, in eighths. */
static uint32_t share_of(uint32_t seed, uint32_t *state)
{
	return seed == 0 ? 0 : seed == 1 ? 8 : 1 + draw(state) % 7;
}

static void write_inode(const struct inode *inode, uint32_t share, uint32_t *state, const char *path)
{
	struct content content = {NULL, 0};
	content_resize(&content, inode->synced.size);
	if (content.size > 0)
		memcpy(content.bytes, inode->synced.bytes, content.size);
	size_t *order = calloc(inode->count + 1, sizeof *order), chosen = 0;
	assert(order != NULL);
	for (size_t i = 0; i < inode->count; i++)
		if (draw(state) % 8 < share)
			order[chosen++] = i;
	for (size_t i = chosen; share < 8 && i > 1; i--) {
		size_t other = draw(state) % i, kept_one = order[i - 1];
		order[i - 1] = order[other];
		order[other] = kept_one;
	}
	for (size_t i = 0; i < chosen; i++)
		content_apply(&content, &inode->changes[order[i]],
			      share < 8 && i + 1 == chosen ? draw(state) | 1u << draw(state) % 32 : 0);
	free(order);
	FILE *file = fopen(path, "wb");
	assert(file != NULL);
	size_t size = content.size > 0 ? fwrite(content.bytes, 1, content.size, file) : 0;
	assert(size == content.size);
	(void)size;
	fclose(file);
	free(content.bytes);
}

/* A WAL's index and the writer's lock are nothing after a power cut. */
static bool means_nothing(const char *name)
{
	size_t length = strlen(name);
	return (length > 4 && strcmp(name + length - 4, "-shm") == 0) ||
	       (length > 5 && strcmp(name + length - 5, "-lock") == 0);
}

void power_image(uint32_t seed, const char *to)
{
	uint32_t state = seed * 2654435761u + 12345u * (uint32_t)operations + 1;
	static struct names names;
	names = synced_names;
	uint32_t share = share_of(seed, &state);
	for (size_t i = 0; i < name_changes.count; i++)
		if (draw(&state) % 8 < share)
			names_apply(&names, &name_changes.names[i]);
	share = share_of(seed, &state);
	for (size_t i = 0; i < names.count; i++) {
		char path[512];
		snprintf(path, sizeof path, "%s/%s", to, names.names[i].name);
		calls_real.unlink(path);
		if (names.names[i].inode >= 0 && !means_nothing(names.names[i].name))
			write_inode(&inodes[names.names[i].inode], share, &state, path);
	}
}
