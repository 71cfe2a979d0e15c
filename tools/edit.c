/* furrow edit: soil is brought to a store or taken from it, by no body. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "command.h"
#include "drive/drive.h"
#include "edit.h"
#include "json.h"
#include "settings.h"
#include "soil_given.h"

#define UNITS 0x1p20      /* of a metre */
#define SETTLE_STEP 1.0   /* s of simulated time */
#define SETTLE_MOST 1000  /* steps; soil that slides for longer goes on in the next drive */
#define SCENE_TEXT "{scene: 1, time_step: 0.05, spacing: %.17g, soil: %s%s%s, redistribute: {model: scm, loosening: 0.67, hardening: 0.5, iterations: 8}}"

static const struct command_option options[] = {
	{"add", "FILE.tif", .help = "a GeoTIFF of changes of heights, one pixel a post; below 0: soil is taken", .unit = "m", .files = "tif tiff", .needed = true},
	{"polygon", "POLYGON", .help = "where soil comes or goes evenly: POLYGON ((X Y, ...)), or a file of WKT or GeoJSON with one polygon", .files = "wkt txt geojson json",
	 .instead = true},
	{"volume", "M3", .help = "with --polygon: the volume; below 0: taken", .unit = "m3"},
	{"depth", "M", .help = "with --polygon: the thickness; below 0: a pit", .unit = "m", .instead = true},
	{"srs", "SRS", .help = "what the polygon is in; store: the store's own; degrees: longitude and latitude", .preset = "GeoJSON: degrees; WKT: metres from the south-west post"},
	{"dense", .help = "what comes lies as firm as ground that nothing has touched, and slopes stand as they are made"},
	{"loose", .help = "what comes lies loose, and what is steeper than repose slides before the command ends", .preset = "this", .instead = true},
	{"soil", "SOIL", .help = "the soil that says at which slope it rests: a name, or a file with one soil", .preset = "dry_sand"},
	{"spacing", "M", .help = "distance between the posts that change, where nothing was driven yet", .unit = "m",
	 .preset = "that of the drives there, or of the GeoTIFF, or of the store"},
	{"scene", "SCENE", .help = "a scene that is driven there: its soils, spacing and relief count. Nothing in it moves", .files = "yaml yml json"},
	{"snapshot", "NAME", .help = "name what the store holds now, so that furrow restore STORE NAME undoes the edit"},
	{"dry-run", .help = "say what would be done, and change nothing"},
	{"json", .help = "one JSON object: added, added_quanta, posts, spacing, bounds, lowest, highest, loose, done, settled, slid_for, revision"},
	{.name = NULL},
};

struct edit {
	const struct arguments *arguments;
	const char *store;
	struct edit_raster *raster; /* NULL: a polygon */
	double spacing;             /* m */
	bool loose, fixes;          /* fixes: the store gets its working level by this edit */
	struct scene *scene;
	struct drive *drive;
	struct world_pour pour;
	int32_t *amounts;
	/* What it does. */
	int64_t posts, sum; /* 2^-20 m */
	struct post_rect bounds; /* of the posts that change */
	double lowest, highest, slid_for; /* m, m, s */
	size_t active;      /* blocks in which soil still slides */
	int64_t revision;
};

/* --- what is asked for --- */

static enum status check_options(const struct arguments *arguments)
{
	static const char *const of_polygon[] = {"volume", "depth", "srs"}, *const of_scene[] = {"soil", "spacing"};
	const bool adds = arguments_text(arguments, "add") != NULL, polygon = arguments_text(arguments, "polygon") != NULL;
	const bool volume = arguments_text(arguments, "volume") != NULL, depth = arguments_text(arguments, "depth") != NULL;
	if (adds == polygon)
		return fail_with(STATUS_USAGE, "edit: --add and --polygon are both given, or neither; give one of them");
	if (polygon && volume == depth)
		return fail_with(STATUS_USAGE, "edit: --polygon with --volume and --depth, or with neither; give one of them");
	for (size_t i = 0; adds && i < sizeof of_polygon / sizeof *of_polygon; i++)
		if (arguments_text(arguments, of_polygon[i]) != NULL)
			return fail_with(STATUS_USAGE, "edit: --%s is of a polygon, and a GeoTIFF says all itself; leave it out", of_polygon[i]);
	for (size_t i = 0; arguments_text(arguments, "scene") != NULL && i < sizeof of_scene / sizeof *of_scene; i++)
		if (arguments_text(arguments, of_scene[i]) != NULL)
			return fail_with(STATUS_USAGE, "edit: --%s is given, and the scene says it, too; leave one of them out", of_scene[i]);
	if (arguments_flag(arguments, "dense") && arguments_flag(arguments, "loose"))
		return fail_with(STATUS_USAGE, "edit: --dense and --loose are both given; give one of them");
	return STATUS_OK;
}

/* Finds the distance between posts, m, and opens the raster. */
static enum status look_at_store(struct edit *edit)
{
	const char *path = arguments_text(edit->arguments, "add");
	struct store *store = NULL;
	double own = 0;
	int level = 0;
	enum status status;
	TRY(store_open(edit->store, &(struct store_options){.mode = STORE_READ}, &store));
	const struct store_meta *meta = store_meta(store);
	if (path != NULL)
		TRY_OR(done, edit_raster_open(path, meta, &edit->raster, &own));
	edit->fixes = !store_has_working_level(store, &level);
	edit->spacing = !edit->fixes ? extent_spacing(&meta->extent, level) : own > 0 ? own : meta->extent.spacing;
	TRY_OR(done, arguments_number(edit->arguments, "spacing", 1e-4, 1e6, &edit->spacing));
	if (store_relief_text(store) != NULL && arguments_text(edit->arguments, "scene") == NULL)
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: it was driven over a relief that a scene gave it; give that scene with --scene", edit->store));
done:
	store_close(store);
	return status;
}

/* A scene of the command may have bodies and pictures; here nothing moves and nothing is drawn. */
static enum status load_given_scene(const char *path, struct scene **scene)
{
	static const struct scene_setting none[] = {{"objects", "null"}, {"vehicles", "null"}, {"view", "null"}, {"output", "null"}};
	return scene_load_file(path, none, sizeof none / sizeof *none, SCENE_HOST, scene);
}

static enum status load_scene(struct edit *edit)
{
	const char *path = arguments_text(edit->arguments, "scene"), *given = arguments_text(edit->arguments, "soil");
	struct soil_given soil = {.text = NULL};
	char *text = NULL;
	if (path != NULL)
		return load_given_scene(path, &edit->scene);
	enum status status;
	TRY_OR(done, soil_given_take(given != NULL ? given : "dry_sand", &soil));
	const bool named = soil.text[0] != '{';
	const size_t room = sizeof SCENE_TEXT + strlen(soil.text) + 64;
	text = mem_alloc(room, 1);
	TRY_OR(done, text != NULL ? STATUS_OK : fail_memory("a scene"));
	snprintf(text, room, SCENE_TEXT, edit->spacing, named ? "{name: " : "", soil.text, named ? "}" : "");
	status = scene_load_text(text, NULL, NULL, 0, SCENE_HOST, &edit->scene);
	if (status == STATUS_INPUT) {
		char why[600];
		snprintf(why, sizeof why, "%s", scene_text_reason(failure_message()));
		status = fail_with(STATUS_INPUT, "edit: %s", why);
	}
done:
	soil_given_finish(&soil);
	mem_free(text);
	return status;
}

static enum status open_world(struct edit *edit, bool readonly)
{
	const struct drive_params params = {.scene = edit->scene, .store = edit->store, .hosted = true, .readonly = readonly, .stop = &interrupted};
	TRY(drive_open(&params, &edit->drive));
	TRY(drive_start(edit->drive));
	return drive_begin(edit->drive);
}

static void close_world(struct edit *edit, enum status status)
{
	if (edit->drive != NULL)
		drive_stop(edit->drive);
	drive_finish(edit->drive, status);
	edit->drive = NULL;
}

/* --- the posts --- */

/* Gives each post in the polygon the same height. */
static enum status take_depth(struct edit *edit, size_t count, const double *xy, double depth)
{
	const struct resident *resident = world_resident(drive_world(edit->drive));
	const struct extent *extent = &resident->meta->extent;
	/* A volume of which each post gets something tells which posts there are. */
	const double posts = (double)extent_posts(extent->width, resident->level) * (double)extent_posts(extent->height, resident->level);
	const double least = resident->spacing * resident->spacing / UNITS, most = posts < INT32_MAX ? posts : INT32_MAX;
	if (!(fabs(depth) * UNITS < INT32_MAX))
		return fail_with(STATUS_INPUT, "edit: --depth %g: a post takes less than 2048 m; give less", depth);
	TRY(world_pour_polygon(drive_world(edit->drive), count, xy, most * least, &edit->pour.rect, &edit->amounts));
	const size_t all = (size_t)(edit->pour.rect.x1 - edit->pour.rect.x0) * (size_t)(edit->pour.rect.y1 - edit->pour.rect.y0);
	for (size_t i = 0; i < all; i++)
		edit->amounts[i] = edit->amounts[i] != 0 ? (int32_t)lround(depth * UNITS) : 0;
	return STATUS_OK;
}

static enum status take_polygon(struct edit *edit)
{
	const struct store_meta *meta = world_resident(drive_world(edit->drive))->meta;
	double volume = NAN, depth = 0, *xy = NULL;
	size_t count;
	TRY(arguments_number(edit->arguments, "volume", -1e15, 1e15, &volume));
	TRY(arguments_number(edit->arguments, "depth", -2047, 2047, &depth));
	TRY(edit_polygon_read(arguments_text(edit->arguments, "polygon"), meta, arguments_text(edit->arguments, "srs"), &count, &xy));
	enum status status;
	TRY_OR(done, isnan(volume) ? take_depth(edit, count, xy, depth)
				   : world_pour_polygon(drive_world(edit->drive), count, xy, volume, &edit->pour.rect, &edit->amounts));
done:
	mem_free(xy);
	return status;
}

/* Sums up what the amounts do. STATUS_INPUT: nothing. */
static enum status sum_up(struct edit *edit)
{
	const size_t width = (size_t)(edit->pour.rect.x1 - edit->pour.rect.x0), all = width * (size_t)(edit->pour.rect.y1 - edit->pour.rect.y0);
	edit->posts = edit->sum = 0;
	edit->lowest = edit->highest = 0;
	edit->bounds = (struct post_rect){0, 0, 0, 0};
	for (size_t i = 0; i < all; i++) {
		const int64_t x = edit->pour.rect.x0 + (int64_t)(i % width), y = edit->pour.rect.y0 + (int64_t)(i / width);
		if (edit->amounts[i] != 0)
			edit->bounds = post_rect_joined(edit->bounds, (struct post_rect){x, y, x + 1, y + 1});
		edit->posts += edit->amounts[i] != 0;
		edit->sum += edit->amounts[i];
		edit->lowest = fmin(edit->lowest, edit->amounts[i] / UNITS);
		edit->highest = fmax(edit->highest, edit->amounts[i] / UNITS);
	}
	return edit->posts > 0 ? STATUS_OK : fail_with(STATUS_INPUT, "edit: no post would change by as much as 2^-20 m; give a volume, a depth, or a raster that is not 0");
}

/* Finds out what every post gets, and whether that would be refused. */
static enum status prepare(struct edit *edit)
{
	const struct resident *resident = world_resident(drive_world(edit->drive));
	if (edit->amounts == NULL)
		TRY(edit->raster != NULL ? edit_raster_read(edit->raster, resident->meta, resident->level, &edit->pour.rect, &edit->amounts) : take_polygon(edit));
	TRY(sum_up(edit));
	edit->spacing = resident->spacing;
	edit->pour.amounts = edit->amounts;
	edit->pour.soil = -1;
	edit->pour.loose = edit->loose;
	edit->pour.looks = true;
	TRY(world_pour(drive_world(edit->drive), &edit->pour));
	edit->pour.looks = false;
	return STATUS_OK;
}

/* --- doing it --- */

static enum status settle(struct edit *edit)
{
	struct world *world = drive_world(edit->drive);
	struct world_recorded recorded;
	struct progress progress;
	enum status status = STATUS_OK;
	progress_start(&progress, edit->store, "s of sliding at most");
	world_recorded(world, &recorded);
	for (int i = 0; recorded.active > 0 && i < SETTLE_MOST && !interrupted; i++) {
		TRY_OR(done, progress_step(&progress, i, SETTLE_MOST));
		TRY_OR(done, drive_step_to(edit->drive, world_time(world) + SETTLE_STEP));
		edit->slid_for = world_time(world);
		world_recorded(world, &recorded);
	}
done:
	edit->active = recorded.active;
	progress_end(&progress);
	return status;
}

static enum status name_present(const struct edit *edit)
{
	const char *name = arguments_text(edit->arguments, "snapshot");
	struct store *store = NULL;
	enum status status;
	if (name == NULL)
		return STATUS_OK;
	TRY(store_open(edit->store, &(struct store_options){.mode = STORE_WRITE}, &store));
	status = store_snapshot(store, name);
	store_close(store);
	return status;
}

static enum status change(struct edit *edit)
{
	enum status status;
	TRY_OR(done, open_world(edit, false));
	TRY_OR(done, world_pour(drive_world(edit->drive), &edit->pour));
	if (edit->loose)
		TRY_OR(done, settle(edit));
	TRY_OR(done, drive_end(edit->drive, true));
done:
	close_world(edit, status);
	return status;
}

static enum status count_revision(struct edit *edit)
{
	struct store *store = NULL;
	struct store_numbers numbers;
	TRY(store_open(edit->store, &(struct store_options){.mode = STORE_READ}, &store));
	const enum status status = store_count(store, &numbers);
	edit->revision = status == STATUS_OK ? numbers.commits : 0;
	store_close(store);
	return status;
}

/* --- telling --- */

static enum status tell_json(const struct edit *edit, bool done)
{
	const struct post_rect *rect = &edit->bounds;
	const double s = edit->spacing;
	const double bounds[4] = {(double)rect->x0 * s, (double)rect->y0 * s, (double)(rect->x1 - 1) * s, (double)(rect->y1 - 1) * s};
	cJSON *object = cJSON_CreateObject();
	json_number(object, "added", (double)edit->sum / UNITS * s * s);
	json_integer(object, "added_quanta", edit->sum);
	json_integer(object, "posts", edit->posts);
	json_number(object, "spacing", s);
	cJSON_AddItemToObject(object, "bounds", cJSON_CreateDoubleArray(bounds, 4));
	json_number(object, "lowest", edit->lowest);
	json_number(object, "highest", edit->highest);
	cJSON_AddBoolToObject(object, "loose", edit->loose);
	cJSON_AddBoolToObject(object, "done", done);
	cJSON_AddBoolToObject(object, "settled", edit->active == 0);
	json_number(object, "slid_for", edit->slid_for);
	json_integer(object, "revision", edit->revision);
	return json_print(object);
}

static void tell_text(const struct edit *edit, bool done)
{
	const struct post_rect *rect = &edit->bounds;
	const double s = edit->spacing;
	printf("%s: %s%.6g m3 %s %lld post%s, %.6g m apart, within %s\n", edit->store, done ? "" : "would be changed: ", fabs((double)edit->sum / UNITS * s * s),
	       edit->sum < 0 ? "taken from" : "added to", (long long)edit->posts, edit->posts == 1 ? "" : "s", s,
	       number_window((double)rect->x0 * s, (double)rect->y0 * s, (double)(rect->x1 - 1) * s, (double)(rect->y1 - 1) * s).text);
	printf("  changes of %.6g to %.6g m, %s\n", edit->lowest, edit->highest, edit->loose ? "loose" : "dense");
	if (done && edit->slid_for > 0)
		printf("  soil slid for %g s of simulated time%s\n", edit->slid_for, edit->active == 0 ? ", and is at rest" : "");
	if (done && arguments_text(edit->arguments, "snapshot") != NULL)
		printf("  furrow restore %s %s undoes it\n", shell_path(edit->store).text, arguments_text(edit->arguments, "snapshot"));
}

static enum status tell(const struct edit *edit, bool done)
{
	if (done && edit->active > 0)
		note("%s: soil still slides in %zu blocks after %g s; it goes on where a body comes near", edit->store, edit->active, edit->slid_for);
	if (done && edit->fixes)
		note("%s: its ruts have posts %g m apart from now on; drives of another spacing need furrow reset", edit->store, edit->spacing);
	if (arguments_flag(edit->arguments, "json"))
		return tell_json(edit, done);
	tell_text(edit, done);
	return STATUS_OK;
}

static enum status run_edit(struct edit *edit)
{
	const bool dry = arguments_flag(edit->arguments, "dry-run");
	enum status status;
	TRY(look_at_store(edit));
	TRY(load_scene(edit));
	mem_free(edit->scene->file);
	TRY(mem_text(&edit->scene->file, "edit", "a scene")); /* furrow log tells it */
	TRY_OR(looked, open_world(edit, true));
	TRY_OR(looked, prepare(edit));
looked:
	close_world(edit, status);
	TRY(status);
	if (!dry) {
		TRY(name_present(edit));
		TRY(change(edit));
	}
	TRY(count_revision(edit));
	TRY(tell(edit, !dry));
	return interrupted ? fail_with(STATUS_INTERRUPTED, "edit: interrupted while soil slid; the change is in the store") : STATUS_OK;
}

static enum status run(const struct arguments *arguments)
{
	struct edit edit = {.arguments = arguments, .store = arguments_at(arguments, 0), .loose = !arguments_flag(arguments, "dense")};
	TRY(check_options(arguments));
	interrupt_catch();
	const enum status status = run_edit(&edit);
	edit_raster_close(edit.raster);
	scene_destroy(edit.scene);
	mem_free(edit.amounts);
	return status;
}

const struct command command_edit = {
	.name = "edit",
	.summary = "pour soil onto a store, or dig a pit",
	.arguments = COMMAND_ARGUMENTS(COMMAND_STORE),
	.options = options,
	.details = "Heights change at posts of the level that drives deform. What was added or taken is in the store's own account: furrow info and furrow verify "
		   "tell it as added, and the sum of offsets + compacted soil is added soil, to the unit, where soil is conserved.\n\n"
		   "A GeoTIFF has one pixel a post, in metres, with its centre on the post, in the store's reference system. One without a system is in metres from the "
		   "south-west post. furrow export --layer offset writes such a raster. Nodata changes nothing.\n\n"
		   "Loose soil slides to its repose before the command ends. --dense leaves all as it was given. Walls of a pit stand where nothing has moved the ground before, as cliffs of the terrain do. Posts off the terrain and in holes are "
		   "refused, and then nothing has changed: leave them out. No GL is needed. A drive that was interrupted does not resume over changed ground; drive anew.\n",
	.examples = "furrow edit a.furrow --polygon 'POLYGON ((2 2, 9 2, 5 8))' --volume 50\n"
		    "furrow edit a.furrow --polygon pit.geojson --depth -1.5 --snapshot before\n"
		    "furrow edit b.furrow --add changes.tif --dense\n",
	.see = "furrow-reset(1), furrow-restore(1), furrow-snapshot(1)",
	.run = run,
};
