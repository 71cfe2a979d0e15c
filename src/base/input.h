/*
 * Opens files by names that may have come from a stranger: a scene, a list, what lies beside a store.
 *
 * A pipe that nobody writes to would hold the program for ever, and a device has no end. So only regular files are read. A link
 * that lies where a file is to be made would lead out of its folder. So what is made does not follow a link.
 */
#ifndef FURROW_BASE_INPUT_H
#define FURROW_BASE_INPUT_H

#include <stdbool.h>
#include <stdio.h>

/* Opens a regular file to read it. Never waits. The caller closes it with fclose. NULL: it cannot be opened, or it is no regular
 * file; input_problem says why. */
FILE *input_open(const char *path);
/* Returns true if input_open would open the file: it is there, and is a regular file. Opens nothing. errno is then unchanged. */
bool input_is_file(const char *path);
/* Returns why the last input_open, input_is_file or output_create of this thread failed, for messages. It reads errno. */
const char *input_problem(void);

/* Opens a file to write it, and makes it if it is not there. `flags`: more flags of open(2), as O_RDWR or O_TRUNC. Does not follow a
 * link in the last part of the path. A link to a character device is followed: nothing is made there. Returns the descriptor; -1:
 * it failed, and input_problem says why. */
int output_create(const char *path, int flags);
/* The same for fopen's modes "w", "w+", "a" and "a+". Refuses a pipe. The caller closes the file with fclose. NULL: it failed. */
FILE *output_open(const char *path, const char *mode);

#endif
