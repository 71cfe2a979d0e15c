/*
 * A disk whose power is cut.
 *
 * Between power_begin() and power_end() everything that is done to the files of one folder, by
 * SQLite through its VFS and by the store's own calls, is kept apart by what was synced. After the
 * Nth operation the world stops: that one and all after it fail. power_image() then makes, in
 * another folder, what the disk may hold: everything that was synced and, of what was not, some
 * operations in some order, one of them torn between sectors of 512 bytes. Names are synced with
 * their folder, or (as SQLite does) by the first sync of a file that SQLite made.
 *
 * Operations are writes, truncations, syncs, and names made, removed and changed. One thread.
 */
#ifndef FURROW_TEST_FAULT_POWER_VFS_H
#define FURROW_TEST_FAULT_POWER_VFS_H

#include <stdint.h>

/* Before anything else of SQLite. Outside of begin and end nothing is kept, nor synced really. */
void power_install(void);
/* What is in the folder now is on the disk. */
void power_begin(const char *folder, uint64_t cut_at);
/* Returns how many operations there were. The world goes on. */
uint64_t power_end(void);
/* Of the last begin and end, any number of them. Seed 0: nothing that was not synced; 1: all of it;
 * others: some of it. */
void power_image(uint32_t seed, const char *folder);

#endif
