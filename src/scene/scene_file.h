/* Reads the files that a scene consists of. */
#ifndef FURROW_SCENE_FILE_H
#define FURROW_SCENE_FILE_H

#include <stddef.h>

#include "base/base.h"

/* Reads all bytes of a file and puts a NUL after them. Free them with mem_free. STATUS_INPUT if the file cannot be read or has
 * more than `limit` bytes. The message begins with `told`, the place in the scene that names the file. */
enum status scene_file_read(const char *path, const char *told, size_t limit, char **bytes,
			    size_t *length) FURROW_CHECKED;

/* Hashes all bytes of a regular file of at most `limit` bytes. STATUS_INPUT for a pipe or a device: an untrusted scene may name
 * a pipe that nobody writes to, and reading it would never end. */
enum status scene_file_hash(const char *path, const char *told, uint64_t limit, uint64_t hash[2])
	FURROW_CHECKED;

/* Returns the path of `name` in the folder of `file`. If `file` ends in '/' it is the folder. An absolute `name` is returned as
 * it is. NULL: out of memory. Free the path with mem_free. */
char *scene_file_beside(const char *file, const char *name);

/* Gives the folder of a file: "" or a path that ends in '/'. If `file` ends in '/' it is the folder. If `whole`, the result is
 * absolute, so it stays right when the process changes its current folder. Free it with mem_free. */
enum status scene_folder_of(const char *file, bool whole, char **folder) FURROW_CHECKED;

#endif
