/* A file without a name, for what is too large for memory; gone with the process. */
#ifndef FURROW_DEM_SCRATCH_H
#define FURROW_DEM_SCRATCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

struct dem_scratch {
	int file; /* -1: none */
};

/* In TMPDIR, or /tmp. `doing` begins the message. */
enum status dem_scratch_open(struct dem_scratch *scratch, const char *doing) FURROW_CHECKED;
void dem_scratch_close(struct dem_scratch *scratch);
/* All of `bytes` at `offset`, into the file or (not `write`) from it, or STATUS_FAILED. */
enum status dem_scratch_move(const struct dem_scratch *scratch, bool write, void *data, size_t bytes, int64_t offset)
	FURROW_CHECKED;

#endif
