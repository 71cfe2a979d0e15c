/* furrow explain: what a scene will make and run, and why, before it does. */
#include "explain.h"

#include <stdio.h>

#include "command.h"
#include "settings.h"

static const struct command_option options[] = {
	{"store", "STORE", .help = "the terrain, or an overlay of it, instead of the scene's own; none: tiles of 256 cells are assumed", .files = "furrow"},
	{"keep-history", .help = "the drive is to keep a history, as with furrow drive --keep-history"},
	{"set", "KEY=VALUE", .help = "override a key of the scene, as in cache.slots=16", .repeats = true},
	{"all", .help = "effects, planes, programs, passes, threads and statements too, each with the key that calls for it"},
	{"json", .help = "one JSON object"},
	{.name = NULL},
};

void explain_reason(const struct scene *scene, const char *effect, char *text, size_t size)
{
	enum scene_effect which;
	if (effect == NULL)
		snprintf(text, size, "every drive");
	else if (scene_effect_named(effect, &which))
		scene_effect_reason(scene, which, text, size);
	else
		snprintf(text, size, "%s", effect);
}

static enum status run(const struct arguments *arguments)
{
	struct settings settings = {.count = 0};
	struct scene *scene = NULL;
	struct report_plan plan = {.store = NULL};
	enum status status;
	TRY_OR(done, settings_take(arguments, &settings));
	TRY_OR(done, scene_load(arguments_at(arguments, 0), settings.list, settings.count, &scene));
	TRY_OR(done, report_plan(scene, arguments_text(arguments, "store"), arguments_flag(arguments, "keep-history"), &plan));
	if (arguments_flag(arguments, "json"))
		TRY_OR(done, explain_json(scene, &plan));
	else
		explain_text(scene, &plan, arguments_flag(arguments, "all"));
done:
	report_plan_finish(&plan);
	scene_destroy(scene);
	settings_finish(&settings);
	return status;
}

const struct command command_explain = {
	.name = "explain",
	.summary = "what a scene will make and run, and why, before it does",
	.arguments = COMMAND_ARGUMENTS(COMMAND_SCENE),
	.options = options,
	.details = "Prints the plan of a drive. Notes come first: settings without effect, and what is probably wrong. Then numbers of the soil and whose they are, "
		   "geoms and actuators of vehicles, how many posts are below each body, how many passes run, and memory at most. --all adds effects, planes kept a post, programs, "
		   "passes of each object and picture, threads and statements of the store's tables, each with the key of the scene that calls for it, as in `normals <- view`. What is "
		   "not there is not made and not run: run.json's counts are these amounts, times how often each unit came. Needs no GL, and changes nothing: the store is only read, also while another drive writes it. What a scene may say is in scene(5), which is "
		   "src/scene/SCENE.md.\n",
	.examples = "furrow explain scene.yaml --store world.furrow\n",
	.see = "furrow-drive(1), furrow-scene(1), scene(5)",
	.run = run,
};
