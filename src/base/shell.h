/* Paths in commands that a message tells the user to type. Any thread. */
#ifndef FURROW_BASE_SHELL_H
#define FURROW_BASE_SHELL_H

#include <limits.h>

struct shell_text {
	char text[PATH_MAX + 64];
};

/* Returns the path as one word for a shell: as it is where no letter of it means anything to a shell, else in quotes. A path that is too
 * long for the struct is cut. */
struct shell_text shell_path(const char *path);

#endif
