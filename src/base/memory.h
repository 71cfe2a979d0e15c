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
/* Returns the machine's memory in bytes; 0 if unknown. */
uint64_t mem_physical(void);

#endif
