/* furrow branch: an overlay of a store, which goes on from what is there. */
#include <stdio.h>

#include "command.h"
#include "store/store.h"

static enum status run(const struct arguments *arguments)
{
	struct store *store = NULL;
	int64_t revision;
	enum status status;
	TRY_OR(done, store_create_overlay(arguments_at(arguments, 1), arguments_at(arguments, 0)));
	TRY_OR(done, store_open(arguments_at(arguments, 1), &(struct store_options){.mode = STORE_READ}, &store));
	(void)store_parent(store, &revision);
	printf("%s: a branch of %s at revision %lld; drive it as a store; %s keeps what it depends on\n", arguments_at(arguments, 1),
	       arguments_at(arguments, 0), (long long)revision, arguments_at(arguments, 0));
done:
	store_close(store);
	return status;
}

const struct command command_branch = {
	.name = "branch",
	.summary = "make an overlay that goes on from a store",
	.arguments = COMMAND_ARGUMENTS(COMMAND_STORE, {"NEW", .help = "the overlay to make", .files = "furrow", .needed = true}),
	.details = "NEW is an overlay: it shows all that STORE has, and takes what comes. STORE may be an overlay itself; up to 16 "
		   "lie one over another. STORE may be driven on: it keeps what NEW depends on, and lists NEW in the file STORE-pins. Move that "
		   "file with STORE. Removing NEW is the undo; furrow prune then drops what was kept. furrow log tells where branches begin, "
		   "furrow merge joins two.\n",
	.see = "furrow-log(1), furrow-merge(1), furrow-prune(1), furrow-relink(1)",
	.run = run,
};
