/* What the tests of views share: a drive over small hills, with pages and a view, in which no step is made. */
#ifndef FURROW_TESTS_RUN_VIEW_RIG_H
#define FURROW_TESTS_RUN_VIEW_RIG_H

#include "../support.h"

#include "run/view.h"

enum { CELLS = 16 };
static const struct world world = {513, 513, 1, CELLS};

struct rig {
	struct drive drive;
	struct scene scene;
	struct scene_object object;
	struct scene_waypoint points[2];
	struct rider rider;
	struct run_params params;
};

static inline enum status before_read_back(void *user, struct tile tile, uint32_t slot)
{
	return STATUS_OK; /* nothing is ever dirty here */
}

/* At the drive's level, which the objects' windows are of. */
static inline void start_prefetch(struct drive *drive)
{
	prefetch_destroy(drive->prefetch);
	deform_destroy(drive->deform);
	struct deform_params params = {.gpu = drive->gpu, .slots = drive->slots, .world = &drive->meta->world,
				       .level = drive->level};
	must(deform_create(&params, &drive->deform));
	must(prefetch_create(drive, &drive->prefetch));
}

/* A wide view from a corner; or, with a speed, one behind an object that crosses the terrain. */
static inline void rig_open(struct rig *rig, uint32_t slots, double speed, double prefetch)
{
	struct drive *drive = &rig->drive;
	const char *path = support_path("view.furrow");
	*rig = (struct rig){.points = {{.x = 40, .y = 60}, {.x = 460, .y = 440}}};
	rig->object = (struct scene_object){
		.name = "it",
		.shape = {.kind = DEFORM_SPHERE, .radius = 0.5},
		.path = {.points = rig->points, .count = 2, .speed = speed},
	};
	rig->scene = (struct scene){
		.end_time = 1000, .slots = slots, .loaders = 2, .prefetch = prefetch, .objects = &rig->object, .object_count = 1,
		.view = {.present = true, .width = 320, .height = 180, .camera = speed > 0 ? SCENE_CHASE : SCENE_FIXED,
			 .back = 12, .up = 5, .eye = {20, 20, 130}, .target = {200, 220, 100}},
	};
	if (access(path, F_OK) != 0)
		support_store(path, world, support_hills);
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &drive->store)); /* nothing is deformed */
	drive->scene = &rig->scene;
	rig->params.directory = support_folder;
	drive->params = &rig->params;
	drive->meta = store_meta(drive->store);
	drive->was_deformed = store_has_working_level(drive->store, NULL);
	drive->spacing = world.spacing;
	drive->riders = &rig->rider;
	rig->rider.object = &rig->object;
	const double places[2][2] = {{40, 60}, {460, 440}};
	must(track_create(&rig->object.path, places, 1, 1, &rig->rider.track));
	drive->epochs = tmpfile();
	assert_non_null(drive->epochs);
	enum status status = gpu_create(&(struct gpu_params){.draws = true}, &drive->gpu);
	if (status == STATUS_NO_GL) {
		store_close(drive->store);
		skip();
	}
	must(status);
	must(gpu_slots_create(drive->gpu, CELLS, slots, 0, &drive->slots));
	must(ground_create(drive->store, 16, &drive->ground));
	must(pages_create(&(struct pages_params){.gpu = drive->gpu,
						 .store = drive->store,
						 .slots = drive->slots,
						 .planes = PLANE_BIT(PLANE_OFFSET),
						 .count = slots,
						 .loaders = 2,
						 .step_pages = 16,
						 .scene = &rig->scene,
						 .epochs = drive->epochs,
						 .epoch_age = 1000,
						 .before_read_back = before_read_back},
			  &drive->pages));
	drive->cache = pages_cache(drive->pages);
	drive->record = calloc(1, record_bytes(1));
	must(view_create(drive, &drive->view));
	start_prefetch(drive);
}

static inline void rig_close(struct rig *rig)
{
	struct drive *drive = &rig->drive;
	prefetch_destroy(drive->prefetch);
	view_destroy(drive->view);
	pages_destroy(drive->pages);
	ground_destroy(drive->ground);
	deform_destroy(drive->deform);
	gpu_slots_destroy(drive->slots);
	gpu_destroy(drive->gpu);
	track_destroy(rig->rider.track);
	wishes_finish(&drive->wishes);
	store_close(drive->store);
	fclose(drive->epochs);
	free(drive->record);
}

#endif
