/*
 * The system calls that src/store makes itself, beside SQLite: open, fsync, rename, unlink. A test's
 * executable is linked with --wrap for each, so that what is tested has no hook in it.
 */
#ifndef FURROW_TEST_FAULT_CALLS_H
#define FURROW_TEST_FAULT_CALLS_H

#include <sys/types.h>

struct calls {
	int (*open)(const char *path, int flags, mode_t mode);
	int (*fsync)(int file);
	int (*rename)(const char *from, const char *to);
	int (*unlink)(const char *path);
};

extern const struct calls calls_real;
/* Whose functions are called; &calls_real at first. */
extern const struct calls *calls_now;

#endif
