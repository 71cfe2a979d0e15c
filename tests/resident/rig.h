/*
 * A world with one ball, over a small store of its own: the store, slots, pages and deformation, without a drive. The home of pages is the GPU, or
 * host memory without any GL. There the rig itself presses the ball into the ground.
 */
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
	bool host;         /* the home of pages is host memory */
};

struct rig {
	struct world world;
	struct scene scene;
	struct body body;
	struct host_slots *host; /* NULL: the home is the GPU */
};

static enum status before_read_back(void *user, struct tile tile, uint32_t slot)
{
	struct world *world = user;
	return world->pyramid != NULL ? resident_pyramid_flush_tile(world->pyramid, world->cache, tile, slot) : STATUS_OK;
}

/* The GPU, slots in it, and deformation. Skips the test where there is no GL. */
static void rig_open_gpu(struct world *world, const struct rig_params *params)
{
	enum status status = gpu_create(&(struct gpu_params){.draws = false}, &world->gpu);
	if (status == STATUS_NO_GL) {
		store_close(world->store);
		skip_since("no GL");
	}
	must(status);
	must(gpu_slots_create(world->gpu, CELLS, params->slots, PLANE_BIT(PLANE_DISTURBANCE), &world->slots));
	must(deform_create(&(struct deform_params){.gpu = world->gpu,
						   .slots = world->slots,
						   .extent = &world->meta->extent,
						   .level = params->level,
						   .reference = resident_ground_reference(world->store),
						   .model = DEFORM_BOX_FILTER,
						   .box_radius = 1,
						   .box_repetitions = 1,
						   .disturbance = true},
			   &world->deform));
}

/* Makes a store at `path`, and a world over it. Skips the test where there is no GL and GL is needed. */
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
	if (params->host)
		must(resident_host_create(CELLS, params->slots, PLANE_BIT(PLANE_DISTURBANCE), &rig->host));
	else
		rig_open_gpu(world, params);
	must(resident_ground_create(world->store, 4, &world->ground));
	if (params->pyramid)
		must(resident_pyramid_create(&world->meta->extent, level, world->slots, rig->host, &world->pyramid));
	must(resident_pages_create(&(struct pages_params){.store = world->store,
						 .gpu = world->gpu,
						 .slots = world->slots,
						 .host = rig->host,
						 .planes = PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE),
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
	resident_host_destroy(rig->host);
	gpu_slots_destroy(world->slots);
	gpu_destroy(world->gpu);
	store_close(world->store);
	fclose(world->commit_log);
	free(world->record);
}

/* Makes the tile in the slot deformed, with the posts that it had. */
static inline void rig_touch(struct rig *rig, uint32_t slot)
{
	must(rig->host != NULL ? resident_host_write(rig->host, slot, ~0u) : gpu_slots_deform(rig->world.slots, slot));
}

/* Lowers posts to the ball's underside. `centre`: in metres, z above the store's reference. */
static inline void press_posts(const struct rig *rig, const double centre[3], const struct soil_planes *planes)
{
	const struct post_rect *rect = &planes->rect;
	for (int64_t y = rect->y0; y < rect->y1; y++)
		for (int64_t x = rect->x0; x < rect->x1; x++) {
			const size_t at = (size_t)(y - rect->y0) * planes->width + (size_t)(x - rect->x0);
			const double dx = (double)x * rig->world.spacing - centre[0], dy = (double)y * rig->world.spacing - centre[1];
			const double up = sphere.radius * sphere.radius - dx * dx - dy * dy;
			if (planes->base[at] == BASE_NODATA || up <= 0)
				continue;
			const int32_t lowest = (int32_t)(lattice_offset(centre[2] - sqrt(up)) - (int64_t)planes->base[at] * 4);
			if (lowest >= planes->offset[at])
				continue;
			planes->offset[at] = lowest;
			planes->disturbance[at] = 255;
		}
}

/* Presses the ball into tiles in host memory, as a step does that bears. */
static inline void press(struct rig *rig, const struct soil_pose *pose)
{
	struct world *world = &rig->world;
	const double centre[3] = {lattice_offset_metres(pose->x), lattice_offset_metres(pose->y),
				  lattice_offset_metres(pose->z) - resident_ground_reference(world->store)};
	const int64_t x = (int64_t)(centre[0] / world->spacing), y = (int64_t)(centre[1] / world->spacing), reach = (int64_t)(sphere.radius / world->spacing) + 2;
	const struct post_rect rect = {x - reach, y - reach, x + reach, y + reach};
	enum { MOST = 64 };
	static int32_t base[MOST * MOST], offset[MOST * MOST];
	static uint8_t disturbance[MOST * MOST];
	const struct soil_planes planes = {.rect = rect, .width = MOST, .base = base, .offset = offset, .disturbance = disturbance};
	struct tile_slot held[64];
	uint64_t keys[64];
	uint32_t slots[64];
	size_t count = 0;
	struct tile first, last;
	assert_true(2 * reach <= MOST && tile_range_of(&world->meta->extent, world->level, rect, &first, &last));
	for (uint32_t ty = first.y; ty <= last.y; ty++)
		for (uint32_t tx = first.x; tx <= last.x; tx++)
			keys[count++] = tile_key((struct tile){world->level, tx, ty});
	must(page_cache_pin_all(world->cache, keys, count, slots));
	for (size_t i = 0; i < count; i++) {
		held[i] = (struct tile_slot){tile_from_key(keys[i]), slots[i]};
		must(resident_host_write(rig->host, slots[i], ~0u));
	}
	resident_host_gather(rig->host, held, count, &planes);
	press_posts(rig, centre, &planes);
	resident_host_scatter(rig->host, held, count, &planes, rect, PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE));
	for (size_t i = 0; i < count; i++) {
		page_cache_dirty(world->cache, keys[i]);
		page_cache_unpin(world->cache, keys[i]);
		if (world->pyramid != NULL)
			must(resident_pyramid_changed(world->pyramid, held[i].tile, rect));
	}
	resident_newest_changed(world->newest);
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
	if (rig->host != NULL)
		press(rig, &event.pose);
	else
		must(world_contact(&rig->world, &event));
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
