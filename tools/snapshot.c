/* furrow snapshot: names the present revision, so that furrow restore returns to it. */
#include <stdio.h>

#include "command.h"
#include "store/store.h"

static const struct command_option options[] = {
	{NULL, NULL, NULL},
};

static enum status run(const struct arguments *arguments)
{
	struct store *store = NULL;
	struct store_numbers numbers;
	enum status status = arguments_expect(arguments, 2, 2);
	if (status == STATUS_OK)
		status = store_open(arguments_at(arguments, 0), &(struct store_options){.mode = STORE_WRITE}, &store);
	if (status == STATUS_OK)
		status = store_snapshot(store, arguments_at(arguments, 1));
	if (status == STATUS_OK)
		status = store_count(store, &numbers);
	if (status == STATUS_OK)
		printf("%s: revision %lld is %s\n", arguments_at(arguments, 0), (long long)numbers.commits, arguments_at(arguments, 1));
	store_close(store);
	return status;
}

const struct command command_snapshot = {
	.name = "snapshot",
	.usage = "snapshot STORE NAME",
	.summary = "name what a store holds now, to restore it later",
	.details = "From now on the store keeps what later drives replace of it: the first change of each tile, whole. NAME has 1 to 64\n"
		   "characters, not all digits, no blanks and commas. furrow reset drops all names.\n",
	.options = options,
	.run = run,
};
