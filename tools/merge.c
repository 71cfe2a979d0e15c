/* furrow merge: two overlays of one store become one. */
#include <stdio.h>

#include "command.h"
#include "json.h"
#include "store/store.h"

static const struct command_option options[] = {
	{"o", "FILE", .help = "the new overlay", .files = "furrow", .needed = true},
	{"json", .help = "one JSON object: file (null: none was made), level, posts, places, both_changed"},
	{.name = NULL},
};

/* W,S,E,N of a place, in metres from the south-west post, as windows are. */
struct place {
	double edges[4];
};

static struct place place_of(const struct store_conflicts *conflicts, int64_t index, double spacing)
{
	const struct post_rect *rect = &conflicts->rects[index];
	return (struct place){{(double)rect->x0 * spacing, (double)rect->y0 * spacing, (double)(rect->x1 - 1) * spacing,
			       (double)(rect->y1 - 1) * spacing}};
}

static int64_t listed(const struct store_conflicts *conflicts)
{
	return conflicts->places < STORE_CONFLICTS_MOST ? conflicts->places : STORE_CONFLICTS_MOST;
}

static enum status print_text(const char *file, const struct arguments *arguments, const struct store_conflicts *conflicts, double spacing)
{
	if (file != NULL)
		printf("%s: what %s and %s changed\n", file, arguments_at(arguments, 0), arguments_at(arguments, 1));
	for (int64_t i = 0; i < listed(conflicts); i++) {
		struct place place = place_of(conflicts, i, spacing);
		printf("both changed %g,%g,%g,%g\n", place.edges[0], place.edges[1], place.edges[2], place.edges[3]);
	}
	if (conflicts->places > STORE_CONFLICTS_MOST)
		printf("and %lld places more\n", (long long)(conflicts->places - STORE_CONFLICTS_MOST));
	return STATUS_OK;
}

static enum status print_json(const char *file, const struct store_conflicts *conflicts, double spacing)
{
	cJSON *object = cJSON_CreateObject();
	json_string(object, "file", file);
	json_integer(object, "level", conflicts->level);
	json_integer(object, "posts", conflicts->posts);
	json_integer(object, "places", conflicts->places);
	cJSON *places = cJSON_AddArrayToObject(object, "both_changed");
	for (int64_t i = 0; i < listed(conflicts); i++)
		cJSON_AddItemToArray(places, cJSON_CreateDoubleArray(place_of(conflicts, i, spacing).edges, 4));
	return json_print(object);
}

/* `file`: the new overlay; NULL: both changed posts, and it was not made. */
static enum status tell(const char *file, const struct arguments *arguments, const struct store_conflicts *conflicts)
{
	struct store *store;
	TRY(store_open(arguments_at(arguments, 0), &(struct store_options){.mode = STORE_READ}, &store));
	double spacing = extent_spacing(&store_meta(store)->extent, conflicts->level);
	enum status status = arguments_flag(arguments, "json") ? print_json(file, conflicts, spacing)
							       : print_text(file, arguments, conflicts, spacing);
	store_close(store);
	return status;
}

static enum status run(const struct arguments *arguments)
{
	struct store_conflicts conflicts = {0};
	struct failure failure;
	const char *out = arguments_text(arguments, "o");
	if (out == NULL)
		return fail_with(STATUS_USAGE, "merge: -o is missing; give a file for the new overlay");
	enum status status = store_merge(arguments_at(arguments, 0), arguments_at(arguments, 1), out, &conflicts);
	if (status == STATUS_OK)
		return tell(out, arguments, &conflicts);
	failure_capture(&failure, status);
	if (conflicts.posts > 0)
		TRY(tell(NULL, arguments, &conflicts));
	return failure_restore(&failure);
}

const struct command command_merge = {
	.name = "merge",
	.summary = "make one overlay of two",
	.arguments = COMMAND_ARGUMENTS({"A", .help = "an overlay", .files = "furrow", .needed = true},
				       {"B", .help = "another overlay of the same store", .files = "furrow", .needed = true}),
	.options = options,
	.details = "FILE lies over the nearest file that both are over, and has what each changed since: of the level that is "
		   "deformed; coarser levels are made anew. Where both changed a post they must agree. Otherwise the places are "
		   "listed, as W,S,E,N in metres from the south-west post, the first 20, and nothing is made.\n",
	.see = "furrow-branch(1), furrow-flatten(1)",
	.run = run,
};
