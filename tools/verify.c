/* furrow verify: everything that can be checked about a store. */
#include <stdio.h>

#include "command.h"
#include "json.h"
#include "store/store.h"

static const struct command_option options[] = {
	{"json", .help = "one JSON object: ok, problems, offset_sum, compacted, carried, in_flight, added"},
	{.name = NULL},
};

struct listing {
	struct progress progress;
	cJSON *problems; /* NULL: print them */
};

static void on_problem(void *user, const char *text)
{
	struct listing *listing = user;
	if (listing->problems != NULL) {
		cJSON_AddItemToArray(listing->problems, cJSON_CreateString(text));
		return;
	}
	progress_end(&listing->progress);
	puts(text);
}

static enum status on_progress(void *user, int64_t done, int64_t total)
{
	struct listing *listing = user;
	return progress_step(&listing->progress, done, total);
}

static enum status print_json(cJSON *problems, const struct store_check *check)
{
	cJSON *object = cJSON_CreateObject();
	cJSON_AddBoolToObject(object, "ok", check->problems == 0);
	json_integer(object, "tiles", check->tiles);
	cJSON_AddItemToObject(object, "problems", problems);
	cJSON *sums = cJSON_AddObjectToObject(object, "offset_sum");
	for (int level = check->finest; level <= check->coarsest; level++) {
		char name[8];
		snprintf(name, sizeof name, "%d", level);
		json_integer(sums, name, check->offset_sum[level - TILE_LEVEL_MIN]);
	}
	json_integer(object, "compacted", check->compacted - check->carried - check->in_flight);
	json_integer(object, "carried", check->carried);
	json_integer(object, "in_flight", check->in_flight);
	json_integer(object, "added", check->added);
	return json_print(object);
}

static enum status run(const struct arguments *arguments)
{
	bool json = arguments_flag(arguments, "json");
	struct store *store = NULL;
	struct store_check check;
	struct listing listing = {.problems = NULL};
	const char *path = arguments_at(arguments, 0);
	TRY(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	if (json && (listing.problems = cJSON_CreateArray()) == NULL) {
		store_close(store);
		return fail_memory("JSON");
	}
	interrupt_catch();
	progress_start(&listing.progress, path, "tiles");
	enum status status = store_verify(store, on_problem, on_progress, &listing, &check);
	progress_end(&listing.progress);
	store_close(store);
	if (status != STATUS_OK)
		cJSON_Delete(listing.problems);
	TRY(status);
	if (json)
		TRY(print_json(listing.problems, &check));
	else if (check.problems == 0)
		printf("%s: %lld tiles, all well\n", path, (long long)check.tiles);
	return check.problems == 0 ? STATUS_OK
				   : fail_with(STATUS_INPUT, "%s: %lld problem%s; restore it from a copy, or import it again", path,
					       (long long)check.problems, check.problems == 1 ? "" : "s");
}

const struct command command_verify = {
	.name = "verify",
	.summary = "check everything: SQLite, hashes, shared edges, pyramid",
	.arguments = COMMAND_ARGUMENTS(COMMAND_STORE),
	.options = options,
	.details = "Reads the whole file, and names each problem. offset_sum is by level, in 2^-20 m; it counts a shared post "
		   "once. Where soil is conserved, offset_sum of the finest level + compacted + carried + in_flight is added. carried: aboard bodies, in_flight: of grains, where "
		   "the last drive ended; added: what furrow edit and furrow_pour brought.\n",
	.see = "store(5)",
	.run = run,
};
