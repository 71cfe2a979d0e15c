/* Reading the files a scene is made of. */
#ifndef FURROW_SCENE_FILE_H
#define FURROW_SCENE_FILE_H

#include <stddef.h>

#include "base/base.h"

/* All bytes of a file, followed by a NUL; freed with mem_free. STATUS_INPUT if it cannot be read
 * or holds more than `limit` bytes; the message begins with `told`, the place to be named. */
enum status scene_file_read(const char *path, const char *told, size_t limit, char **bytes,
			    size_t *length) FURROW_CHECKED;

/* Hashes all bytes of a regular file. A scene is untrusted: it may name a pipe that nobody writes to, or a device. */
enum status scene_file_hash(const char *path, const char *told, uint64_t limit, uint64_t hash[2])
	FURROW_CHECKED;

/* `name` in the folder of `file` (a path that ends in '/' is a folder); NULL: no memory. Freed with mem_free. */
char *scene_file_beside(const char *file, const char *name);

/* The folder of a file, or a folder's own name: "" or ends in '/'. With `whole` it begins at the root,
 * so that it stays the same where the process changes its folder. Freed with mem_free. */
enum status scene_folder_of(const char *file, bool whole, char **folder) FURROW_CHECKED;

#endif
