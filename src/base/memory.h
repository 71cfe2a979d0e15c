/*
 * Memory allocation that tests can make fail. The functions return NULL on failure, like malloc; the caller then calls
 * fail_memory() with the name of the object. Free memory with mem_free, which accepts NULL.
 */
#ifndef FURROW_BASE_MEMORY_H
#define FURROW_BASE_MEMORY_H

#include <stddef.h>
#include <stdint.h>

void *mem_alloc(size_t count, size_t size);  /* uninitialised; NULL also if count * size overflows */
void *mem_calloc(size_t count, size_t size); /* zeroed */
void *mem_realloc(void *memory, size_t count, size_t size);
char *mem_strdup(const char *text);
void mem_free(void *memory);

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
