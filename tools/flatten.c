/* furrow flatten: an overlay and all that it is over become one store. */
#include <stdio.h>

#include "command.h"
#include "store/store.h"

static const struct command_option options[] = {
	{"o", "OUT", .help = "the new store", .files = "furrow", .needed = true},
	{"overwrite", .help = "replace OUT if it is a store"},
	{"force", .help = "with --overwrite: also if snapshots of OUT, or overlays that depend on it, are lost; says which"},
	{.name = NULL},
};

static enum status tell(const char *out, const char *path)
{
	struct store *store = NULL;
	struct store_numbers numbers;
	enum status status;
	TRY_OR(done, store_open(out, &(struct store_options){.mode = STORE_READ}, &store));
	TRY_OR(done, store_count(store, &numbers));
	printf("%s: what %s shows, in one file of %.1f MB; it needs no base\n", out, path, (double)numbers.file_bytes / 1e6);
done:
	store_close(store);
	return status;
}

static enum status run(const struct arguments *arguments)
{
	struct progress progress;
	const char *out = arguments_text(arguments, "o");
	if (out == NULL)
		return fail_with(STATUS_USAGE, "flatten: -o is missing; give a file for the new store");
	const char *path = arguments_at(arguments, 0);
	enum store_overwrite overwrite = arguments_flag(arguments, "overwrite") ? STORE_OVERWRITE : STORE_OVERWRITE_NOT;
	if (overwrite == STORE_OVERWRITE && arguments_flag(arguments, "force"))
		overwrite = STORE_OVERWRITE_FORCE;
	interrupt_catch();
	progress_start(&progress, out, "tiles");
	enum status status = store_flatten(path, out, overwrite, progress_step, &progress);
	progress_end(&progress);
	TRY(status);
	return tell(out, path);
}

const struct command command_flatten = {
	.name = "flatten",
	.summary = "make one store of an overlay and all files under it",
	.arguments = COMMAND_ARGUMENTS({"OVERLAY", .help = "what to flatten", .files = "furrow", .needed = true}),
	.options = options,
	.details = "OUT shows what OVERLAY shows, and a drive with --resume goes on from it; it needs none of the other files. "
		   "Tiles are copied as they are. What furrow log lists stays behind: kept revisions and their names. OUT is made "
		   "whole or not at all. A branch of OVERLAY can be moved onto OUT with furrow relink.\n",
	.see = "furrow-branch(1), furrow-relink(1)",
	.run = run,
};
