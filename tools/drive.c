/* furrow drive: runs a scene over a store. */
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "api/api.h"
#include "settings.h"

static const struct command_option options[] = {
	{"o", "DIR", "where run.json, epochs.log and the pictures go"},
	{"store", "STORE", "the terrain, instead of the scene's own"},
	{"overlay", "FILE", "keeps the deformation in FILE and leaves the store as it is; made if absent"},
	{"set", "KEY=VALUE", "overrides a key of the scene, as in cache.slots=16; may be repeated"},
	{"steps", "N", "stop after N steps, counted from the scene's start"},
	{"resume", NULL, "go on from the last committed step, to the same bits as in one go"},
	{"trace", "FILE", "what was asked of the page cache, for furrow cache-sim"},
	{"durable", "KIND", "normal (default): a power cut may cost the last epochs; full: none"},
	{"keep-history", NULL, "keep what each commit replaces in the store, so that furrow restore returns to any"},
	{"json", NULL, "print run.json on stdout"},
	{NULL, NULL, NULL},
};

static void print_summary(const struct api_result *result, const char *directory)
{
	printf("%s: %lld steps in %.1f s (%.2f times real time), in %s/run.json", result->ended, (long long)result->steps,
	       result->seconds, result->rtf, directory);
	if (result->map)
		printf("; a map in %s/map.png", directory);
	putchar('\n');
}

static enum status run(const struct arguments *arguments)
{
	static const char *const durable[] = {"normal", "full", NULL};
	struct settings settings = {.count = 0};
	struct scene *scene = NULL;
	struct api_result result = {.json = NULL};
	int64_t steps = 0;
	int durability = 0;
	const char *directory = arguments_text(arguments, "o");
	enum status status = arguments_expect(arguments, 1, 1);
	if (status == STATUS_OK && directory == NULL)
		status = fail_with(STATUS_USAGE, "drive: -o is missing; give a folder for run.json and the pictures");
	if (status == STATUS_OK)
		status = arguments_integer(arguments, "steps", 1, INT64_MAX, &steps);
	if (status == STATUS_OK)
		status = arguments_choice(arguments, "durable", durable, &durability);
	if (status == STATUS_OK)
		status = settings_take(arguments, &settings);
	if (status == STATUS_OK)
		status = scene_load(arguments_at(arguments, 0), settings.list, settings.count, &scene);
	if (status == STATUS_OK) {
		interrupt_catch();
		bool json = arguments_flag(arguments, "json");
		struct api_params params = {
			.scene = scene,
			.store = arguments_text(arguments, "store"),
			.overlay = arguments_text(arguments, "overlay"),
			.directory = directory,
			.trace = arguments_text(arguments, "trace"),
			.steps = steps,
			.resume = arguments_flag(arguments, "resume"),
			.durable_full = durability == 1,
			.keep_history = arguments_flag(arguments, "keep-history"),
			.progress = true,
			.map = true,
			.stop = &interrupted,
		};
		status = api_drive(&params, &result);
		if (result.json != NULL && json)
			puts(result.json);
		else if (result.json != NULL)
			print_summary(&result, directory);
	}
	mem_free(result.json);
	scene_destroy(scene);
	settings_finish(&settings);
	return status;
}

const struct command command_drive = {
	.name = "drive",
	.usage = "drive SCENE -o DIR [--store STORE] [--overlay FILE] [--set KEY=VALUE]... [--steps N] [--resume] "
		 "[--trace FILE] [--keep-history] [--json]",
	.summary = "run a scene: objects carve the terrain, pictures and figures come out",
	.details = "What a scene may say is in src/scene/SCENE.md: every key, its unit, range and default.\n"
		   "Leaves in DIR: run.json (figures, also when interrupted), epochs.log (a line for each commit), map.png (each\n"
		   "object's way and the ruts, on the hillshade) and frame-NNNNNN.png. Ctrl-C ends it cleanly with everything committed, status 130.\n"
		   "--resume goes on where a drive of the same scene into the same store ended or was killed (end_time, cache and\n"
		   "view may differ by then), and begins where there was none; run.json's resumed_from says at which step.\n"
		   "An overlay is a store that names its base: every command takes it where it takes a store. Many\n"
		   "drives over one store, each with its own, may run at once. Removing the file is the undo.\n"
		   "An overlay may lie over another, or over a store with ruts: it goes on from what is there (furrow branch).\n"
		   "A drive over ground that has ruts already says so and goes on over them; --resume says nothing.\n",
	.options = options,
	.run = run,
};
