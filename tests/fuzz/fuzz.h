/*
 * What a fuzz target is, to the driver (driver.c) and to libFuzzer alike.
 *
 * A target is one file. It has LLVMFuzzerTestOneInput(), which takes hostile bytes and returns 0,
 * or ends the process: by a sanitizer, by an assert, or by fuzz_check(). It may have
 * LLVMFuzzerCustomMutator(), which knows the format. Seeds are made, not kept: they follow the
 * format when it changes. One thread.
 */
#ifndef FURROW_FUZZ_H
#define FURROW_FUZZ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* --- a target --- */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed);

extern const size_t fuzz_size_max; /* bytes of an input */
/* Seed `index` into data; its size, or 0 if there are no more. */
size_t fuzz_seed(size_t index, uint8_t *data, size_t room);
/* Words of the format, NULL at the end. */
extern const char *const fuzz_words[];

/* --- what the driver or libFuzzer gives a target --- */

/* A few changes of bytes; the new size, at most `room`. */
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room);

/* --- fuzz_support.c: for both --- */

/* Ends the process, with the place and the last failure's message. */
#define fuzz_check(condition)                                                                      \
	((condition) ? (void)0 : fuzz_fail(__FILE__, __LINE__, #condition))
_Noreturn void fuzz_fail(const char *file, int line, const char *what);

/* splitmix64: the same numbers everywhere. */
uint64_t fuzz_random(uint64_t *state);
uint64_t fuzz_below(uint64_t *state, uint64_t bound); /* 0 .. bound - 1 */
/* Numbers at the edges of types and ranges, most of them; sometimes any. */
int64_t fuzz_integer(uint64_t *state);
double fuzz_real(uint64_t *state);

/* NAME in a folder that is made by the first call, in memory where there is such, and removed at the
 * end of the process that made it. */
const char *fuzz_path(const char *name);
void fuzz_write(const char *path, const void *bytes, size_t size);
/* The file's size; more than `room` if it did not fit (data is then undefined). */
size_t fuzz_read(const char *path, uint8_t *data, size_t room);

/* --- fuzz_memory.c: every allocation of the process --- */

/* Bytes that may be allocated beyond those that are now: the allocation that goes beyond ends the
 * process, where it is made. A target allows all again before it returns. */
void fuzz_memory_allow(uint64_t bytes);
void fuzz_memory_allow_all(void);
/* Blocks now allocated. */
int64_t fuzz_memory_blocks(void);
/* The most bytes there were beyond those at the last fuzz_memory_allow(). */
uint64_t fuzz_memory_peak(void);
/* SQLite counts its own (sqlite3_memory_highwater): its blocks are not counted here. Before any
 * other use of SQLite. */
void fuzz_memory_leave_out_sqlite(void);

#endif
