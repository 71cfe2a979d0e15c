/*
 * A text file that is written beside its place and put there once it is whole: PATH.part, then PATH.
 * A command that writes several puts none in place before all are whole.
 */
#ifndef FURROW_TOOLS_ASIDE_H
#define FURROW_TOOLS_ASIDE_H

#include <stdio.h>

#include "base/base.h"

struct aside {
	const char *path; /* the caller's */
	char *part;
	FILE *file; /* NULL: not begun, or whole */
};

enum status aside_begin(struct aside *aside, const char *path) FURROW_CHECKED;
/* What was written is on the disk, or why not. */
enum status aside_whole(struct aside *aside) FURROW_CHECKED;
enum status aside_publish(struct aside *aside) FURROW_CHECKED;
/* Leaves nothing unless it was published. Also of one that is all zero. */
void aside_finish(struct aside *aside);

#endif
