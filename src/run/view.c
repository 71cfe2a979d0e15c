/* Frames: where the camera is, what terrain selected, what the cache has of it, what is drawn. */
#include <math.h>
#include <string.h>
#include <time.h>

#include "render/render.h"
#include "run/internal.h"
#include "run/key_map.h"
#include "terrain/terrain.h"

struct view {
	struct drive *drive;
	struct render *render;
	struct key_map deformed; /* tiles with offset tiles at or below them */
	struct key_map bounds;   /* base ranges already read; NaN: nothing there */
	double reach;            /* metres deformation can add to a tile's bounds */
	struct terrain_selection *selection;
	uint64_t starved;        /* frames in which a coarser tile stood in */
	double triangles;        /* summed over frames */
	enum status failed;      /* of a source callback */
};

/* --- what terrain asks --- */

static bool bounds(void *user, struct tile tile, double *low, double *high)
{
	struct view *view = user;
	const struct drive *drive = view->drive;
	if (!world_has(&drive->meta->world, tile))
		return false;
	uint64_t key = tile_key(tile);
	bool deformed = key_map_find(&view->deformed, key) != NULL;
	if (tile.level < 0 && !deformed)
		return false;
	const struct key_pair *known = key_map_find(&view->bounds, key);
	if (known == NULL) {
		double a, b;
		bool any = false;
		enum status status = ground_range(drive->ground, tile, &a, &b, &any);
		if (status == STATUS_OK)
			status = key_map_put(&view->bounds, key, any ? a : (double)NAN, b);
		if (status != STATUS_OK) {
			view->failed = status;
			return false;
		}
		known = key_map_find(&view->bounds, key);
	}
	double slack = deformed ? view->reach : 0;
	*low = known->a - slack;
	*high = known->b + slack;
	return !isnan(known->a);
}

static bool resident(void *user, struct tile tile, uint32_t *slot)
{
	struct view *view = user;
	return page_cache_peek(view->drive->cache, tile_key(tile), true, slot);
}

static bool divisible(void *user, struct tile tile)
{
	struct view *view = user;
	bool deformed = key_map_find(&view->deformed, tile_key(tile)) != NULL;
	/* Offsets live at the working level: nothing finer than it knows of them. */
	return deformed ? tile.level > view->drive->level : tile.level > 0;
}

enum status view_deformed(struct view *view, struct tile tile)
{
	int coarsest = world_coarsest(&view->drive->meta->world);
	for (int level = tile.level; level <= coarsest; level++) {
		uint64_t key = tile_key(tile_ancestor(tile, level));
		if (key_map_find(&view->deformed, key) != NULL)
			return STATUS_OK;
		enum status status = key_map_put(&view->deformed, key, 0, 0);
		if (status != STATUS_OK)
			return status;
	}
	return STATUS_OK;
}

static enum status deformed_key(void *user, uint64_t key)
{
	return view_deformed(user, tile_from_key(key));
}

/* --- the camera --- */

static double ground_at(const struct view *view, double x, double y, double otherwise)
{
	int64_t height;
	bool any;
	if (ground_height(view->drive->ground, lattice_offset(x), lattice_offset(y), &height, &any) != STATUS_OK || !any)
		return otherwise;
	return lattice_offset_metres(height);
}

size_t view_places(const void *user, double time, double places[2][2])
{
	const struct drive *drive = user;
	const struct scene_view *wish = &drive->scene->view;
	if (wish->camera == SCENE_FIXED)
		return 0;
	const struct rider *rider = &drive->riders[wish->target_object];
	struct track_point now, before;
	track_at(rider->track, time, &now);
	places[0][0] = now.x;
	places[0][1] = now.y;
	if (wish->camera == SCENE_OVERHEAD)
		return 1;
	/* Behind along the chord of the last stretch, which turns slower than the path does. */
	double speed = fmax(rider->object->path.speed, 0.1);
	double back = fmin(time, 1.5 * wish->back / speed);
	track_at(rider->track, time - back, &before);
	double dx = now.x - before.x, dy = now.y - before.y, length = hypot(dx, dy);
	if (rider->object->path.loop || length < 0.1 * wish->back || back <= 0) {
		dx = cos(now.yaw);
		dy = sin(now.yaw);
		length = 1;
	}
	places[1][0] = now.x - dx / length * wish->back;
	places[1][1] = now.y - dy / length * wish->back;
	return 2;
}

static void place_camera(const struct view *view, struct render_camera *camera)
{
	const struct drive *drive = view->drive;
	const struct scene_view *wish = &drive->scene->view;
	camera->fov = 0.9;
	double places[2][2];
	if (view_places(drive, drive->time, places) == 0) {
		memcpy(camera->eye, wish->eye, sizeof camera->eye);
		memcpy(camera->target, wish->target, sizeof camera->target);
		return;
	}
	double middle = (drive->meta->low + drive->meta->high) / 2;
	double ground = ground_at(view, places[0][0], places[0][1], isnan(middle) ? 0 : middle);
	camera->target[0] = places[0][0];
	camera->target[1] = places[0][1];
	camera->target[2] = ground;
	if (wish->camera == SCENE_OVERHEAD) {
		/* A hair off the vertical, so that north is up. */
		camera->eye[0] = places[0][0];
		camera->eye[1] = places[0][1] - 0.02 * wish->over_height;
		camera->eye[2] = ground + wish->over_height;
		return;
	}
	camera->eye[0] = places[1][0];
	camera->eye[1] = places[1][1];
	double below = ground_at(view, places[1][0], places[1][1], ground);
	camera->eye[2] = fmax(ground, below) + wish->up;
}

/* --- frames --- */

static enum status select_tiles(struct view *view, const struct render_camera *camera)
{
	const struct terrain_source source = {view, bounds, resident, divisible};
	struct terrain_view looking;
	render_view(view->render, camera, &looking);
	view->failed = STATUS_OK;
	terrain_select(&view->drive->meta->world, &looking, &source, view->selection);
	return view->failed;
}

static void ask_for_wanted(struct view *view)
{
	page_cache_want(view->drive->cache, view->selection->wanted, view->selection->wanted_count);
}

/* A picture that is kept waits for its tiles, unless the slots cannot hold them. */
static enum status wait_for_wanted(struct view *view, const struct render_camera *camera)
{
	struct page_cache *cache = view->drive->cache;
	const struct run_params *params = view->drive->params;
	const struct timespec nap = {0, 500000};
	double started = clock_seconds(), progressed = started;
	size_t least = SIZE_MAX;
	while (view->selection->wanted_count > 0) {
		double now = clock_seconds();
		if (view->selection->wanted_count < least) {
			least = view->selection->wanted_count;
			progressed = now;
		}
		if (now - progressed > 1 || now - started > 10 || (params->stop != NULL && *params->stop))
			break;
		ask_for_wanted(view);
		nanosleep(&nap, NULL);
		enum status status = page_cache_poll(cache);
		if (status == STATUS_OK)
			status = select_tiles(view, camera);
		if (status != STATUS_OK)
			return status;
	}
	if (view->selection->wanted_count == 0)
		return STATUS_OK;
	/* Few slots, or a tile that cannot be read: a prefetch would not say. */
	uint32_t slot;
	uint64_t key = view->selection->wanted[0];
	enum status status = page_cache_pin(cache, key, &slot);
	if (status != STATUS_OK)
		return status;
	page_cache_unpin(cache, key);
	return select_tiles(view, camera);
}

enum status view_warm(struct view *view)
{
	struct render_camera camera;
	place_camera(view, &camera);
	enum status status = select_tiles(view, &camera);
	if (status == STATUS_OK)
		status = wait_for_wanted(view, &camera);
	return status == STATUS_OK ? render_frame(view->render, &camera, view->selection) : status;
}

enum status view_frame(struct view *view, struct drive *drive, bool image)
{
	struct render_camera camera;
	place_camera(view, &camera);
	enum status status = select_tiles(view, &camera);
	if (status == STATUS_OK && image)
		status = wait_for_wanted(view, &camera);
	if (status == STATUS_OK)
		status = render_frame(view->render, &camera, view->selection);
	if (status != STATUS_OK)
		return status;
	view->triangles += (double)render_triangles(view->render);
	view->starved += view->selection->wanted_count > 0;
	drive->frames++;
	ask_for_wanted(view);
	if (!image)
		return STATUS_OK;
	char path[4096];
	snprintf(path, sizeof path, "%s/frame-%06lld.png", drive->params->directory, (long long)drive->step);
	return render_write_png(view->render, path);
}

/* --- life --- */

static enum status find_reach(const struct drive *drive, double *out)
{
	double reach = 0, deepest = 0, low, high;
	bool found;
	for (size_t i = 0; i < drive->scene->object_count; i++) {
		const struct scene_object *object = &drive->scene->objects[i];
		const double *size = object->shape.size;
		reach = fmax(reach, object->sink + 2 * object->shape.radius +
					    sqrt(size[0] * size[0] + size[1] * size[1] + size[2] * size[2]));
		/* A path with heights of its own may dig as deep as it lies below the ground. */
		for (size_t k = 0; object->path.has_z && k < object->path.count; k++)
			deepest = fmax(deepest, drive->meta->high - object->path.points[k].z);
	}
	reach += deepest;
	struct tile top = {world_coarsest(&drive->meta->world), 0, 0};
	enum status status = store_read_offset_range(ground_reader(drive->ground), top, &low, &high, &found);
	if (status == STATUS_OK && found)
		reach = fmax(reach, fmax(-low, high));
	*out = reach;
	return status;
}

enum status view_create(struct drive *drive, struct view **out)
{
	const struct scene *scene = drive->scene;
	struct view *view = mem_calloc(1, sizeof *view);
	if (view == NULL)
		return fail_memory("the view");
	view->drive = drive;
	view->selection = mem_alloc(1, sizeof *view->selection);
	struct render_params params = {
		.gpu = drive->gpu,
		.slots = drive->slots,
		.world = &drive->meta->world,
		.reference = ground_reference(drive->store),
		.low = isnan(drive->meta->low) ? 0 : drive->meta->low,
		.high = isnan(drive->meta->high) ? 0 : drive->meta->high,
		.width = scene->view.width,
		.height = scene->view.height,
		.effects = scene->view.effects,
		.dirt = scene->dirt,
	};
	enum status status = view->selection != NULL ? STATUS_OK : fail_memory("the view");
	if (status == STATUS_OK)
		status = find_reach(drive, &view->reach);
	if (status == STATUS_OK)
		status = render_create(&params, &view->render);
	int level;
	if (status == STATUS_OK && store_has_working_level(drive->store, &level))
		status = store_each_offset(ground_reader(drive->ground), level, deformed_key, view);
	if (status != STATUS_OK) {
		view_destroy(view);
		return status;
	}
	*out = view;
	return STATUS_OK;
}

void view_destroy(struct view *view)
{
	if (view == NULL)
		return;
	render_destroy(view->render);
	key_map_finish(&view->deformed);
	key_map_finish(&view->bounds);
	mem_free(view->selection);
	mem_free(view);
}

void view_figures(const struct view *view, double *triangles, uint64_t *starved)
{
	size_t frames = view->drive->frames;
	*triangles = frames > 0 ? view->triangles / (double)frames : 0;
	*starved = view->starved;
}
