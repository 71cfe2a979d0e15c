/*
 * Every allocation counted: by the sanitizer's hooks where there is one, else by functions of ours
 * in place of the C library's. What libraries take counts too, and what the C library itself takes:
 * so these functions are visible outside of the program, which is compiled with hidden symbols.
 *
 * Invariant: a block is counted by the size it has in the allocator, when it is taken and when it
 * is given back; blocks taken while `paused` are given back while `paused`.
 */
#include "fuzz.h"

#include <errno.h>
#include <malloc.h>
#include <sqlite3.h>
#include <stdlib.h>
#include <unistd.h>
#include <stdio.h>

#if defined __SANITIZE_ADDRESS__
#define SANITIZED 1
#elif defined __has_feature
#if __has_feature(address_sanitizer) || __has_feature(memory_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED 1
#endif
#endif
#ifndef SANITIZED
#define SANITIZED 0
#endif

static uint64_t live, start, peak, limit = UINT64_MAX;
static int64_t blocks;
static int paused;

static void taken(size_t size)
{
	if (paused > 0)
		return;
	blocks++;
	live += size;
	if (live > peak)
		peak = live;
	if (live > limit) {
		char text[160];
		int length = snprintf(text, sizeof text,
				      "memory: %llu bytes beyond the start, %llu allowed; the last block: %zu\n",
				      (unsigned long long)(live - start), (unsigned long long)(limit - start), size);
		limit = UINT64_MAX;
		if (write(STDERR_FILENO, text, (size_t)length) == length)
			abort();
		abort();
	}
}

static void given_back(size_t size)
{
	if (paused > 0)
		return;
	/* A block that was never counted: the limits would mean nothing. */
	if (live < size)
		abort();
	blocks--;
	live -= size;
}

#if SANITIZED
int __sanitizer_install_malloc_and_free_hooks(void (*taken)(const volatile void *, size_t),
					      void (*given_back)(const volatile void *));
size_t __sanitizer_get_allocated_size(const volatile void *block);

static void hook_taken(const volatile void *block, size_t size)
{
	if (block != NULL)
		taken(size);
}

static void hook_given_back(const volatile void *block)
{
	if (block != NULL)
		given_back(__sanitizer_get_allocated_size(block));
}

static __attribute__((constructor)) void install(void)
{
	__sanitizer_install_malloc_and_free_hooks(hook_taken, hook_given_back);
}
#else
#define SEEN __attribute__((visibility("default")))
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *block, size_t size);
void *__libc_memalign(size_t alignment, size_t size);
void __libc_free(void *block);

static void *counted(void *block)
{
	if (block != NULL)
		taken(malloc_usable_size(block));
	return block;
}

SEEN void *malloc(size_t size)
{
	return counted(__libc_malloc(size));
}

SEEN void *calloc(size_t count, size_t size)
{
	return counted(__libc_calloc(count, size));
}

SEEN void *realloc(void *block, size_t size)
{
	size_t old = block != NULL ? malloc_usable_size(block) : 0;
	void *moved = __libc_realloc(block, size);
	if (block != NULL && (moved != NULL || size == 0))
		given_back(old);
	return counted(moved);
}

SEEN void *memalign(size_t alignment, size_t size)
{
	return counted(__libc_memalign(alignment, size));
}

SEEN void *aligned_alloc(size_t alignment, size_t size)
{
	return counted(__libc_memalign(alignment, size));
}

SEEN int posix_memalign(void **block, size_t alignment, size_t size)
{
	if (alignment % sizeof(void *) != 0 || (alignment & (alignment - 1)) != 0 || alignment == 0)
		return EINVAL;
	void *made = __libc_memalign(alignment, size);
	if (made == NULL)
		return ENOMEM;
	*block = counted(made);
	return 0;
}

SEEN void free(void *block)
{
	if (block != NULL)
		given_back(malloc_usable_size(block));
	__libc_free(block);
}
#endif

void fuzz_memory_allow(uint64_t bytes)
{
	start = peak = live;
	limit = live + bytes;
}

void fuzz_memory_allow_all(void)
{
	limit = UINT64_MAX;
}

int64_t fuzz_memory_blocks(void)
{
	return blocks;
}

uint64_t fuzz_memory_peak(void)
{
	return peak - start;
}

/* --- SQLite --- */

static sqlite3_mem_methods sqlite;

static void *sqlite_malloc(int size)
{
	paused++;
	void *block = sqlite.xMalloc(size);
	paused--;
	return block;
}

static void sqlite_free(void *block)
{
	paused++;
	sqlite.xFree(block);
	paused--;
}

static void *sqlite_realloc(void *block, int size)
{
	paused++;
	void *moved = sqlite.xRealloc(block, size);
	paused--;
	return moved;
}

void fuzz_memory_leave_out_sqlite(void)
{
	if (sqlite3_config(SQLITE_CONFIG_GETMALLOC, &sqlite) != SQLITE_OK)
		abort();
	sqlite3_mem_methods counted_apart = sqlite;
	counted_apart.xMalloc = sqlite_malloc;
	counted_apart.xFree = sqlite_free;
	counted_apart.xRealloc = sqlite_realloc;
	if (sqlite3_config(SQLITE_CONFIG_MALLOC, &counted_apart) != SQLITE_OK)
		abort();
}
