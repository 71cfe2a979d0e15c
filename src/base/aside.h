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
	const char *path; /* owned by the caller */
	char *part;
	FILE *file; /* NULL: not begun, or whole */
	bool begun; /* the file at `part` was made by this one */
};

/* Only makes the name, for a caller that writes `part` by other means and sets `begun`. */
enum status aside_name(struct aside *aside, const char *path) FURROW_CHECKED;
enum status aside_begin(struct aside *aside, const char *path) FURROW_CHECKED;
/* Closes the file, or returns why it could not be written. `synced`: also syncs it to the disk. */
enum status aside_whole(struct aside *aside, bool synced) FURROW_CHECKED;
enum status aside_publish(struct aside *aside) FURROW_CHECKED;
/* Frees it, and removes PATH.part unless it was published. Also takes one that is all zero. */
void aside_finish(struct aside *aside);

#endif
