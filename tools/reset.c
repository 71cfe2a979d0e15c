/* furrow reset: drops every deformation. */
#include <stdio.h>

#include "command.h"
#include "store/store.h"

static enum status run(const struct arguments *arguments)
{
	struct store *store = NULL;
	struct store_numbers before;
	enum status status = store_open(arguments_at(arguments, 0), &(struct store_options){.mode = STORE_WRITE}, &store);
	if (status == STATUS_OK)
		status = store_count(store, &before);
	int64_t soil = 0;
	for (int plane = PLANE_DISTURBANCE; plane < PLANES && status == STATUS_OK; plane++)
		soil += before.plane_tiles[plane];
	if (status == STATUS_OK)
		status = store_reset(store);
	if (status == STATUS_OK)
		printf("%s: %lld offset and %lld soil tiles dropped; the base is as it was imported\n",
		       arguments_at(arguments, 0), (long long)before.plane_tiles[PLANE_OFFSET], (long long)soil);
	store_close(store);
	return status;
}

const struct command command_reset = {
	.name = "reset",
	.summary = "drop every deformation, keep the base",
	.arguments = COMMAND_ARGUMENTS(COMMAND_STORE),
	.details = "An overlay of a store with ruts shows its parent's ground again. All snapshots are dropped, too.\n",
	.see = "furrow-restore(1)",
	.run = run,
};
