/*
 * What a drive will make and run, found before it begins. A drive uses these same functions. So the plan and the drive agree.
 */
#include <string.h>
#include <unistd.h>

#include "report/report.h"

#define HOLE_SAMPLES 512 /* path samples of all objects and drivers that are looked at for holes: each reads a tile */

/* There is always room for one more text before it is written. `failed` keeps a failure. */
struct notes {
	struct report_plan *plan;
	bool failed;
};

static void keep_note(void *user, const char *text)
{
	struct notes *notes = user;
	struct report_plan *plan = notes->plan;
	char *copy = mem_strdup(text);
	if (copy != NULL && mem_resize(&plan->notes, plan->note_count + 1, sizeof *plan->notes, "the plan") == STATUS_OK) {
		plan->notes[plan->note_count++] = copy;
	} else {
		mem_free(copy);
		notes->failed = true;
	}
}

/* --- the plan --- */

static enum status list_bodies(const struct world *world, struct report_plan *out)
{
	const struct scene *scene = world_scene(world);
	size_t count = scene->object_count;
	for (size_t v = 0; v < vehicle_count(out->vehicles); v++) {
		struct vehicle_info info;
		vehicle_info(out->vehicles, v, &info);
		count += info.geom_count;
	}
	TRY(mem_zeroed(&out->bodies, count + 1, sizeof *out->bodies, "the plan"));
	for (size_t i = 0; i < scene->object_count; i++)
		out->bodies[out->body_count++] = (struct report_body){scene->objects[i].name, &scene->objects[i].shape, scene_object_bears_over(scene, &scene->objects[i]), 0};
	for (size_t v = 0; v < vehicle_count(out->vehicles); v++) {
		struct vehicle_info info;
		struct vehicle_geom geom;
		vehicle_info(out->vehicles, v, &info);
		for (size_t g = 0; g < info.geom_count; g++) {
			vehicle_geom(out->vehicles, v, g, world_resident(world)->spacing, &geom);
			out->bodies[out->body_count++] = (struct report_body){geom.name, geom.shape, vehicle_bears_over(out->vehicles, v, g, scene), geom.hull ? -1 : geom.contacts};
		}
	}
	return STATUS_OK;
}

/* Adds the lines of what bodies do to the soil. */
static enum status plan_bodies(const struct world *world, struct report_plan *out)
{
	const size_t first = world_scene(world)->object_count, count = out->body_count - first;
	const struct soil_shape **added = mem_calloc(count + 1, sizeof *added);
	TRY_MEM(added, "the plan");
	for (size_t i = 0; i < count; i++)
		added[i] = out->bodies[first + i].shape;
	enum status status = world_plan_deform(world, added, count, &out->plan);
	mem_free(added);
	return status;
}

/* Adds the lines of pictures: of the scene's objects, and of the parts of vehicles. */
static enum status plan_view(const struct world *world, bool planes, struct report_plan *out)
{
	const struct scene *scene = world_scene(world);
	const struct world_figures figures = vehicle_figures(out->vehicles);
	struct render_params render;
	render_view_params(world, &render);
	if (render.effects >> EFFECT_IMAGERY & 1)
		TRY(render_imagery_check(world_resident(world)->store));
	struct scene_object *drawn = mem_calloc(scene->object_count + figures.count + 1, sizeof *drawn);
	TRY_MEM(drawn, "the plan");
	for (size_t i = 0; i < scene->object_count; i++)
		drawn[i] = scene->objects[i];
	for (size_t i = 0; i < figures.count; i++)
		drawn[scene->object_count + i] = figures.list[i];
	render.objects = drawn;
	render.object_count = scene->object_count + figures.count;
	render_plan(&render, planes, world_resident(world)->level < 0, render_view_smooths(world), &out->plan);
	mem_free(drawn);
	return STATUS_OK;
}

/* Returns the effect that draws classes of soil; NULL: nothing does. */
static const char *drawn_classes_effect(const struct scene *scene)
{
	const bool ground = scene->view.effects & EFFECT_BIT(EFFECT_SPLAT);
	if (!scene_draws_classes(scene))
		return scene_covers_by_class(scene) ? scene_effect_row(EFFECT_VEGETATION)->name : NULL;
	return scene_effect_row(ground ? EFFECT_SPLAT : EFFECT_CAMERAS)->name;
}

static enum status plan_lines(const struct world *world, struct report_plan *out)
{
	struct plan *plan = &out->plan;
	const struct scene *scene = world_scene(world);
	uint32_t cells = world_resident(world)->meta->extent.cells;
	unsigned planes = world_planes(world);
	bool classes = world_needs_soil_map(scene);
	bool decimates = planes != 0 && scene->view.present;
	TRY(plan_bodies(world, out));
	/* Its planes come first: the effect that needs the offset is the one that deforms tiles. */
	const char *effect = plan->count > 0 ? plan->lines[0].effect : NULL;
	const char *picture = scene_effect_row(EFFECT_PICTURE)->name;
	if (!world_is_bearing(world))
		gpu_slots_plan(cells, planes, classes, world_division(world), world_computes_together(world), decimates, effect, plan);
	else if (scene->view.present)
		gpu_slots_plan_mirror(cells, planes, drawn_classes_effect(scene), picture, plan);
	if (scene->view.present) {
		TRY(plan_view(world, planes != 0, out));
		render_cameras_plan(scene, plan);
		if (render_pictures_bytes(scene) > 0)
			render_pictures_plan(render_pictures_bytes(scene), scene->view.images > 0 ? EFFECT_IMAGES : EFFECT_CAMERAS, plan);
	}
	world_plan_pages(world, plan);
	return plan_status(plan);
}

static void describe_batches(struct report_plan *out)
{
	for (size_t i = 0; i < out->plan.count; i++) {
		const struct plan_line *line = &out->plan.lines[i];
		if (line->unit == PLAN_BATCH)
			out->batch_windows = DEFORM_BATCH_MOST;
		if (line->kind == PLAN_BUFFER && strcmp(line->name, DEFORM_BATCH_BUFFER) == 0)
			out->batch_bytes = line->bytes;
	}
}

/* Tells where a vehicle's start has no ground below it. A drive looks below each soil geom, and refuses it. */
static enum status advise_starts(const struct world *world, struct notes *notes)
{
	const struct scene *scene = world_scene(world);
	struct store_reader *reader = NULL;
	if (scene->vehicle_count == 0 || world_resident(world)->store == NULL)
		return STATUS_OK;
	enum status status;
	TRY_OR(done, store_reader_create(world_resident(world)->store, &reader));
	for (size_t i = 0; i < scene->vehicle_count; i++) {
		struct store_sample sample = {.nodata = false};
		double at[2];
		char text[300];
		TRY_OR(done, world_start_point(world, &scene->vehicles[i], at));
		TRY_OR(done, store_sample(reader, at[0], at[1], &sample));
		if (!sample.nodata && !sample.outside)
			continue;
		snprintf(text, sizeof text, "vehicles.%s.start: there is no ground at %.3f, %.3f m, %s, and a drive refuses a vehicle with none below a soil geom; "
					    "start elsewhere", scene->vehicles[i].name, at[0], at[1], sample.outside ? "off the terrain" : "in a hole of the terrain");
		keep_note(notes, text);
	}
done:
	store_reader_destroy(reader);
	return status;
}

/* Where a path is over holes. */
struct over_holes {
	struct track_point first;
	double share; /* of the path samples that are due until the drive's end */
};

/* Looks at up to `most` of the due path samples, evenly spread. */
static enum status find_holes(struct store_reader *reader, const struct track *track, double end, uint64_t most, struct over_holes *out)
{
	const uint64_t due = world_samples_until(track, end), count = due < most ? due : most;
	uint64_t holes = 0;
	for (uint64_t i = 0; i < count; i++) {
		struct track_point point;
		struct store_sample sample = {.nodata = false};
		motion_track_sample(track, (int64_t)(count > 1 ? i * (due - 1) / (count - 1) : 0), &point);
		TRY(store_sample(reader, point.x, point.y, &sample));
		if (sample.nodata && !sample.outside && holes++ == 0)
			out->first = point;
	}
	out->share = count > 0 ? (double)holes / (double)count : 0;
	return STATUS_OK;
}

static void tell_holes(const struct world *world, const char *key, const struct over_holes *holes, bool vehicle, struct notes *notes)
{
	const bool stops = world_scene(world)->outside == SCENE_STOP;
	char text[500];
	if (holes->share == 0)
		return;
	snprintf(text, sizeof text, "%.220s: is over a hole of the terrain after %.6g s%s, at %.3f, %.3f m, and for about %.2g %% of its path samples: %s; move "
				    "the path%s, or import with holes filled (furrow import --fill)", key, holes->first.time, vehicle ? " at its speed" : "", holes->first.x,
		 holes->first.y, 100 * holes->share,
		 stops     ? "the drive will stop there"
		 : vehicle ? "nothing carries the vehicle there"
			   : "nothing is pressed there",
		 stops ? ", set outside: skip" : "");
	keep_note(notes, text);
}

/* The same of a path that a vehicle's driver follows. The wheels beside it may be over other holes. */
static enum status advise_way(const struct world *world, struct store_reader *reader, const struct scene_vehicle *vehicle, uint64_t most, struct notes *notes)
{
	struct over_holes holes = {.share = 0};
	struct scene_path route;
	struct track *track = NULL;
	char key[240];
	if (world_route(world, &vehicle->way, vehicle->name, &route) != STATUS_OK)
		return STATUS_OK; /* a drive refuses it */
	enum status status;
	TRY_OR(done, motion_track_create(&route, world_resident(world)->spacing, 0, &track));
	TRY_OR(done, find_holes(reader, track, world_scene(world)->end_time, most, &holes));
	snprintf(key, sizeof key, "vehicles.%.200s.driver.path", vehicle->name);
	tell_holes(world, key, &holes, true, notes);
done:
	motion_track_destroy(track);
	motion_route_finish(&route);
	return status;
}

/* Tells of paths over holes, as advise_leaving does of those off the terrain. It looks at some path samples only. */
static enum status advise_holes(const struct world *world, struct notes *notes)
{
	const struct scene *scene = world_scene(world);
	const size_t paths = scene->object_count + scene->vehicle_count;
	struct store_reader *reader = NULL;
	if (paths == 0 || world_resident(world)->store == NULL)
		return STATUS_OK;
	const uint64_t most = HOLE_SAMPLES / paths + 2;
	enum status status;
	TRY_OR(done, store_reader_create(world_resident(world)->store, &reader));
	for (size_t i = 0; i < scene->object_count; i++) {
		struct over_holes holes = {.share = 0};
		char key[240];
		if (world_body(world, i)->kind != BODY_PATH)
			continue;
		TRY_OR(done, find_holes(reader, world_body(world, i)->track, scene->end_time, most, &holes));
		snprintf(key, sizeof key, "objects.%.200s.path", scene->objects[i].name);
		tell_holes(world, key, &holes, false, notes);
	}
	for (size_t i = 0; i < scene->vehicle_count; i++)
		if (scene->vehicles[i].driver == SCENE_FOLLOW)
			TRY_OR(done, advise_way(world, reader, &scene->vehicles[i], most, notes));
done:
	store_reader_destroy(reader);
	return status;
}

static void describe_soils(const struct world *world, struct report_plan *out)
{
	const struct world_soils_met *met = world_facts(world)->met;
	if (met == NULL)
		return;
	out->soils_known = true;
	out->places = met->places;
	out->unmapped = met->none / met->all;
	for (int i = 0; i < SOIL_CLASSES; i++)
		out->soils[i] = met->soils[i] / met->all;
	for (int i = 0; i < SOIL_RASTERS; i++)
		out->covered[i] = met->numbers[i] / met->all;
}

static void describe_rocks(const struct world *world, struct report_plan *out)
{
	const struct extent *extent = &world_resident(world)->meta->extent;
	out->rocks = world_rocks_asked(world);
	out->rocks_count = world_resident(world)->store == NULL ? (double)NAN :
			   rocks_density(&out->rocks) * (double)(extent->width - 1) * (double)(extent->height - 1) * extent->spacing * extent->spacing;
}

static enum status describe(struct world *world, struct report_plan *out)
{
	const struct scene *scene = world_scene(world);
	struct resident_pages_budget most;
	struct notes notes = {.plan = out};
	TRY(world_budget_check(world));
	TRY(advise_starts(world, &notes));
	TRY(advise_holes(world, &notes));
	world_budget(world, &most);
	out->effects = world_effects(world);
	out->cells = world_resident(world)->meta->extent.cells;
	out->level = world_resident(world)->level;
	out->spacing = world_resident(world)->spacing;
	out->deformed = world_resident(world)->was_deformed;
	out->most = most;
	out->tiles = report_tiles_of(world, &most);
	out->usable = world_facts(world)->limits.usable;
	out->all = world_facts(world)->limits.all;
	out->bearing = world_is_bearing(world);
	out->window_tiles = world_counts(world)->windows.tiles;
	out->steps = (int64_t)world_steps_until(scene, scene->end_time);
	out->picture_steps = scene->view.present ? scene->view.images : 0;
	out->pictures = out->picture_steps > 0 ? out->steps / out->picture_steps : 0;
	TRY(mem_zeroed(&out->samples, scene->object_count + 1, sizeof *out->samples, "the plan"));
	for (size_t i = 0; i < scene->object_count; i++)
		out->samples[i] = world_samples_until(world_body(world, i)->track, scene->end_time);
	for (int i = 0; world_resident(world)->soil_rasters != NULL && i < scene->raster_count; i++)
		out->rasters[out->raster_count++] = world_raster(world, i);
	describe_rocks(world, out);
	describe_soils(world, out);
	world_advise(world, keep_note, &notes);
	if (world_resident(world)->store != NULL || world_scene(world)->spacing > 0)
		vehicle_advise(out->vehicles, world, keep_note, &notes);
	report_sun_advise(world, keep_note, &notes);
	report_cameras_advise(world, keep_note, &notes);
	report_pictures_advise(scene, out->steps, keep_note, &notes);
	if (report_sun_find(world, &out->sun) != STATUS_OK) /* told when the store is known */
		out->sun.drawn = false;
	TRY(list_bodies(world, out));
	TRY(plan_lines(world, out));
	describe_batches(out);
	return notes.failed ? fail_memory("the plan") : STATUS_OK;
}

/* Lets go of the world. Returns `status`, with its message. */
static enum status finish_world(struct world *world, enum status status)
{
	struct failure failure;
	failure_capture(&failure, status);
	world_finish(world, STATUS_OK);
	return status != STATUS_OK ? failure_restore(&failure) : STATUS_OK;
}

static enum status check_world(const struct scene *scene, const char *store, struct vehicles *vehicles)
{
	struct world *world = NULL;
	struct scene driven;
	struct store_meta assumed;
	enum status status;
	scene_unwatched(vehicle_scene(vehicles, scene), &driven);
	TRY_OR(done, world_open_plan(&driven, store != NULL ? store : scene->store, false, NULL, &assumed, &world));
	TRY_OR(done, vehicle_check_rasters(vehicles, world));
done:
	return finish_world(world, status);
}

enum status report_check(const struct scene *scene, const char *store)
{
	struct vehicles *vehicles = NULL;
	TRY(vehicle_load(scene, &vehicles));
	const enum status status = check_world(scene, store, vehicles);
	struct failure failure;
	failure_capture(&failure, status);
	vehicle_destroy(vehicles);
	return status != STATUS_OK ? failure_restore(&failure) : STATUS_OK;
}

static enum status plan_world(const struct scene *scene, const char *path, bool keep_history, struct report_plan *out)
{
	struct world *world = NULL;
	struct world_aboard_shapes aboard;
	struct scene driven;
	struct store_meta assumed;
	enum status status;
	scene_unwatched(vehicle_scene(out->vehicles, scene), &driven);
	aboard.list = vehicle_aboard_shapes(out->vehicles, &aboard.count);
	TRY_OR(done, world_open_plan(&driven, path, keep_history, &aboard, &assumed, &world));
	TRY_OR(done, vehicle_check_rasters(out->vehicles, world));
	if (path != NULL && (out->store = mem_strdup(path)) == NULL)
		TRY_OR(done, fail_memory("the plan"));
	TRY_OR(done, describe(world, out));
done:
	return finish_world(world, status);
}

enum status report_plan(const struct scene *scene, const char *store, bool keep_history, struct report_plan *out)
{
	const char *path = store;
	if (path == NULL && scene->store != NULL && access(scene->store, F_OK) == 0)
		path = scene->store;
	*out = (struct report_plan){.store = NULL};
	if (path == NULL && scene->store != NULL && (out->missing = mem_strdup(scene->store)) == NULL)
		return fail_memory("the plan");
	struct failure failure;
	enum status status;
	TRY_OR(failed, report_map_check(scene));
	TRY_OR(failed, vehicle_load(scene, &out->vehicles));
	TRY_OR(failed, vehicle_find_shares(out->vehicles));
	TRY_OR(failed, plan_world(scene, path, keep_history, out));
	return STATUS_OK;
failed:
	failure_capture(&failure, status);
	report_plan_finish(out);
	return failure_restore(&failure);
}

void report_plan_finish(struct report_plan *plan)
{
	mem_free_list(plan->notes, plan->note_count);
	vehicle_destroy(plan->vehicles);
	mem_free_all(plan->samples, plan->bodies, plan->store, plan->missing);
	plan_finish(&plan->plan);
	*plan = (struct report_plan){.store = NULL};
}
