/* furrow drive: runs a scene over a store. */
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "drive/drive.h"
#include "base/aside.h"
#include "fleet/fleet.h"
#include "settings.h"

static const char *const durable[] = {"normal", "full", NULL};

static const struct command_option options[] = {
	{"o", "DIR", .help = "where run.json, epochs.log and the pictures go", .files = "/", .needed = true},
	{"store", "STORE", .help = "the terrain, instead of the scene's own", .files = "furrow"},
	{"overlay", "FILE", .help = "keep the deformation in FILE and leave the store as it is; made if absent", .files = "furrow"},
	{"stage", "DIR", .help = "copy the base to this folder first, once for each machine, and read it from there", .files = "/"},
	{"set", "KEY=VALUE", .help = "override a key of the scene, as in cache.slots=16", .repeats = true},
	{"steps", "N", .help = "stop after N steps, counted from the scene's start"},
	{"resume", .help = "go on from the last committed step, to the same bits as in one go"},
	{"map", "FILE", .help = "draw the map of the drive to this file", .files = "png svg pdf"},
	{"trace", "FILE", .help = "what was asked of the page cache, for furrow cache-sim", .files = "*"},
	{"durable", "KIND", .help = "what a power cut may cost: the last commits, or with full none", .choices = durable,
	 .preset = "normal"},
	{"keep-history", .help = "keep what each commit replaces in the store, so that furrow restore returns to any"},
	{"json", .help = "print run.json on stdout"},
	{.name = NULL},
};

static void print_summary(const struct drive_result *result, const struct drive_params *params)
{
	const bool unfinished = strcmp(result->ended, "interrupted") == 0 || strcmp(result->ended, "failed") == 0;
	printf("%s: %lld steps in %.1f s (%.2f times real time), posts of %s m (level %d), %s%s/run.json%s", result->ended, (long long)result->steps,
	       result->seconds, result->rtf, number_exact(result->spacing).text, result->level, result->reported ? "in " : "but ", params->directory, result->reported ? "" : " could not be written");
	if (result->map)
		printf("; a map in %s/map.png", params->directory);
	if (result->map_also)
		printf("%s%s", result->map ? " and " : "; a map in ", params->map_also);
	/* Of many processes the committed step is not known. */
	const char *none = unfinished && result->committed == 0 && !fleet_is_launched() ? "no " : "";
	if (params->overlay != NULL)
		printf("; %sruts in %s", none, params->overlay);
	else
		printf("; %sruts in %s itself", none, params->store != NULL ? params->store : params->scene->store);
	if (none[0] != '\0')
		printf(" from this drive");
	if (unfinished && result->committed > 0)
		printf(", up to step %lld; --resume goes on with the same scene from there", (long long)result->committed);
	putchar('\n');
}

static struct fleet_params fleet_params_of(const struct drive_params *params, const char *stage, struct progress *progress)
{
	return (struct fleet_params){
		.scene = params->scene,
		.store = params->store,
		.overlay = params->overlay,
		.stage = stage,
		.progress = progress_step,
		.progress_user = progress,
		.resume = params->resume,
		.durable_full = params->durable_full,
		.stop = params->stop,
	};
}

/* Makes the copy of the base, if there is to be one. */
static enum status stage_alone(const struct drive_params *params, const char *stage, struct store_staged *staged)
{
	struct progress progress;
	progress_start(&progress, "stage", "tiles");
	const struct fleet_params with = fleet_params_of(params, stage, &progress);
	enum status status;
	TRY_OR(done, fleet_gather_left(params->overlay, params->resume));
	TRY_OR(done, fleet_stage(&with, staged));
done:
	progress_end(&progress);
	return status;
}

/* The drive by one process. */
static enum status drive_alone(struct drive_params *params, const char *stage, struct drive_result *result)
{
	struct store_staged staged = {.original = NULL};
	enum status status;
	TRY_OR(done, stage_alone(params, stage, &staged));
	params->staged = stage != NULL ? &staged : NULL;
	TRY_OR(done, drive_run(params, result));
done:
	store_staged_finish(&staged);
	return status;
}

static void share_rows(void *user, const struct report_rows *rows)
{
	fleet_rows(user, rows);
}

/* Before the drive, whose map comes last. */
static enum status check_map(const struct arguments *arguments)
{
	const char *path = arguments_text(arguments, "map"), *missing = path != NULL ? chart_missing() : NULL;
	enum chart_format format;
	if (path != NULL && !chart_path_format(path, &format))
		return fail_with(STATUS_USAGE, "drive: --map %s: has another ending; name a .png, .svg or .pdf", path);
	if (missing != NULL)
		return fail_with(STATUS_FAILED, "drive: --map %s: %s", path, missing);
	return path != NULL ? aside_check(path) : STATUS_OK;
}

/* What many processes cannot do together. */
static enum status check_many(const struct drive_params *params)
{
	if (params->overlay == NULL)
		return fail_with(STATUS_USAGE, "drive: many processes need an --overlay, beside which each keeps its part; the store stays as it is");
	if (params->trace != NULL)
		return fail_with(STATUS_USAGE, "drive: --trace is of one page cache, and many processes have one each; drive with one process");
	if (params->keep_history)
		return fail_with(STATUS_USAGE, "drive: --keep-history works only with one process; leave it out");
	if (params->scene->view.images > 0)
		return fail_with(STATUS_INPUT, "%s: view.images: many processes draw no pictures, since none has the whole ground; drive with "
					       "--set view.images=0, and make pictures of the overlay afterwards (furrow view)",
				 params->scene->file);
	if (params->scene->camera_count > 0)
		return fail_with(STATUS_INPUT, "%s: cameras: many processes draw no pictures, since none has the whole ground; drive with "
					       "--set cameras=null",
				 params->scene->file);
	return STATUS_OK;
}

static enum status open_fleet(const struct drive_params *params, const char *stage, struct fleet **fleet)
{
	struct progress progress;
	progress_start(&progress, "stage", "tiles");
	const struct fleet_params with = fleet_params_of(params, stage, &progress);
	enum status status;
	TRY_OR(done, fleet_agree(check_many(params)));
	TRY_OR(done, fleet_open(&with, fleet));
done:
	progress_end(&progress);
	return status;
}

/* The drive by one of many processes. */
static enum status drive_many(struct drive_params *params, const char *stage, struct drive_result *result)
{
	struct fleet *fleet = NULL;
	enum status status;
	TRY_OR(done, open_fleet(params, stage, &fleet));
	params->staged = fleet_staged(fleet);
	params->ranks = fleet_ranks(fleet);
	params->share_rows = share_rows;
	params->stop = fleet_stop(fleet);
	params->progress = params->progress && fleet_speaks();
	TRY_OR(done, drive_run(params, result));
done:
	fleet_close(fleet);
	return status;
}

static enum status drive_with(const struct arguments *arguments, struct drive_params *params, struct drive_result *result)
{
	bool json = arguments_flag(arguments, "json");
	const char *stage = arguments_text(arguments, "stage");
	enum status status = fleet_is_launched() ? drive_many(params, stage, result) : drive_alone(params, stage, result);
	if (result->json != NULL && fleet_speaks()) {
		if (json)
			puts(result->json);
		else
			print_summary(result, params);
	}
	return status;
}

/* Starts as one of many, if a launcher says so. A failure so far is told once. */
static enum status join(enum status status)
{
	if (!fleet_is_launched())
		return status;
	struct failure failure;
	failure_capture(&failure, status);
	enum status joined = fleet_join();
	if (status != STATUS_OK)
		joined = failure_restore(&failure);
	return fleet_agree(joined);
}

/* What the arguments ask for. */
struct asked {
	struct settings settings;
	struct scene *scene;
	int64_t steps;
	int durability;
};

static enum status read_all(const struct arguments *arguments, struct asked *asked)
{
	if (arguments_text(arguments, "o") == NULL)
		return fail_with(STATUS_USAGE, "drive: -o is missing; give a folder for run.json and the pictures");
	if (arguments_text(arguments, "stage") != NULL && arguments_text(arguments, "overlay") == NULL)
		return fail_with(STATUS_USAGE, "drive: --stage reads the store from a copy, and without --overlay the drive writes to the store; "
					       "give an --overlay");
	TRY(check_map(arguments));
	TRY(arguments_integer(arguments, "steps", 1, INT64_MAX, &asked->steps));
	TRY(arguments_choice(arguments, "durable", &asked->durability));
	TRY(settings_take(arguments, &asked->settings));
	return scene_load(arguments_at(arguments, 0), asked->settings.list, asked->settings.count, &asked->scene);
}

static enum status run(const struct arguments *arguments)
{
	struct asked asked = {.scene = NULL};
	struct drive_result result = {.json = NULL};
	enum status status;
	TRY_OR(done, join(read_all(arguments, &asked)));
	interrupt_catch();
	struct drive_params params = {
		.scene = asked.scene,
		.store = arguments_text(arguments, "store"),
		.overlay = arguments_text(arguments, "overlay"),
		.directory = arguments_text(arguments, "o"),
		.trace = arguments_text(arguments, "trace"),
		.steps = asked.steps,
		.resume = arguments_flag(arguments, "resume"),
		.durable_full = asked.durability == 1,
		.keep_history = arguments_flag(arguments, "keep-history"),
		.progress = true,
		.map = asked.scene->map,
		.map_also = arguments_text(arguments, "map"),
		.stop = &interrupted,
	};
	TRY_OR(done, drive_with(arguments, &params, &result));
done:
	mem_free(result.json);
	scene_destroy(asked.scene);
	settings_finish(&asked.settings);
	return status;
}

const struct command command_drive = {
	.name = "drive",
	.summary = "run a scene: objects carve the terrain, pictures and figures come out",
	.arguments = COMMAND_ARGUMENTS(COMMAND_SCENE),
	.options = options,
	.details = "What a scene may say is in scene(5), which is src/scene/SCENE.md: every key, its unit, range and default.\n\n"
		   "Leaves in DIR: run.json (figures, also when interrupted), epochs.log (a line for each commit), and what the scene asks for: map.png (output: {map: true}: each "
		   "object's way and the ruts, on the hillshade), objects.csv, vehicles.csv, frame-NNNNNN.png, and cameras/NAME for each camera of the scene: pictures, "
		   "camera.json, poses.tum, and COLMAP's text files (docs/CAMERAS.md). Ruts are written to the overlay, or else to the store itself; the last line tells which. Ctrl-C ends it cleanly (a second one within a second changes nothing, a third one ends it at once) with everything "
		   "committed, status 130.\n\n"
		   "--resume goes on where a drive of the same scene into the same store ended or was killed (end_time, cache and "
		   "view may differ by then), and begins where there was none; run.json's resumed_from says at which step. "
		   "A new overlay or branch goes on from its parent's drive if that was of this scene and did not end; otherwise it "
		   "begins.\n\n"
		   "An overlay is a store that names its base: every command takes it where it takes a store. Many drives over one "
		   "store, each with its own, may run at once. Removing the file is the undo. An overlay may lie over another, or "
		   "over a store with ruts: it goes on from what is there (furrow branch). A drive over ground that has ruts "
		   "already says so and goes on over them; --resume says nothing.\n\n"
		   "Many processes drive one scene together: mpirun -n 4 furrow drive SCENE -o DIR --overlay FILE. They leave what "
		   "one leaves, bit by bit, and draw no pictures (docs/RANKS.md).\n\n"
		   "--stage is for stores on a slow disk. The base is copied once, to a file NAME-HASH.furrow in that folder, and "
		   "checked by its hashes. Later drives use it again. The overlay goes on naming the store itself. Remove the copy "
		   "when you like.\n",
	.examples = "furrow drive scene.yaml --overlay ruts.furrow -o out\n"
		    "furrow drive scene.yaml -o out --set cache.slots=16 --resume\n",
	.see = "furrow-explain(1), furrow-report(1), furrow-view(1), scene(5)",
	.run = run,
};
