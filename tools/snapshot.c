/* furrow snapshot: names the present revision, so that furrow restore returns to it. */
#include <stdio.h>

#include "command.h"
#include "store/store.h"

static enum status run(const struct arguments *arguments)
{
	struct store *store = NULL;
	struct store_numbers numbers;
	enum status status;
	TRY_OR(done, store_open(arguments_at(arguments, 0), &(struct store_options){.mode = STORE_WRITE}, &store));
	TRY_OR(done, store_snapshot(store, arguments_at(arguments, 1)));
	TRY_OR(done, store_count(store, &numbers));
	printf("%s: revision %lld is %s\n", arguments_at(arguments, 0), (long long)numbers.commits, arguments_at(arguments, 1));
done:
	store_close(store);
	return status;
}

const struct command command_snapshot = {
	.name = "snapshot",
	.summary = "name what a store holds now, to restore it later",
	.arguments = COMMAND_ARGUMENTS(COMMAND_STORE,
				       {"NAME", .help = "1 to 64 characters, not all digits, no blanks and commas", .needed = true}),
	.details = "From now on the store keeps what later drives replace of it: the first change of each tile, whole. furrow "
		   "reset drops all names, and only with --force.\n",
	.see = "furrow-log(1), furrow-restore(1)",
	.run = run,
};
