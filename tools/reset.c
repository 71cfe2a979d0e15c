/* furrow reset: drops every deformation. */
#include <stdio.h>

#include "command.h"
#include "store/store.h"

static const struct command_option options[] = {
	{"force", .help = "also if snapshots, or overlays that depend on its ruts, are lost; says which"},
	{.name = NULL},
};

/* Says what will be lost, before it is. */
static enum status tell_losses(struct store *store, const char *path)
{
	char text[1400];
	int64_t count = 0;
	TRY(store_losses(store, false, text, sizeof text, &count));
	if (count > 0)
		note("%s: %s; that is lost now", path, text);
	return STATUS_OK;
}

static enum status run(const struct arguments *arguments)
{
	struct store *store = NULL;
	struct store_numbers before;
	const bool force = arguments_flag(arguments, "force");
	int64_t soil = 0;
	enum status status;
	TRY_OR(done, store_open(arguments_at(arguments, 0), &(struct store_options){.mode = STORE_WRITE}, &store));
	TRY_OR(done, store_count(store, &before));
	if (force)
		TRY_OR(done, tell_losses(store, arguments_at(arguments, 0)));
	for (int plane = PLANE_DISTURBANCE; plane < PLANES; plane++)
		soil += before.plane_tiles[plane];
	TRY_OR(done, store_reset(store, force));
	printf("%s: %lld offset and %lld soil tiles dropped; the base is as it was imported\n",
	       arguments_at(arguments, 0), (long long)before.plane_tiles[PLANE_OFFSET], (long long)soil);
done:
	store_close(store);
	return status;
}

const struct command command_reset = {
	.name = "reset",
	.summary = "drop every deformation, keep the base",
	.arguments = COMMAND_ARGUMENTS(COMMAND_STORE),
	.options = options,
	.details = "An overlay of a store with ruts shows its parent's ground again. A store with snapshots, or with overlays that depend on its ruts, is reset only "
		   "with --force: those are lost. Overlays that depend on the base alone stay.\n",
	.see = "furrow-log(1), furrow-restore(1)",
	.run = run,
};
