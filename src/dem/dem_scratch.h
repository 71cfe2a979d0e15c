/* A temporary file without a name, for data too large for memory. The system removes it when the process ends. */
#ifndef FURROW_DEM_SCRATCH_H
#define FURROW_DEM_SCRATCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

struct dem_scratch {
	int file; /* -1: none */
};

/* Makes the file in TMPDIR, or else /tmp. `doing` begins the error message. */
enum status dem_scratch_open(struct dem_scratch *scratch, const char *doing) FURROW_CHECKED;
void dem_scratch_close(struct dem_scratch *scratch);
/* Writes `bytes` bytes at `offset`, or reads them if not `write`. STATUS_FAILED if not all could be moved. */
enum status dem_scratch_move(const struct dem_scratch *scratch, bool write, void *data, size_t bytes, int64_t offset)
	FURROW_CHECKED;

#endif
