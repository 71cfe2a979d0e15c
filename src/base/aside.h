/*
 * A file that is written as PATH.part, and renamed to PATH when it is complete. To write several files, complete all before any
 * is renamed. A kill leaves the old file at PATH, and a PATH.part.
 *
 *     begun -> whole -> published
 *        \________\____ finished: PATH.part is removed
 */
#ifndef FURROW_BASE_ASIDE_H
#define FURROW_BASE_ASIDE_H

#include <stdbool.h>
#include <stdio.h>

#include "base/status.h"

struct aside {
	const char *path; /* the final path; owned by the caller */
	char *part;
	FILE *file; /* NULL: not begun, or whole */
	bool begun; /* this struct made the file at `part`, so aside_finish may remove it */
};

/* Only sets the name `part`. For a caller that writes the file by other means, and then sets `begun`. */
enum status aside_name(struct aside *aside, const char *path) FURROW_CHECKED;
enum status aside_begin(struct aside *aside, const char *path) FURROW_CHECKED;
/* Closes the file; it is then whole. If it could not be written, returns the failure. `synced`: also syncs it to the disk. */
enum status aside_whole(struct aside *aside, bool synced) FURROW_CHECKED;
enum status aside_publish(struct aside *aside) FURROW_CHECKED;
/* Frees it, and removes PATH.part unless it was published. aside may be all zero. */
void aside_finish(struct aside *aside);

#endif
