/*
 * Invariants: (1) `synced`, of a file and of the names, is what is on the disk; the changes are
 * what was done since, in order; `live` is the names with all of theirs; (2) an operation is kept before
 * it is counted, so that the one with which the power goes may be on the disk; a sync with which it
 * goes syncs nothing; (3) a file that has no name any more is kept until the disk is emptied, since
 * its removal may be undone.
 */
#include "power_disk.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
	bool names_with_it; /* SQLite made it: its next sync by SQLite is one of the names too */
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

static struct {
	struct inode inodes[FILES];
	int inode_count;
	struct names synced, live, name_changes;
	uint64_t operations, cut;
} disk;

/* False: the power goes with this one. */
static bool operate(void)
{
	return ++disk.operations < disk.cut;
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
	struct inode *inode = &disk.inodes[number];
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
	struct inode *inode = &disk.inodes[number];
	for (size_t i = 0; i < inode->count; i++) {
		content_apply(&inode->synced, &inode->changes[i], 0);
		free(inode->changes[i].bytes);
	}
	inode->count = 0;
}

/* --- names --- */

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
	names_add(&disk.name_changes, name, inode);
	struct name *change = &disk.name_changes.names[disk.name_changes.count - 1];
	strcpy(change->was, was);
	names_apply(&disk.live, change);
}

static void names_sync(void)
{
	for (size_t i = 0; i < disk.name_changes.count; i++)
		names_apply(&disk.synced, &disk.name_changes.names[i]);
	disk.name_changes.count = 0;
}

/* --- life --- */

static int inode_make(void)
{
	assert(disk.inode_count < FILES);
	disk.inodes[disk.inode_count] = (struct inode){0};
	return disk.inode_count++;
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

void power_disk_empty(uint64_t cut_at)
{
	for (int i = 0; i < disk.inode_count; i++) {
		inode_sync(i);
		free(disk.inodes[i].changes);
		free(disk.inodes[i].synced.bytes);
	}
	disk.inode_count = 0;
	disk.synced.count = disk.live.count = disk.name_changes.count = 0;
	disk.operations = 0;
	disk.cut = cut_at;
}

void power_disk_put(const char *name, const char *path)
{
	int inode = inode_make();
	read_whole(path, &disk.inodes[inode].synced);
	names_set(&disk.synced, name, inode);
	names_set(&disk.live, name, inode);
}

bool power_disk_stopped(void)
{
	return disk.operations >= disk.cut;
}

uint64_t power_disk_operations(void)
{
	return disk.operations;
}

int power_disk_find(const char *name)
{
	return names_find(&disk.live, name);
}

/* --- operations --- */

bool power_disk_write(int inode, size_t at, size_t size, const void *bytes)
{
	inode_change(inode, at, size, bytes);
	return operate();
}

bool power_disk_truncate(int inode, size_t size)
{
	inode_change(inode, 0, size, NULL);
	return operate();
}

bool power_disk_sync(int inode, enum power_caller caller)
{
	if (!operate())
		return false;
	if (inode < 0)
		return true;
	inode_sync(inode);
	if (caller == POWER_SQLITE && disk.inodes[inode].names_with_it) {
		names_sync();
		disk.inodes[inode].names_with_it = false;
	}
	return true;
}

bool power_disk_sync_names(void)
{
	if (!operate())
		return false;
	names_sync();
	return true;
}

bool power_disk_make(const char *name, enum power_caller caller)
{
	assert(power_disk_find(name) < 0);
	int inode = inode_make();
	disk.inodes[inode].names_with_it = caller == POWER_SQLITE;
	name_change(name, inode, "");
	return operate();
}

bool power_disk_remove(const char *name, bool synced)
{
	name_change(name, -1, "");
	if (!operate())
		return false;
	if (synced)
		names_sync();
	return true;
}

bool power_disk_rename(const char *from, const char *to)
{
	name_change(to, power_disk_find(from), from);
	return operate();
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

void power_disk_image(uint32_t seed, const char *folder)
{
	uint32_t state = seed * 2654435761u + 12345u * (uint32_t)disk.operations + 1;
	static struct names names;
	names = disk.synced;
	uint32_t share = share_of(seed, &state);
	for (size_t i = 0; i < disk.name_changes.count; i++)
		if (draw(&state) % 8 < share)
			names_apply(&names, &disk.name_changes.names[i]);
	share = share_of(seed, &state);
	for (size_t i = 0; i < names.count; i++) {
		char path[512];
		snprintf(path, sizeof path, "%s/%s", folder, names.names[i].name);
		calls_real.unlink(path);
		if (names.names[i].inode >= 0 && !means_nothing(names.names[i].name))
			write_inode(&disk.inodes[names.names[i].inode], share, &state, path);
	}
}
