#include "base/memory.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
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

uint64_t mem_physical(void)
{
	const long pages = sysconf(_SC_PHYS_PAGES), bytes = sysconf(_SC_PAGESIZE);
	return pages > 0 && bytes > 0 ? (uint64_t)pages * (uint64_t)bytes : 0;
}
