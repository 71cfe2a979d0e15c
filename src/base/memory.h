/*
 * Memory allocation that tests can make fail. Functions that return a pointer return NULL on failure, like malloc; the caller then calls
 * fail_memory() with the name of the object. Those that return a status have done so. Free memory with mem_free, which accepts NULL. Any thread.
 */
#ifndef FURROW_BASE_MEMORY_H
#define FURROW_BASE_MEMORY_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

void *mem_alloc(size_t count, size_t size);  /* uninitialised; NULL also if count * size overflows */
void *mem_calloc(size_t count, size_t size); /* zeroed */
void *mem_realloc(void *memory, size_t count, size_t size);
char *mem_strdup(const char *text);
void mem_free(void *memory);
/* Frees each of its arguments in their order. All of them are read before the first is freed, so that the last can be what holds the others. */
#define mem_free_all(...) \
	mem_free_each((const void *const[]){__VA_ARGS__}, sizeof((const void *const[]){__VA_ARGS__}) / sizeof(const void *))
void mem_free_each(const void *const *list, size_t count);
/* Frees the first `count` pointers of a list, and the list. NULL: does nothing. */
void mem_free_list(void *list, size_t count);

/* Allocates `count` items of `size` bytes, uninitialised or zeroed, for the pointer whose address is `pointer`. Fails by fail_memory(what); the
 * pointer is NULL then. */
FURROW_CHECKED enum status mem_make(void *pointer, size_t count, size_t size, const char *what);
FURROW_CHECKED enum status mem_zeroed(void *pointer, size_t count, size_t size, const char *what);
/* The same for a copy of `text`. */
FURROW_CHECKED enum status mem_text(void *pointer, const char *text, const char *what);

/* Makes room in a growing list. `list`: the address of the pointer to its first item, which may be NULL. `room`: how many items it has room for.
 * Does nothing where `needed` items have room; otherwise the room becomes mem_room(). `each`: bytes of an item. Fails by fail_memory(what) where
 * memory is lacking or size_t is too small for it; the list and `room` then stay as they were. */
FURROW_CHECKED enum status mem_grow(void *list, size_t *room, size_t needed, size_t each, const char *what);
/* The same to `count` items exactly, which may be fewer than before. For lists of one room, too: each is resized to mem_room(), and the room set
 * last. */
FURROW_CHECKED enum status mem_resize(void *list, size_t count, size_t each, const char *what);
/* Returns twice `room`, but at least 64 and at least `needed`. */
size_t mem_room(size_t room, size_t needed);

/* For tests only: the `nth` allocation from now fails (1 is the next), and if `forever` all later ones. 0 turns this off.
 * Returns the number of allocations since the last call. */
uint64_t mem_fail_nth(uint64_t nth, int forever);

/* Returns the largest resident memory of this process so far, in bytes (VmHWM); 0 if unknown. */
uint64_t mem_peak_resident(void);
/* The memory that this process may use. */
struct mem_usable {
	uint64_t bytes; /* 0: unknown */
	const char *of; /* what sets it: "the machine's memory", "the limit of the cgroup" or "ulimit -v" */
};
/* Returns the least of the machine's memory, the limits of the cgroups that the process is in, and its limit of virtual memory. Reads files of
 * /proc and /sys/fs/cgroup at each call. */
struct mem_usable mem_usable(void);
/* For tests only: mem_usable() returns so many bytes, as the machine's memory. 0: it returns what there is again. */
void mem_pretend_usable(uint64_t bytes);

#endif
