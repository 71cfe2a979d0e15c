#include "base/memory.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

static _Atomic uint64_t made, failing;
static _Atomic int failing_forever;

static int must_fail(void)
{
	uint64_t number = atomic_fetch_add(&made, 1) + 1;
	uint64_t nth = atomic_load(&failing);
	return nth != 0 && (number == nth || (number > nth && atomic_load(&failing_forever)));
}

uint64_t mem_fail_nth(uint64_t nth, int forever)
{
	atomic_store(&failing, nth);
	atomic_store(&failing_forever, forever);
	return atomic_exchange(&made, 0);
}

void *mem_alloc(size_t count, size_t size)
{
	size_t bytes;
	if (__builtin_mul_overflow(count, size, &bytes) || must_fail())
		return NULL;
	return malloc(bytes != 0 ? bytes : 1);
}

void *mem_calloc(size_t count, size_t size)
{
	return must_fail() ? NULL : calloc(count != 0 ? count : 1, size != 0 ? size : 1);
}

void *mem_realloc(void *memory, size_t count, size_t size)
{
	size_t bytes;
	if (__builtin_mul_overflow(count, size, &bytes) || must_fail())
		return NULL;
	return realloc(memory, bytes != 0 ? bytes : 1);
}

char *mem_strdup(const char *text)
{
	size_t bytes = strlen(text) + 1;
	char *copy = mem_alloc(bytes, 1);
	if (copy != NULL)
		memcpy(copy, text, bytes);
	return copy;
}

void mem_free(void *memory)
{
	free(memory);
}

void mem_free_each(const void *const *list, size_t count)
{
	for (size_t i = 0; i < count; i++)
		free((void *)list[i]);
}

/* Pointers are copied by their bytes, since their types are the caller's. */
void mem_free_list(void *list, size_t count)
{
	void *item;
	for (size_t i = 0; list != NULL && i < count; i++) {
		memcpy(&item, (char *)list + i * sizeof item, sizeof item);
		free(item);
	}
	free(list);
}

static enum status give(void *pointer, void *memory, const char *what)
{
	memcpy(pointer, &memory, sizeof memory);
	return memory != NULL ? STATUS_OK : fail_memory(what);
}

enum status mem_make(void *pointer, size_t count, size_t size, const char *what)
{
	return give(pointer, mem_alloc(count, size), what);
}

enum status mem_zeroed(void *pointer, size_t count, size_t size, const char *what)
{
	return give(pointer, mem_calloc(count, size), what);
}

enum status mem_text(void *pointer, const char *text, const char *what)
{
	return give(pointer, mem_strdup(text), what);
}

size_t mem_room(size_t room, size_t needed)
{
	const size_t twice = room <= SIZE_MAX / 2 ? 2 * room : SIZE_MAX;
	const size_t least = twice > 64 ? twice : 64;
	return least > needed ? least : needed;
}

enum status mem_resize(void *list, size_t count, size_t each, const char *what)
{
	void *items;
	memcpy(&items, list, sizeof items);
	items = mem_realloc(items, count, each);
	TRY_MEM(items != NULL, what);
	return give(list, items, what);
}

enum status mem_grow(void *list, size_t *room, size_t needed, size_t each, const char *what)
{
	if (needed <= *room)
		return STATUS_OK;
	const size_t more = mem_room(*room, needed);
	TRY(mem_resize(list, more, each, what));
	*room = more;
	return STATUS_OK;
}

static uint64_t status_line(const char *name)
{
	FILE *file = fopen("/proc/self/status", "r");
	if (file == NULL)
		return 0;
	char line[256];
	unsigned long long kib = 0;
	size_t length = strlen(name);
	while (fgets(line, sizeof line, file) != NULL)
		if (strncmp(line, name, length) == 0 && sscanf(line + length, ": %llu", &kib) == 1)
			break;
	fclose(file);
	return (uint64_t)kib * 1024;
}

uint64_t mem_peak_resident(void)
{
	return status_line("VmHWM");
}

static _Atomic uint64_t pretended;

void mem_pretend_usable(uint64_t bytes)
{
	atomic_store(&pretended, bytes);
}

static uint64_t physical(void)
{
	const long pages = sysconf(_SC_PHYS_PAGES), bytes = sysconf(_SC_PAGESIZE);
	return pages > 0 && bytes > 0 ? (uint64_t)pages * (uint64_t)bytes : 0;
}

/* Takes the number in the file, if it is less and above 0. A file with "max" has no number. */
static void limit_by_file(const char *path, struct mem_usable *least)
{
	unsigned long long bytes = 0;
	FILE *file = fopen(path, "r");
	if (file == NULL)
		return;
	if (fscanf(file, "%llu", &bytes) == 1 && bytes > 0 && (least->bytes == 0 || bytes < least->bytes))
		*least = (struct mem_usable){bytes, "the limit of the cgroup"};
	fclose(file);
}

/* Looks into the group and all groups around it. A container sees its own group as the topmost. */
static void limit_by_groups(const char *top, char *group, const char *name, struct mem_usable *least)
{
	char path[4096];
	for (;;) {
		if (snprintf(path, sizeof path, "%s%s/%s", top, group, name) < (int)sizeof path)
			limit_by_file(path, least);
		char *last = strrchr(group, '/');
		if (last == NULL)
			return;
		*last = '\0';
	}
}

static void limit_by_cgroups(struct mem_usable *least)
{
	char line[4096];
	FILE *file = fopen("/proc/self/cgroup", "r");
	while (file != NULL && fgets(line, sizeof line, file) != NULL) {
		line[strcspn(line, "\n")] = '\0';
		char *kind = strchr(line, ':'), *group = kind != NULL ? strchr(kind + 1, ':') : NULL;
		if (group == NULL)
			continue;
		*group++ = '\0';
		if (kind[1] == '\0')
			limit_by_groups("/sys/fs/cgroup", group, "memory.max", least);
		else if (strcmp(kind + 1, "memory") == 0)
			limit_by_groups("/sys/fs/cgroup/memory", group, "memory.limit_in_bytes", least);
	}
	if (file != NULL)
		fclose(file);
}

struct mem_usable mem_usable(void)
{
	struct mem_usable least = {atomic_load(&pretended), "the machine's memory"};
	struct rlimit limit;
	if (least.bytes > 0)
		return least;
	least.bytes = physical();
	limit_by_cgroups(&least);
	if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && (least.bytes == 0 || limit.rlim_cur < least.bytes))
		least = (struct mem_usable){limit.rlim_cur, "ulimit -v"};
	return least;
}
