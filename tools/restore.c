/* furrow restore: returns a store to a revision that it keeps. */
#include <stdio.h>

#include "command.h"
#include "store/store.h"

static enum status run(const struct arguments *arguments)
{
	struct store *store = NULL;
	struct store_numbers before, after;
	int64_t revision;
	enum status status;
	TRY_OR(done, store_open(arguments_at(arguments, 0), &(struct store_options){.mode = STORE_WRITE}, &store));
	TRY_OR(done, store_count(store, &before));
	TRY_OR(done, store_restore(store, arguments_at(arguments, 1), &revision));
	TRY_OR(done, store_count(store, &after));
	if (after.commits == before.commits)
		printf("%s: it is at revision %lld already\n", arguments_at(arguments, 0), (long long)revision);
	else
		printf("%s: revision %lld is revision %lld again; furrow restore %s %lld undoes that\n", arguments_at(arguments, 0),
		       (long long)after.commits, (long long)revision, shell_path(arguments_at(arguments, 0)).text, (long long)before.commits);
done:
	store_close(store);
	return status;
}

const struct command command_restore = {
	.name = "restore",
	.summary = "return a store to a revision that it keeps",
	.arguments = COMMAND_ARGUMENTS(COMMAND_STORE, {"REVISION|NAME", .help = "one that furrow log lists", .needed = true}),
	.details = "A store keeps the revisions that furrow log lists: those of drives with --keep-history, those with a name "
		   "(furrow snapshot), and those that a restore replaced. What is restored is a revision of its own, so that a "
		   "restore can be undone. A drive with --resume goes on from it.\n",
	.see = "furrow-log(1), furrow-reset(1), furrow-snapshot(1)",
	.run = run,
};
