/*
 * The ground of a small store of its own, in memory, and one ball that is pressed into it: the store, slots and pages, without a world. The home of
 * pages is the GPU, where deform computes the ball's contacts, or host memory without any GL. There the rig itself presses the ball into the ground.
 */
#ifndef FURROW_TESTS_RESIDENT_RIG_H
#define FURROW_TESTS_RESIDENT_RIG_H

#include "../gpu/staged.h"
#include "../support.h"
#include "../support/skip.h"

#include "deform/deform.h"
#include "resident/resident.h"
#include "scene/scene.h"
#include "world/record.h"

enum { CELLS = 32, TILES_MOST = 64 };
static const struct extent extent = {129, 129, 1, CELLS};
static const struct soil_shape sphere = {.kind = SOIL_SPHERE, .radius = 2.5};

struct rig_params {
	support_height ground; /* heights of the store's posts */
	int level;             /* working level */
	uint32_t slots;
	double commit_age; /* s: a commit is due after it */
	bool pyramid;      /* coarser tiles follow in their slots */
	bool host;         /* the home of pages is host memory */
};

struct rig {
	struct resident ground;
	struct scene scene;    /* what the record is written for */
	struct record *record;
	FILE *commit_log;
	struct deform *deform; /* NULL: the home is host memory */
	struct soil_pose last; /* of the ball, on the GPU */
	bool has_last;       /* `last` is a pose in contact */
};

static enum status before_read_back(void *user, struct tile tile, uint32_t slot)
{
	struct resident *ground = user;
	return ground->pyramid != NULL ? resident_pyramid_flush_tile(ground->pyramid, ground->cache, tile, slot) : STATUS_OK;
}

/* The GPU, slots in it, and deformation. Skips the test where there is no GL. */
static void rig_open_gpu(struct rig *rig, const struct rig_params *params)
{
	struct resident *ground = &rig->ground;
	enum status status = gpu_create(&(struct gpu_params){.draws = false}, &ground->gpu);
	if (status == STATUS_NO_GL) {
		store_close(ground->store);
		skip_since("no GL");
	}
	must(status);
	must(gpu_slots_create(ground->gpu, CELLS, params->slots, PLANE_BIT(PLANE_DISTURBANCE), &ground->slots));
	must(deform_create(&(struct deform_params){.gpu = ground->gpu,
						   .slots = ground->slots,
						   .extent = &ground->meta->extent,
						   .level = params->level,
						   .reference = resident_ground_reference(ground->store),
						   .model = DEFORM_BOX_FILTER,
						   .box_radius = 1,
						   .box_repetitions = 1,
						   .disturbance = true},
			   &rig->deform));
}

/* Makes a store at `path`, and its ground in memory. Skips the test where there is no GL and GL is needed. */
static void rig_open(struct rig *rig, const char *path, const struct rig_params *params)
{
	const int level = params->level;
	struct resident *ground = &rig->ground;
	*rig = (struct rig){.scene = {.slots = params->slots, .hash = "0"}};
	support_store(path, extent, params->ground);
	must(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &ground->store));
	must(store_set_working_level(ground->store, level));
	ground->meta = store_meta(ground->store);
	ground->level = level;
	ground->spacing = extent_spacing(&extent, level);
	rig->commit_log = tmpfile();
	assert_non_null(rig->commit_log);
	if (params->host)
		must(resident_host_create(CELLS, params->slots, PLANE_BIT(PLANE_DISTURBANCE), &ground->host));
	else
		rig_open_gpu(rig, params);
	must(resident_ground_create(ground->store, 4, &ground->ground));
	if (params->pyramid)
		must(resident_pyramid_create(&ground->meta->extent, level, ground->slots, ground->host, &ground->pyramid));
	must(resident_pages_create(&(struct pages_params){.store = ground->store,
						 .gpu = ground->gpu,
						 .slots = ground->slots,
						 .host = ground->host,
						 .planes = PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE),
						 .level = level,
						 .count = params->slots,
						 .loaders = 2,
						 .step_pages = 64,
						 .record = world_record_pages(&rig->scene),
						 .commit_log = rig->commit_log,
						 .commit_age = params->commit_age,
						 .before_read_back = before_read_back,
						 .user = ground},
			  &ground->pages));
	ground->cache = resident_pages_cache(ground->pages);
	rig->record = calloc(1, world_record_bytes(0));
}

static void rig_close(struct rig *rig)
{
	struct resident *ground = &rig->ground;
	resident_newest_destroy(ground->newest);
	resident_pages_destroy(ground->pages);
	deform_destroy(rig->deform);
	resident_pyramid_destroy(ground->pyramid);
	resident_ground_destroy(ground->ground);
	resident_host_destroy(ground->host);
	gpu_slots_destroy(ground->slots);
	gpu_destroy(ground->gpu);
	store_close(ground->store);
	fclose(rig->commit_log);
	free(rig->record);
}

/* Makes the tile in the slot deformed, with the posts that it had. */
static inline void rig_touch(struct rig *rig, uint32_t slot)
{
	must(rig->ground.host != NULL ? resident_host_write(rig->ground.host, slot, ~0u) : gpu_slots_deform(rig->ground.slots, slot));
}

/* Lowers posts to the ball's underside. `centre`: in metres, z above the store's reference. */
static inline void press_posts(const struct rig *rig, const double centre[3], const struct soil_planes *planes)
{
	const struct post_rect *rect = &planes->rect;
	for (int64_t y = rect->y0; y < rect->y1; y++)
		for (int64_t x = rect->x0; x < rect->x1; x++) {
			const size_t at = (size_t)(y - rect->y0) * planes->width + (size_t)(x - rect->x0);
			const double dx = (double)x * rig->ground.spacing - centre[0], dy = (double)y * rig->ground.spacing - centre[1];
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

/* Pins all tiles that hold a post of the rectangle. Returns their number. */
static inline size_t hold(struct rig *rig, struct post_rect rect, struct tile_slot held[TILES_MOST])
{
	uint64_t keys[TILES_MOST];
	uint32_t slots[TILES_MOST];
	size_t count = 0;
	struct tile first, last;
	assert_true(tile_range_of(&rig->ground.meta->extent, rig->ground.level, rect, &first, &last));
	assert_true((last.x - first.x + 1) * (last.y - first.y + 1) <= TILES_MOST);
	for (uint32_t ty = first.y; ty <= last.y; ty++)
		for (uint32_t tx = first.x; tx <= last.x; tx++)
			keys[count++] = tile_key((struct tile){rig->ground.level, tx, ty});
	must(page_cache_pin_all(rig->ground.cache, keys, count, slots));
	for (size_t i = 0; i < count; i++)
		held[i] = (struct tile_slot){tile_from_key(keys[i]), slots[i]};
	return count;
}

static inline void release(struct rig *rig, const struct tile_slot *held, size_t count)
{
	for (size_t i = 0; i < count; i++)
		page_cache_unpin(rig->ground.cache, tile_key(held[i].tile));
}

/* Posts of the rectangle have changed in these tiles: pages, coarser levels and queries learn of it. */
static inline void mark(struct rig *rig, struct post_rect rect, const struct tile_slot *held, size_t count)
{
	for (size_t i = 0; i < count; i++) {
		if (post_rect_empty(post_rect_intersect(rect, tile_post_rect(&rig->ground.meta->extent, held[i].tile))))
			continue;
		page_cache_dirty(rig->ground.cache, tile_key(held[i].tile));
		if (rig->ground.pyramid != NULL)
			must(resident_pyramid_changed(rig->ground.pyramid, held[i].tile, rect));
	}
	resident_newest_changed(rig->ground.newest);
}

/* Presses the ball into tiles in host memory, as a step does that bears. */
static inline void press_host(struct rig *rig, const struct soil_pose *pose)
{
	const double spacing = rig->ground.spacing;
	const double centre[3] = {lattice_offset_metres(pose->x), lattice_offset_metres(pose->y),
				  lattice_offset_metres(pose->z) - resident_ground_reference(rig->ground.store)};
	const int64_t x = (int64_t)(centre[0] / spacing), y = (int64_t)(centre[1] / spacing), reach = (int64_t)(sphere.radius / spacing) + 2;
	const struct post_rect rect = {x - reach, y - reach, x + reach, y + reach};
	enum { MOST = 64 };
	static int32_t base[MOST * MOST], offset[MOST * MOST];
	static uint8_t disturbance[MOST * MOST];
	const struct soil_planes planes = {.rect = rect, .width = MOST, .base = base, .offset = offset, .disturbance = disturbance};
	struct tile_slot held[TILES_MOST];
	assert_true(2 * reach <= MOST);
	const size_t count = hold(rig, rect, held);
	for (size_t i = 0; i < count; i++)
		must(resident_host_write(rig->ground.host, held[i].slot, ~0u));
	resident_host_gather(rig->ground.host, held, count, &planes);
	press_posts(rig, centre, &planes);
	resident_host_scatter(rig->ground.host, held, count, &planes, rect, PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE));
	mark(rig, rect, held, count);
	release(rig, held, count);
}

/* Presses the ball into slots of the GPU, from its last pose to this one. Each window reads the ground as it was before any of them changed it. */
static inline void press_gpu(struct rig *rig, const struct soil_pose *pose)
{
	const struct deform_contact contact = {.shape = &sphere, .from = rig->has_last ? rig->last : *pose, .to = *pose};
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	struct tile_slot held[TILES_MOST];
	size_t count = 0;
	must(deform_windows(rig->deform, &contact, windows, &count));
	for (size_t i = 0; i < count; i++) {
		const size_t tiles = hold(rig, windows[i].read, held);
		must(deform_compute(rig->deform, &contact, &windows[i], (uint32_t)i, held, tiles));
		release(rig, held, tiles);
	}
	for (size_t i = 0; i < count; i++) {
		const size_t tiles = hold(rig, windows[i].write, held);
		must(deform_scatter(rig->deform, &windows[i], (uint32_t)i, held, tiles));
		mark(rig, windows[i].write, held, tiles);
		release(rig, held, tiles);
	}
	rig->last = *pose;
	rig->has_last = true;
}

/* Rolls the ball to where it is in this step. Returns false if there is no ground. */
static bool roll(struct rig *rig, int step)
{
	double angle = step * 0.05, x = 64 + 50 * sin(angle), y = 64 + 45 * sin(2.1 * angle);
	struct soil_pose pose = {.x = lattice_offset(x), .y = lattice_offset(y)};
	int64_t ground;
	bool any;
	must(resident_ground_height(rig->ground.ground, pose.x, pose.y, &ground, &any));
	if (!any)
		return false;
	pose.z = ground + lattice_offset(sphere.radius - 0.4);
	if (rig->ground.host != NULL)
		press_host(rig, &pose);
	else
		press_gpu(rig, &pose);
	return true;
}

static void end_step(struct rig *rig)
{
	if (rig->ground.pyramid != NULL)
		must(resident_pyramid_flush(rig->ground.pyramid, rig->ground.cache));
	rig->record->step++;
	must(page_cache_end_step(rig->ground.cache, rig->record));
}

#endif
