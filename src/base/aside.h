/*
 * A file that is written beside its place and put there once it is whole: PATH.part, then PATH. Who writes several puts none
 * in place before all are whole. A kill leaves what was at PATH, and a PATH.part.
 *
 *     begun -> whole -> published
 *        \________\____ finished: PATH.part goes
 */
#ifndef FURROW_BASE_ASIDE_H
#define FURROW_BASE_ASIDE_H

#include <stdbool.h>
#include <stdio.h>

#include "base/status.h"

struct aside {
	const char *path; /* the caller's */
	char *part;
	FILE *file; /* NULL: not begun, or whole */
	bool begun; /* what is at `part` is this one's */
};

/* Only finds the name, for who writes `part` by other means and sets `begun`. */
enum status aside_name(struct aside *aside, const char *path) FURROW_CHECKED;
enum status aside_begin(struct aside *aside, const char *path) FURROW_CHECKED;
/* Closes the file: all of it was written, or why not. `synced`: and it is on the disk. */
enum status aside_whole(struct aside *aside, bool synced) FURROW_CHECKED;
enum status aside_publish(struct aside *aside) FURROW_CHECKED;
/* Leaves nothing unless it was published. Also of one that is all zero. */
void aside_finish(struct aside *aside);

#endif
