/*
 * Flattens a chain of overlays into one plain store: a copy of what the chain shows (store_copy.c).
 *
 * No file of the chain is written or replaced.
 */
#include "store/internal.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

/* `out` is not a file that is being read. */
static enum status check_out(const struct store *from, const char *out)
{
	char there[PATH_MAX];
	if (from->under == NULL)
		return fail_with(STATUS_INPUT, "%s: it is a store of its own, and flat already; copy the file", from->path);
	if (realpath(out, there) == NULL) /* it is not there yet; store_create tells what else is wrong */
		return STATUS_OK;
	for (const struct store *file = from; file != NULL; file = file->under)
		if (strcmp(file->real_path, there) == 0)
			return fail_with(STATUS_INPUT, "%s: it is a file of the chain that is to be flattened; give another name", out);
	return STATUS_OK;
}

enum status store_flatten(const char *path, const char *out, enum store_overwrite overwrite, store_progress_fn progress, void *user)
{
	struct store *from = NULL;
	enum status status;
	TRY_OR(done, store_open(path, &(struct store_options){.mode = STORE_READ}, &from));
	TRY_OR(done, check_out(from, out));
	TRY_OR(done, store_copy(from, out, overwrite, "flatten", true, progress, user));
done:
	store_close(from);
	return status;
}
