/* What the tests of views share: a drive over small hills, with pages and a view, in which no step is made. */
#ifndef FURROW_TESTS_VIEW_RIG_H
#define FURROW_TESTS_VIEW_RIG_H

#include "../support.h"
#include "../support/skip.h"

#include "render/view.h"
#include "world/internal.h"

enum { CELLS = 16 };
static const struct extent extent = {513, 513, 1, CELLS};

struct rig {
	struct world world;
	struct view *view;
	struct requests requests;
	struct world_watcher watcher;
	struct scene scene;
	struct scene_object object;
	struct scene_waypoint points[2];
	struct body body;
};

static enum store_mode rig_mode = STORE_READ;

/* The ground, and the store's file. */
static double (*rig_heights)(int64_t, int64_t) = support_hills;
static const char *rig_file = "view.furrow";

/* Rough along both axes, without a twist: the ground between its posts is made of planes, so nothing finer has to be drawn. */
static inline double rig_rough(int64_t at)
{
	uint32_t h = (uint32_t)at * 2654435761u;
	h ^= h >> 15;
	return floor(96 * sin((double)at * 0.31)) / 64 + (double)((h * 2246822519u) >> 26) / 64;
}

static inline double rig_straight(int64_t x, int64_t y)
{
	return 100 + rig_rough(x) + rig_rough(y + 1000);
}

static inline void rig_lay_straight(void)
{
	rig_heights = rig_straight;
	rig_file = "straight.furrow";
}

static inline void rig_lay_hills(void)
{
	rig_heights = support_hills;
	rig_file = "view.furrow";
}

static inline enum status before_read_back(void *user, struct tile tile, uint32_t slot)
{
	return STATUS_OK; /* nothing is ever dirty here */
}

static inline enum status rig_requests(void *user, struct requests *requests)
{
	struct rig *rig = user;
	return render_view_requests(rig->view, requests);
}

/* At the world's level, which the objects' windows are of. Without a thread of its own. */
static inline void start_look_ahead(struct rig *rig)
{
	struct world *world = &rig->world;
	resident_look_ahead_destroy(world->ahead);
	deform_destroy(world->deform);
	struct deform_params params = {.gpu = world->gpu, .slots = world->slots, .extent = &world->meta->extent,
				       .level = world->level};
	world->surface = params;
	must(deform_create(&params, &world->deform));
	const struct look_ahead_body body = {motion_track_ahead(rig->body.track), &rig->object.shape, rig->body.next, NULL};
	must(resident_look_ahead_create(&(struct look_ahead_params){.store = world->store, .ground = world->ground, .tiles = 8, .bodies = &body,
							   .count = 1, .spacing = world->spacing, .prefetch = rig->scene.prefetch,
							   .end = rig->scene.end_time}, &world->ahead));
	resident_look_ahead_stop(world->ahead);
	resident_look_ahead_serve(world->ahead, &(struct look_ahead_pages){&world->surface, &world->meta->extent, world->level, world->cache,
								  rig->scene.slots, rig_requests, rig});
}

/* A wide view from a corner; or, with a speed, one behind an object that crosses the terrain. */
static inline void rig_open(struct rig *rig, uint32_t slots, double speed, double prefetch)
{
	struct world *world = &rig->world;
	const char *path = support_path(rig_file);
	*rig = (struct rig){.points = {{.x = 40, .y = 60}, {.x = 460, .y = 440}}};
	rig->object = (struct scene_object){
		.name = "it",
		.shape = {.kind = SOIL_SPHERE, .radius = 0.5},
		.path = {.points = rig->points, .count = 2, .speed = speed},
	};
	rig->scene = (struct scene){
		.end_time = 1000, .slots = slots, .loaders = 2, .prefetch = prefetch, .objects = &rig->object, .object_count = 1,
		.view = {.present = true, .width = 320, .height = 180, .aim = {.kind = speed > 0 ? SCENE_CHASE : SCENE_FIXED,
			 .back = 12, .up = 5, .eye = {20, 20, 130}, .target = {200, 220, 100}}},
	};
	if (access(path, F_OK) != 0)
		support_store(path, extent, rig_heights);
	must(store_open(path, &(struct store_options){.mode = rig_mode}, &world->store)); /* nothing is deformed */
	world->scene = &rig->scene;
	world->limits.slots = slots;
	world->limits.loaders = 2;
	world->limits.prefetch = prefetch;
	world->meta = store_meta(world->store);
	world->was_deformed = store_has_working_level(world->store, NULL);
	world->spacing = extent.spacing;
	world->bodies = &rig->body;
	rig->body.object = &rig->object;
	must(motion_track_create(&rig->object.path, 1, 1, &rig->body.track));
	world->commit_log = tmpfile();
	assert_non_null(world->commit_log);
	enum status status = gpu_create(&(struct gpu_params){.draws = true}, &world->gpu);
	if (status == STATUS_NO_GL) {
		store_close(world->store);
		skip_since("no GL");
	}
	must(status);
	must(gpu_slots_create(world->gpu, CELLS, slots, 0, &world->slots));
	must(resident_ground_create(world->store, 16, &world->ground));
	must(resident_pages_create(&(struct pages_params){.gpu = world->gpu,
						 .store = world->store,
						 .slots = world->slots,
						 .planes = PLANE_BIT(PLANE_OFFSET),
						 .count = slots,
						 .loaders = 2,
						 .step_pages = 16,
						 .record = world_record_pages(&rig->scene),
						 .commit_log = world->commit_log,
						 .commit_age = 1000,
						 .before_read_back = before_read_back},
			  &world->pages));
	world->cache = resident_pages_cache(world->pages);
	world->record = calloc(1, world_record_bytes(1));
	must(render_view_create(world, false, &rig->view));
	start_look_ahead(rig);
}

static inline void rig_close(struct rig *rig)
{
	struct world *world = &rig->world;
	resident_look_ahead_destroy(world->ahead);
	render_view_destroy(rig->view);
	resident_pages_destroy(world->pages);
	resident_ground_destroy(world->ground);
	deform_destroy(world->deform);
	gpu_slots_destroy(world->slots);
	gpu_destroy(world->gpu);
	motion_track_destroy(rig->body.track);
	resident_requests_finish(&rig->requests);
	store_close(world->store);
	fclose(world->commit_log);
	free(world->record);
}

#endif
