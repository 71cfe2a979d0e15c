/*
 * The disk whose power is cut, as a model: the files of one folder, their contents and their names,
 * each by what was synced.
 *
 * Writes, truncations, syncs, and names made, removed and changed are operations, and counted. With
 * the one at which the power is cut the world stops: power_disk_stopped() from then on, and nobody
 * asks for another. power_disk_image() then makes what the disk may hold: everything that was
 * synced and, of what was not, some operations in some order, one of them torn between sectors of
 * 512 bytes. Names are synced with their folder, or (as SQLite does) by the first sync of a file that
 * SQLite made.
 *
 * Files are known by number, -1 is none; names are without the folder. One disk, one thread.
 */
#ifndef FURROW_TEST_FAULT_POWER_DISK_H
#define FURROW_TEST_FAULT_POWER_DISK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* SQLite syncs the folder too when it first syncs a file that it made; the store asks for that. */
enum power_caller { POWER_SQLITE, POWER_STORE };

/* Nothing is on it, nor was done to it; the power goes with operation cut_at, from 1. */
void power_disk_empty(uint64_t cut_at);
/* Puts the file at path on it, synced, under that name. */
void power_disk_put(const char *name, const char *path);

bool power_disk_stopped(void);
uint64_t power_disk_operations(void);
/* The file that the program finds under the name, synced or not; -1: none. */
int power_disk_find(const char *name);

/* The operations. False: the power goes with this one, and the caller's call fails. */
bool power_disk_write(int inode, size_t at, size_t size, const void *bytes);
bool power_disk_truncate(int inode, size_t size);
/* With -1 it counts and syncs nothing. */
bool power_disk_sync(int inode, enum power_caller caller);
/* Of the folder. */
bool power_disk_sync_names(void);
/* No file has the name. */
bool power_disk_make(const char *name, enum power_caller caller);
/* synced: the names are, in the same operation. */
bool power_disk_remove(const char *name, bool synced);
bool power_disk_rename(const char *from, const char *to);

/* Any number of them, each into a folder that is there. Seed 0: nothing that was not synced; 1: all
 * of it; others: some of it. */
void power_disk_image(uint32_t seed, const char *folder);

#endif
