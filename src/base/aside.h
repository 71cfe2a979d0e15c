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
	const char *path; /* PATH, the final path; owned by the caller */
	char *part;       /* the name "PATH.part" of the unfinished file; this struct owns the string */
	FILE *file;       /* open for writing; NULL: before aside_begin and after aside_whole */
	bool begun;       /* PATH.part was made for this struct, so aside_finish may remove it */
};

/* Sets the name `part` and makes no file. It is for a caller that makes PATH.part without aside_begin. Such a caller sets `begun`
 * when it has made the file. Returns STATUS_FAILED if memory runs out. */
enum status aside_name(struct aside *aside, const char *path) FURROW_CHECKED;
/* Checks before long work that aside_begin can make this file. Makes no file. STATUS_INPUT: its folder is not there or may not be written to, or
 * PATH is a folder, a device or a pipe. */
enum status aside_check(const char *path) FURROW_CHECKED;
/* Sets the name, and opens a new PATH.part as `file`. Returns a failure if it cannot be made; then there is nothing to finish. */
enum status aside_begin(struct aside *aside, const char *path) FURROW_CHECKED;
/* Closes the file; it is then whole. Returns the failure if a write failed. `synced`: also syncs the file to the disk. */
enum status aside_whole(struct aside *aside, bool synced) FURROW_CHECKED;
/* Renames a whole PATH.part to PATH. */
enum status aside_publish(struct aside *aside) FURROW_CHECKED;
/* Frees the struct's memory, and removes PATH.part unless it was published. `aside` may be all zero. */
void aside_finish(struct aside *aside);
/* All three in one, for a single file. `status`: how its writer ended. STATUS_OK: completes and publishes the file. Finishes it in any case.
 * Returns `status`, or the first failure after it. */
enum status aside_end(struct aside *aside, bool synced, enum status status) FURROW_CHECKED;

#endif
