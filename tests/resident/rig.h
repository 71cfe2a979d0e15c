/* A world with one ball, over a small store of its own: the store, the GPU, slots, pages and deformation, without a drive. */
#ifndef FURROW_TESTS_RESIDENT_RIG_H
#define FURROW_TESTS_RESIDENT_RIG_H

#include "../gpu/staged.h"
#include "../support.h"
#include "../support/skip.h"

#include "world/internal.h"

enum { CELLS = 32 };
static const struct extent extent = {129, 129, 1, CELLS};
static const struct soil_shape sphere = {.kind = SOIL_SPHERE, .radius = 2.5};
static const struct scene_object object = {.name = "ball", .shape = {.kind = SOIL_SPHERE, .radius = 2.5}};

struct rig_params {
	support_height ground; /* heights of the store's posts */
	int level;             /* working level */
	uint32_t slots;
	double commit_age; /* s: a commit is due after it */
	bool pyramid;      /* coarser tiles follow in their slots */
};

struct rig {
	struct world world;
	struct scene scene;
	struct body body;
};

static enum status before_read_back(void *user, struct tile tile, uint32_t slot)
{
	struct world *world = user;
	return world->pyramid != NULL ? resident_pyramid_flush_tile(world->pyramid, world->cache, tile, slot) : STATUS_OK;
}

/* Makes a store at `path`, and a world over it. Skips the test where there is no GL. */
static void rig_open(struct rig *rig, const char *path, const struct rig_params *params)
{
	const int level = params->level;
	struct world *world = &rig->world;
	*rig = (struct rig){.scene = {.slots = params->slots, .hash = "0"}, .body = {.object = &object}};
	support_store(path, extent, params->ground);
	must(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &world->store));
	must(store_set_working_level(world->store, level));
	world->scene = &rig->scene;
	world->bodies = &rig->body;
	world->meta = store_meta(world->store);
	world->level = level;
	world->spacing = extent_spacing(&extent, level);
	world->commit_log = tmpfile();
	assert_non_null(world->commit_log);
	enum status status = gpu_create(&(struct gpu_params){.draws = false}, &world->gpu);
	if (status == STATUS_NO_GL) {
		store_close(world->store);
		skip_since("no GL");
	}
	must(status);
	must(gpu_slots_create(world->gpu, CELLS, params->slots, PLANE_BIT(PLANE_DISTURBANCE), &world->slots));
	must(resident_ground_create(world->store, 4, &world->ground));
	if (params->pyramid)
		must(resident_pyramid_create(&world->meta->extent, level, world->slots, NULL, &world->pyramid));
	must(deform_create(&(struct deform_params){.gpu = world->gpu,
						   .slots = world->slots,
						   .extent = &world->meta->extent,
						   .level = level,
						   .reference = resident_ground_reference(world->store),
						   .model = DEFORM_BOX_FILTER,
						   .box_radius = 1,
						   .box_repetitions = 1,
						   .disturbance = true},
			   &world->deform));
	must(resident_pages_create(&(struct pages_params){.store = world->store,
						 .gpu = world->gpu,
						 .slots = world->slots,
						 .planes = gpu_slots_planes(world->slots),
						 .level = level,
						 .count = params->slots,
						 .loaders = 2,
						 .step_pages = 64,
						 .record = world_record_pages(&rig->scene),
						 .commit_log = world->commit_log,
						 .commit_age = params->commit_age,
						 .before_read_back = before_read_back,
						 .user = world},
			  &world->pages));
	world->cache = resident_pages_cache(world->pages);
	world->record = calloc(1, world_record_bytes(0));
}

static void rig_close(struct rig *rig)
{
	struct world *world = &rig->world;
	resident_newest_destroy(world->newest);
	resident_pages_destroy(world->pages);
	deform_destroy(world->deform);
	resident_pyramid_destroy(world->pyramid);
	resident_ground_destroy(world->ground);
	gpu_slots_destroy(world->slots);
	gpu_destroy(world->gpu);
	store_close(world->store);
	fclose(world->commit_log);
	free(world->record);
}

/* Rolls the ball to where it is in this step. Returns false if there is no ground. */
static bool roll(struct rig *rig, int step)
{
	double angle = step * 0.05, x = 64 + 50 * sin(angle), y = 64 + 45 * sin(2.1 * angle);
	struct event event = {.contact = true, .pose = {.x = lattice_offset(x), .y = lattice_offset(y)}};
	int64_t ground;
	bool any;
	must(resident_ground_height(rig->world.ground, event.pose.x, event.pose.y, &ground, &any));
	if (!any)
		return false;
	event.pose.z = ground + lattice_offset(sphere.radius - 0.4);
	must(world_contact(&rig->world, &event, true));
	return true;
}

static void end_step(struct rig *rig)
{
	if (rig->world.pyramid != NULL)
		must(resident_pyramid_flush(rig->world.pyramid, rig->world.cache));
	rig->world.record->step++;
	must(page_cache_end_step(rig->world.cache, rig->world.record));
}

#endif
