/* Frames: what terrain selected for the camera, what the cache has of it, what is drawn. */
#include <math.h>
#include <time.h>

#include "run/view.h"

#define RANGES 16384 /* tiles one selection asks about, and room to move */

/* --- frames --- */

/* Asks for what a selection wanted while a picture waits: all of it, and nothing else. */
static void ask(struct view *view)
{
	page_cache_want(view->drive->cache, view->selection->wanted, view->selection->wanted_count);
}

/* Waits for the coarsest tile that is missing. It says why, where a prefetch would not. */
static enum status load_first(struct view *view, const struct render_camera *camera)
{
	uint32_t slot;
	uint64_t key = view->selection->wanted[0];
	enum status status = page_cache_pin(view->drive->cache, key, &slot);
	if (status != STATUS_OK)
		return status;
	page_cache_unpin(view->drive->cache, key);
	return view_select(view, camera, false);
}

/* A picture that is kept waits for its tiles, however long. They fit: it ends when they are there. What comes no
 * nearer, or what no loader brings, is pinned: that says why, if it cannot be read. */
static enum status wait_for_wanted(struct view *view, const struct render_camera *camera)
{
	const struct drive *drive = view->drive;
	const volatile sig_atomic_t *stop = drive->params->stop;
	const struct timespec nap = {0, 500000};
	double progressed = clock_seconds();
	size_t least = SIZE_MAX;
	enum status status = STATUS_OK;
	while (view->selection->wanted_count > 0 && status == STATUS_OK) {
		double now = clock_seconds();
		if (view->selection->wanted_count < least) {
			least = view->selection->wanted_count;
			progressed = now;
		}
		if (stop != NULL && *stop)
			return load_first(view, camera);
		/* What only stands in meanwhile must not be in the way of what it stands in for. */
		view_mark_used(view, false);
		ask(view);
		if (drive->scene->loaders == 0 || now - progressed > 1) {
			status = load_first(view, camera);
			continue;
		}
		nanosleep(&nap, NULL);
		status = page_cache_poll(drive->cache);
		if (status == STATUS_OK)
			status = view_select(view, camera, false);
	}
	return status;
}

static bool has_ground(const struct view *view)
{
	uint32_t slot;
	struct tile coarsest = {world_coarsest(&view->drive->meta->world), 0, 0};
	return view->selection->wanted_count == 0 ||
	       page_cache_peek(view->drive->cache, tile_key(coarsest), false, &slot);
}

static enum status draw(struct view *view, bool complete)
{
	struct render_camera camera;
	view_place_camera(view, view->drive->time, &camera);
	enum status status = view_select(view, &camera, false);
	if (status == STATUS_OK && complete)
		status = wait_for_wanted(view, &camera);
	/* Where the step pins every slot not even the coarsest tile stays, and a picture needs one. */
	if (status == STATUS_OK && !has_ground(view))
		status = load_first(view, &camera);
	if (status != STATUS_OK)
		return status;
	view_mark_used(view, true);
	view_keep_now(view);
	status = view_set_objects(view, complete);
	if (status != STATUS_OK)
		return status;
	return render_frame(view->render, &camera, view->selection);
}

enum status view_warm(struct view *view)
{
	const struct drive *drive = view->drive;
	bool deformed = pages_planes_of(drive->scene, drive->was_deformed) != 0;
	enum status status = render_warm(view->render, deformed, drive->level < 0);
	if (status == STATUS_OK)
		status = render_draw_unseen(view->render, deformed, drive->level < 0);
	if (status == STATUS_OK)
		status = draw(view, drive->params->host == NULL); /* who watches sees it come */
	for (int i = 0; i < VIEW_LOOKS && status == STATUS_OK; i++)
		status = view_look_ahead(view);
	/* It is none of the drive's pictures. */
	double overdraw;
	gpu_finish(drive->gpu);
	render_take_overdraw(view->render, &overdraw);
	return status;
}

static void take_overdraw(struct view *view)
{
	double overdraw;
	view->overdraw_frames += render_take_overdraw(view->render, &overdraw);
	view->overdraw += overdraw;
}

void view_settle(struct view *view)
{
	gpu_finish(view->drive->gpu);
	take_overdraw(view);
}

enum status view_frame(struct view *view, struct drive *drive, bool image)
{
	enum status status = pictures_poll(drive->pictures);
	if (status == STATUS_OK)
		status = draw(view, image);
	if (status != STATUS_OK)
		return status;
	struct render_tiles tiles;
	render_tiles(view->render, &tiles);
	view->tiles.drawn += tiles.drawn;
	view->tiles.deformed += tiles.deformed;
	view->tiles.objects += tiles.objects;
	view->tiles.shadowed += tiles.shadowed;
	view->triangles += (double)render_triangles(view->render);
	take_overdraw(view);
	view->lacks = view->selection->wanted_count > 0;
	view->starved += view->coarse || view->selection->wanted_count > 0;
	view->coarsened += view->coarse;
	drive->frames++;
	status = view_look_ahead(view);
	if (!image || status != STATUS_OK)
		return status;
	return pictures_begin(drive->pictures, view->render, drive->step);
}

/* --- life --- */

static enum status make_render(const struct drive *drive, struct render **out)
{
	struct render_params params;
	drive_render_params(drive, &params);
	params.gpu = drive->gpu;
	params.slots = drive->slots;
	params.reference = ground_reference(drive->store);
	params.low = isnan(drive->meta->low) ? 0 : drive->meta->low;
	params.high = isnan(drive->meta->high) ? 0 : drive->meta->high;
	params.layers = drive->params->host != NULL;
	return render_create(&params, out);
}

static enum status deformed_key(void *user, uint64_t key)
{
	struct view *view = user;
	return view_add_chain(view, &view->deformed, tile_from_key(key));
}

enum status view_create(struct drive *drive, struct view **out)
{
	const struct scene *scene = drive->scene;
	struct view *view = mem_calloc(1, sizeof *view);
	if (view == NULL)
		return fail_memory("the view");
	view->drive = drive;
	view->ranges.most = RANGES;
	view->selection = mem_alloc(1, sizeof *view->selection);
	view->now = mem_calloc(1, sizeof *view->now);
	view->ahead = mem_calloc(VIEW_LOOKS, sizeof *view->ahead);
	view_find_room(view);
	enum status status = STATUS_OK;
	if (view->selection == NULL || view->now == NULL || view->ahead == NULL)
		status = fail_memory("the view");
	if (status == STATUS_OK)
		view->reach = view_find_reach(drive);
	if (status == STATUS_OK)
		status = make_render(drive, &view->render);
	if (status == STATUS_OK && scene->view.pixel_error > 0)
		status = view_errors_create(drive, &view->errors);
	if (status == STATUS_OK && drive->was_deformed)
		status = store_each_offset(ground_reader(drive->ground), drive->level, deformed_key, view);
	if (status == STATUS_OK)
		status = view_pressed(view, NULL, NULL);
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
	key_set_finish(&view->deformed);
	key_map_finish(&view->stored);
	key_map_finish(&view->pressed);
	key_set_finish(&view->expected);
	key_set_finish(&view->seen);
	key_cache_finish(&view->ranges);
	view_errors_destroy(view->errors);
	mem_free(view->selection);
	mem_free(view->now);
	mem_free(view->ahead);
	mem_free(view);
}

void view_figures(const struct view *view, struct view_figures *figures)
{
	size_t frames = view->drive->frames;
	*figures = (struct view_figures){
		.triangles = frames > 0 ? view->triangles / (double)frames : 0,
		.overdraw = view->overdraw_frames > 0 ? view->overdraw / (double)view->overdraw_frames : NAN,
		.starved = view->starved,
		.coarsened = view->coarsened,
		.drawn = view->tiles.drawn,
		.deformed = view->tiles.deformed,
	};
}

/* --- a host's --- */

void view_look_from(struct view *view, const struct render_camera *camera)
{
	view->free = camera != NULL;
	if (camera == NULL)
		return;
	view->camera = *camera;
	/* What the scene's camera will see nobody will. */
	for (int i = 0; i < VIEW_LOOKS; i++)
		view->ahead[i].count = 0;
}

void view_reach_at_least(struct view *view, double metres)
{
	view->reach = fmax(view->reach, metres);
}

void view_show_layer(struct view *view, const struct render_layer *layer)
{
	render_show_layer(view->render, layer);
}

enum status view_resize(struct view *view, uint32_t width, uint32_t height)
{
	return render_resize(view->render, width, height);
}

bool view_lacks(const struct view *view)
{
	return view->lacks;
}

uint64_t view_triangles(const struct view *view)
{
	return render_triangles(view->render);
}

void view_read_into(struct view *view, struct gpu_staging *staging)
{
	render_read_into(view->render, staging);
}
