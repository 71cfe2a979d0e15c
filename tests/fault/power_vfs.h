/*
 * What the program does to a disk whose power is cut (power_disk.h).
 *
 * Between power_begin() and power_end() everything that is done to the files of one folder, by
 * SQLite through its VFS and by the store's own calls, is an operation on that disk too. After the
 * Nth the world stops: that one and all after it fail. One thread.
 */
#ifndef FURROW_TEST_FAULT_POWER_VFS_H
#define FURROW_TEST_FAULT_POWER_VFS_H

#include <stdint.h>

/* Before anything else of SQLite. Outside of begin and end nothing is kept, nor synced really. */
void power_install(void);
/* What is in the folder now is on the disk. */
void power_begin(const char *folder, uint64_t cut_at);
/* Returns how many operations there were. The world goes on; the disk stays for its images. */
uint64_t power_end(void);

#endif
