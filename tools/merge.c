/* furrow merge: two overlays of one store become one. */
#include <stdio.h>

#include "command.h"
#include "store/store.h"

static const struct command_option options[] = {
	{"o", "FILE", "the new overlay"},
	{NULL, NULL, NULL},
};

/* In metres from the south-west post, as windows are. */
static void print_conflicts(const char *path, const struct store_conflicts *conflicts)
{
	struct store *store;
	if (conflicts->posts == 0 || store_open(path, &(struct store_options){.mode = STORE_READ}, &store) != STATUS_OK)
		return;
	double spacing = extent_spacing(&store_meta(store)->extent, conflicts->level);
	for (int64_t i = 0; i < conflicts->places && i < STORE_CONFLICTS_MOST; i++) {
		const struct post_rect *rect = &conflicts->rects[i];
		printf("both changed %g,%g,%g,%g\n", (double)rect->x0 * spacing, (double)rect->y0 * spacing, (double)(rect->x1 - 1) * spacing,
		       (double)(rect->y1 - 1) * spacing);
	}
	if (conflicts->places > STORE_CONFLICTS_MOST)
		printf("and %lld places more\n", (long long)(conflicts->places - STORE_CONFLICTS_MOST));
	store_close(store);
}

static enum status run(const struct arguments *arguments)
{
	struct store_conflicts conflicts = {0};
	struct failure failure;
	const char *out = arguments_text(arguments, "o");
	enum status status = arguments_expect(arguments, 2, 2);
	if (status == STATUS_OK && out == NULL)
		status = fail_with(STATUS_USAGE, "merge: -o is missing; give a file for the new overlay");
	if (status == STATUS_OK)
		status = store_merge(arguments_at(arguments, 0), arguments_at(arguments, 1), out, &conflicts);
	if (status == STATUS_OK) {
		printf("%s: what %s and %s changed\n", out, arguments_at(arguments, 0), arguments_at(arguments, 1));
		return STATUS_OK;
	}
	failure_capture(&failure, status);
	print_conflicts(arguments_at(arguments, 0), &conflicts);
	return failure_restore(&failure);
}

const struct command command_merge = {
	.name = "merge",
	.usage = "merge A B -o FILE",
	.summary = "make one overlay of two",
	.details = "A and B are overlays of one store. FILE lies over the nearest file that both are over, and has what each changed since:\n"
		   "of the level that is deformed; coarser levels are made anew. Where both changed a post they must agree. Otherwise the\n"
		   "places are listed, as W,S,E,N in metres from the south-west post, the first 20, and nothing is made.\n",
	.options = options,
	.run = run,
};
