/* What the tests of views share: a drive over small hills, with pages and a view, in which no step is made. */
#ifndef FURROW_TESTS_VIEW_RIG_H
#define FURROW_TESTS_VIEW_RIG_H

#include "../support.h"
#include "../support/skip.h"

#include "render/view.h"
#include "world/made.h"

enum { CELLS = 16 };
static const struct extent extent = {513, 513, 1, CELLS};

struct rig {
	struct world *world;
	struct world_made made; /* the world's parts. After a change of them: rig_set */
	struct record *record;
	FILE *commit_log;
	struct deform_params surface; /* of made.deform */
	struct view *view;
	struct requests requests;
	struct scene scene;
	struct scene_object object;
	struct scene_waypoint points[2];
	struct body body, *bodies[1];
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

static inline void rig_set(struct rig *rig)
{
	world_made_set(rig->world, &rig->made);
}

static inline void rig_at(struct rig *rig, double time)
{
	rig->made.time = time;
	rig_set(rig);
}

static inline void rig_at_level(struct rig *rig, int level)
{
	rig->made.resident.level = level;
	rig->made.resident.spacing = extent_spacing(&extent, level);
	rig_set(rig);
}

/* Makes a look-ahead with its thread. */
static inline void rig_make_look_ahead(struct rig *rig)
{
	const struct resident *ground = &rig->made.resident;
	const struct look_ahead_body body = {motion_track_ahead(rig->body.track), &rig->object.shape, rig->body.next, NULL};
	must(resident_look_ahead_create(&(struct look_ahead_params){.store = ground->store, .ground = ground->ground, .tiles = 8, .bodies = &body,
							   .count = 1, .spacing = ground->spacing, .prefetch = rig->scene.prefetch,
							   .end = rig->scene.end_time}, &rig->made.ahead));
	rig_set(rig);
}

static inline void rig_serve_look_ahead(struct rig *rig)
{
	const struct resident *ground = &rig->made.resident;
	resident_look_ahead_serve(rig->made.ahead, &(struct look_ahead_pages){&rig->surface, &ground->meta->extent, ground->level, ground->cache,
									    rig->scene.slots, rig_requests, rig});
}

/* At the world's level, which the objects' windows are of. Without a thread of its own. */
static inline void start_look_ahead(struct rig *rig)
{
	const struct resident *ground = &rig->made.resident;
	resident_look_ahead_destroy(rig->made.ahead);
	deform_destroy(rig->made.deform);
	rig->surface = (struct deform_params){.gpu = ground->gpu, .slots = ground->slots, .extent = &ground->meta->extent, .level = ground->level};
	must(deform_create(&rig->surface, &rig->made.deform));
	rig_make_look_ahead(rig);
	resident_look_ahead_stop(rig->made.ahead);
	rig_serve_look_ahead(rig);
}

/* A wide view from a corner; or, with a speed, one behind an object that crosses the terrain. */
static inline void rig_open(struct rig *rig, uint32_t slots, double speed, double prefetch)
{
	struct resident *ground = &rig->made.resident;
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
	must(store_open(path, &(struct store_options){.mode = rig_mode}, &ground->store)); /* nothing is deformed */
	rig->made.scene = &rig->scene;
	rig->bodies[0] = &rig->body;
	rig->made.body_count = 1;
	rig->made.bodies = rig->bodies;
	rig->made.slots = slots;
	rig->made.loaders = 2;
	rig->made.prefetch = prefetch;
	ground->meta = store_meta(ground->store);
	ground->was_deformed = store_has_working_level(ground->store, NULL);
	ground->spacing = extent.spacing;
	rig->body.object = &rig->object;
	must(motion_track_create(&rig->object.path, 1, 1, &rig->body.track));
	rig->commit_log = tmpfile();
	assert_non_null(rig->commit_log);
	enum status status = gpu_create(&(struct gpu_params){.draws = true}, &ground->gpu);
	if (status == STATUS_NO_GL) {
		store_close(ground->store);
		skip_since("no GL");
	}
	must(status);
	must(gpu_slots_create(ground->gpu, CELLS, slots, 0, &ground->slots));
	must(resident_ground_create(ground->store, 16, &ground->ground));
	must(resident_pages_create(&(struct pages_params){.gpu = ground->gpu,
						 .store = ground->store,
						 .slots = ground->slots,
						 .planes = PLANE_BIT(PLANE_OFFSET),
						 .count = slots,
						 .loaders = 2,
						 .step_pages = 16,
						 .record = world_record_pages(&rig->scene),
						 .commit_log = rig->commit_log,
						 .commit_age = 1000,
						 .before_read_back = before_read_back},
			  &ground->pages));
	ground->cache = resident_pages_cache(ground->pages);
	rig->record = calloc(1, world_record_bytes(1));
	rig->world = world_made(&rig->made);
	assert_non_null(rig->world);
	must(render_view_create(rig->world, false, &rig->view));
	start_look_ahead(rig);
}

static inline void rig_close(struct rig *rig)
{
	struct resident *ground = &rig->made.resident;
	resident_look_ahead_destroy(rig->made.ahead);
	render_view_destroy(rig->view);
	world_made_free(rig->world);
	resident_pages_destroy(ground->pages);
	resident_ground_destroy(ground->ground);
	deform_destroy(rig->made.deform);
	gpu_slots_destroy(ground->slots);
	gpu_destroy(ground->gpu);
	motion_track_destroy(rig->body.track);
	resident_requests_finish(&rig->requests);
	store_close(ground->store);
	fclose(rig->commit_log);
	free(rig->record);
}

#endif
