/*
 * A world that fails: the Nth call of one kind, once or from then on.
 *
 * fault_install() puts a shim over SQLite's default VFS (the store opens with that), one over its
 * allocator, and takes the store's own calls (calls.h). Calls are counted only while a fault is
 * armed; any thread may make them, one arms and disarms. Nothing is synced really: power is not
 * cut here (power_disk.h is for that).
 */
#ifndef FURROW_TEST_FAULT_VFS_H
#define FURROW_TEST_FAULT_VFS_H

#include <stdbool.h>
#include <stdint.h>

enum fault_kind {
	FAULT_NONE,
	/* SQLite's, by its VFS. */
	FAULT_READ,
	FAULT_WRITE,
	FAULT_FULL,       /* a write for which there is no room */
	FAULT_TORN_WRITE, /* the first half of it is written */
	FAULT_SYNC,
	FAULT_TRUNCATE,
	FAULT_OPEN,
	FAULT_DELETE,
	FAULT_ACCESS, /* asking whether a file is there */
	FAULT_SIZE,   /* asking how large one is */
	FAULT_LOCK,
	FAULT_SHARED, /* the WAL's index: mapping and locking */
	/* The store's own. */
	FAULT_CALL_OPEN,
	FAULT_CALL_SYNC,
	FAULT_CALL_RENAME,
	FAULT_CALL_UNLINK,
	FAULT_MEMORY,
	FAULT_SQLITE_MEMORY,
	FAULT_KINDS,
	/* A read that the disk says is whole and is half zeros; not among the kinds of which
	 * everything is asked, since nobody is told. */
	FAULT_SHORT_READ = FAULT_KINDS,
};

/* Before anything else of SQLite. */
void fault_install(void);
/* nth from 1. */
void fault_arm(enum fault_kind kind, uint64_t nth, bool forever);
/* Returns how many calls of that kind there were. */
uint64_t fault_disarm(void);
const char *fault_name(enum fault_kind kind);

#endif
