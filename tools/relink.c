/* furrow relink: an overlay finds its base again after a move. */
#include <stdio.h>

#include "command.h"
#include "store/store.h"

static enum status run(const struct arguments *arguments)
{
	TRY(store_relink(arguments_at(arguments, 0), arguments_at(arguments, 1)));
	printf("%s: it is over %s\n", arguments_at(arguments, 0), arguments_at(arguments, 1));
	return STATUS_OK;
}

const struct command command_relink = {
	.name = "relink",
	.summary = "tell an overlay where its base is now",
	.arguments = COMMAND_ARGUMENTS({"OVERLAY", .help = "what lost its base", .files = "furrow", .needed = true},
				       {"BASE", .help = "the store or overlay that it lies over", .files = "furrow", .needed = true}),
	.details = "For an overlay whose base, or the branch that it goes on from, was moved or renamed. An overlay names it from "
		   "its own folder, so files that are moved together need no relink. BASE must be the same by content: that is "
		   "proved by hash, of the ruts, too, where the overlay goes on from them. Otherwise the overlay stays as it is.\n",
	.see = "furrow-branch(1), furrow-flatten(1)",
	.run = run,
};
