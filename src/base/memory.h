/*
 * Allocation that can be made to fail. Returns NULL on failure, like malloc; the caller says
 * what was being allocated with fail_memory(). Freed with mem_free (which takes NULL).
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

/* Tests: the `nth` allocation from now (1 is the next) fails, and every one after it if `forever`.
 * 0 turns it off. Returns how many allocations were made since the last call. Not for production. */
uint64_t mem_fail_nth(uint64_t nth, int forever);

/* Peak resident set of this process in bytes (VmHWM); 0 if unknown. */
uint64_t mem_peak_resident(void);

#endif
