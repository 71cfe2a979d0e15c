/*
 * Draws the frames of a drive. The terrain folder selects tiles for the camera, the cache tells which are resident, and render
 * draws them.
 */
#include <math.h>
#include <time.h>

#include "render/view.h"

#define RANGES 16384 /* tiles that one selection asks about, and some more */

/* --- frames --- */

/* Requests all tiles that the selection wants, and no other, while a picture waits. */
static void ask(struct view *view)
{
	page_cache_want(world_resident(view->world)->cache, view->selection->wanted, view->selection->wanted_count);
}

/* Waits for the coarsest tile that is missing. If it cannot be read, this says why; a prefetch would not. */
static enum status load_first(struct view *view, const struct render_view *whole)
{
	uint32_t slot;
	uint64_t key = view->selection->wanted[0];
	TRY(page_cache_pin(world_resident(view->world)->cache, key, &slot));
	page_cache_unpin(world_resident(view->world)->cache, key);
	return render_view_select_seen(view, whole, false);
}

/* Waits for all tiles of a picture that is kept, however long. They fit into the slots, so the wait ends. If nothing arrives, or
 * there is no loader, it pins a tile. That says why, if the tile cannot be read. */
static enum status load_wanted(struct view *view, const struct render_view *whole)
{
	const struct world *world = view->world;
	const volatile sig_atomic_t *stop = world_params(world)->stop;
	const struct timespec nap = {0, 500000};
	double progressed = clock_seconds();
	size_t least = SIZE_MAX;
	while (view->selection->wanted_count > 0) {
		double now = clock_seconds();
		if (view->selection->wanted_count < least) {
			least = view->selection->wanted_count;
			progressed = now;
		}
		if (stop != NULL && *stop)
			return load_first(view, whole);
		/* Coarser tiles that are drawn meanwhile must not take slots from the tiles that they replace. */
		render_view_mark_used(view, false);
		ask(view);
		if (world_facts(world)->limits.loaders == 0 || now - progressed > 1) {
			TRY(load_first(view, whole));
			continue;
		}
		nanosleep(&nap, NULL);
		TRY(page_cache_poll(world_resident(world)->cache));
		TRY(render_view_select_seen(view, whole, false));
	}
	return STATUS_OK;
}

/* Returns how long the world's thread has waited for the store so far, ms. */
static double waited(const struct world *world)
{
	struct stalls stalls, ranges;
	world_stalls(world, &stalls);
	world_range_waits(world, &ranges);
	return stalls.ms + ranges.ms;
}

static enum status wait_for_wanted(struct view *view, const struct render_view *whole)
{
	if (view->selection->wanted_count == 0)
		return STATUS_OK;
	double began = clock_seconds(), before = waited(view->world);
	enum status status = load_wanted(view, whole);
	view->naps++;
	view->nap_ms += fmax((clock_seconds() - began) * 1e3 - (waited(view->world) - before), 0);
	return status;
}

static bool has_ground(const struct view *view)
{
	uint32_t slot;
	struct tile coarsest = {extent_coarsest(&world_resident(view->world)->meta->extent), 0, 0};
	return view->selection->wanted_count == 0 ||
	       page_cache_peek(world_resident(view->world)->cache, tile_key(coarsest), false, &slot);
}

static enum status select_and_load(struct view *view, const struct render_view *whole, bool complete)
{
	TRY(render_view_select_seen(view, whole, false));
	if (complete)
		TRY(wait_for_wanted(view, whole));
	/* If the step pinned every slot, not even the coarsest tile is resident. A picture needs it. */
	return has_ground(view) ? STATUS_OK : load_first(view, whole);
}

static enum status find_tiles(struct view *view, const struct render_view *whole, bool complete)
{
	view->exact = complete || !resident_look_ahead_brings_ranges(world_look_ahead(view->world));
	view->complete = complete;
	enum status status = select_and_load(view, whole, complete);
	view->complete = false;
	view->exact = true;
	TRY(status);
	render_view_mark_used(view, true);
	return STATUS_OK;
}

enum status render_view_find_tiles(struct view *view, const struct render_camera *camera, bool complete)
{
	struct render_view whole;
	render_view(view->render, camera, &whole);
	return find_tiles(view, &whole, complete);
}

enum status render_view_shade(struct view *view, const struct render_camera *camera, bool complete)
{
	render_view_move_sun(view);
	render_shade_begin(view->render);
	if (!(world_scene(view->world)->view.effects >> EFFECT_TERRAIN_SHADOW & 1))
		return STATUS_OK;
	view->exact = complete || !resident_look_ahead_brings_ranges(world_look_ahead(view->world));
	const double ground = render_view_ground_at(view, camera->eye[0], camera->eye[1], isnan(world_resident(view->world)->meta->low) ? 0 : world_resident(view->world)->meta->low);
	view->exact = true;
	for (int map = 0; map < RENDER_SHADE_MAPS; map++) {
		struct render_view whole;
		if (!render_shade_view(view->render, camera, ground, map, &whole))
			continue;
		TRY(find_tiles(view, &whole, complete));
		TRY(render_shade_draw(view->render, camera, map, &whole, view->selection));
		render_view_count_tiles(view);
	}
	return STATUS_OK;
}

static enum status draw(struct view *view, bool complete)
{
	struct render_camera camera;
	TRY(render_view_update(view));
	const struct plane_marks marks = world_marks_at(view->world, world_time(view->world));
	render_set_marks(view->render, &marks);
	render_view_place_camera(view, world_time(view->world), &camera);
	render_set_truth(view->render, scene_camera_truth(world_scene(view->world), NULL));
	TRY(render_view_shade(view, &camera, complete));
	TRY(render_view_find_tiles(view, &camera, complete));
	if (!view->at_steps) /* with at_steps no picture stays on a screen */
		render_view_keep_now(view);
	TRY(render_view_set_objects(view));
	if (view->imagery != NULL)
		view->imagery->complete = complete;
	return render_frame(view->render, &camera, view->selection);
}

enum status render_view_warm(struct view *view)
{
	const struct world *world = view->world;
	bool deformed = world_planes(world) != 0;
	const bool divided = world_resident(world)->level < 0, smooth = render_view_smooths(world);
	enum status status;
	TRY_OR(done, render_warm(view->render, deformed, divided, smooth));
	TRY_OR(done, render_draw_unseen(view->render, deformed, divided, smooth));
	if (!view->at_steps)
		TRY_OR(done, draw(view, !view->watched)); /* a watched picture may be drawn before its tiles are there */
	for (int i = 0; i < VIEW_LOOKS; i++)
		TRY_OR(done, render_view_look_ahead(view));
	TRY_OR(done, render_view_want_imagery(view));
done:
	render_view_expect_contacts(view);
	render_view_ask_ranges(view);
	/* This picture is not one of the drive's. */
	double overdraw;
	gpu_finish(world_resident(world)->gpu);
	render_take_overdraw(view->render, &overdraw);
	return status;
}

static void take_overdraw(struct view *view)
{
	double overdraw;
	view->overdraw_frames += render_take_overdraw(view->render, &overdraw);
	view->overdraw += overdraw;
}

void render_view_settle(struct view *view)
{
	gpu_finish(world_resident(view->world)->gpu);
	take_overdraw(view);
}

enum status render_view_between(struct view *view, struct pictures *pictures)
{
	TRY(render_view_update(view));
	enum status status;
	TRY_OR(done, render_pictures_poll(pictures));
	TRY_OR(done, render_view_look_ahead(view));
	TRY_OR(done, render_view_want_imagery(view));
done:
	render_view_expect_contacts(view);
	render_view_ask_ranges(view);
	return status;
}

void render_view_count_tiles(struct view *view)
{
	struct render_tiles tiles;
	render_tiles(view->render, &tiles);
	view->tiles.drawn += tiles.drawn;
	view->tiles.deformed += tiles.deformed;
	view->tiles.objects += tiles.objects;
	view->tiles.shadowed += tiles.shadowed;
}

void render_view_count(struct view *view)
{
	render_view_count_tiles(view);
	view->triangles += (double)render_triangles(view->render);
	view->coarsened += view->coarse;
	view->frames++;
}

enum status render_view_frame(struct view *view, struct pictures *pictures, bool image)
{
	TRY(render_pictures_poll(pictures));
	TRY(draw(view, image));
	render_view_count(view);
	take_overdraw(view);
	view->lacks = view->selection->wanted_count > 0 || view->guessed || (view->imagery != NULL && view->imagery->lacking.count > 0);
	view->starved += view->coarse || view->lacks;
	enum status status = render_view_look_ahead(view);
	if (status == STATUS_OK)
		status = render_view_want_imagery(view);
	render_view_expect_contacts(view);
	render_view_ask_ranges(view);
	TRY(status);
	return image ? render_pictures_begin(pictures, view->render, world_steps_done(view->world)) : STATUS_OK;
}

/* --- life --- */

void render_view_params(const struct world *world, struct render_params *params)
{
	const struct scene *scene = world_scene(world);
	*params = (struct render_params){
		.extent = &world_resident(world)->meta->extent,
		.width = scene->view.width,
		.height = scene->view.height,
		.effects = scene->view.effects | (scene_draws_light(scene) ? EFFECT_BIT(EFFECT_LIGHT) : 0),
		.disturbance = scene->disturbance && scene->heals <= 0,
		.heals = scene->heals > 0,
		.vegetation = scene->vegetation.present ? &scene->vegetation : NULL,
		.cover_by_class = scene_covers_by_class(scene),
		.imagery_budget = scene->view.imagery_budget,
		.loaders = world_facts(world)->limits.loaders,
		.pixel_error = scene->view.pixel_error,
		.samples = scene->view.samples,
		.grains = world_grains_most(world),
		.heaps = world_carries(world),
		.objects = scene->objects,
		.object_count = scene->object_count,
		.light = &world_facts(world)->light,
		.measures = scene_measures(scene),
		.classes = scene_draws_classes(scene),
		.soils = scene_draws_classes(scene) || scene_draws_one_soil(scene) ? scene : NULL,
		.one_soil = scene_draws_one_soil(scene),
	};
	const bool own = scene->view.images > 0 || scene->hosted || scene->camera_count == 0;
	bool truths[2] = {own && !scene_camera_truth(scene, NULL), own && scene_camera_truth(scene, NULL)};
	for (size_t i = 0; i < scene->camera_count; i++)
		truths[scene_camera_truth(scene, &scene->cameras[i])] = true;
	params->truth = truths[1];
	params->only_truth = !truths[0];
}

/* Pages may be made after the view. */
static enum status show(void *user, uint32_t slot, bool planes)
{
	const struct world *world = user;
	return resident_pages_show(world_resident(world)->pages, slot, planes);
}

static enum status make_render(struct view *view, bool watched, struct render **out)
{
	struct world *world = view->world;
	struct render_params params;
	render_view_params(world, &params);
	TRY(render_view_list_drawn(view, &params));
	params.gpu = world_resident(world)->gpu;
	params.slots = world_resident(world)->slots;
	params.show = show;
	params.user = world;
	params.reference = resident_ground_reference(world_resident(world)->store);
	params.low = isnan(world_resident(world)->meta->low) ? 0 : world_resident(world)->meta->low;
	params.high = isnan(world_resident(world)->meta->high) ? 0 : world_resident(world)->meta->high;
	params.imagery = view->imagery;
	params.layers = watched;
	params.effects &= watched ? ~EFFECT_BIT(EFFECT_LIGHT) : ~(uint64_t)0; /* layers, such as heights, are drawn without light */
	params.measures = params.measures && !watched;
	if (watched) /* the scene's cameras draw nothing then */
		params.truth = params.only_truth = scene_camera_truth(world_scene(world), NULL);
	return render_create(&params, out);
}

static enum status deformed_key(void *user, uint64_t key)
{
	struct view *view = user;
	return render_view_add_chain(view, &view->deformed, tile_from_key(key));
}

static enum status make(struct view *view)
{
	struct world *world = view->world;
	const struct scene *scene = world_scene(world);
	TRY_MEM(view->selection != NULL && view->now != NULL && view->ahead != NULL && view->missing != NULL, "the view");
	view->reach = render_view_find_reach(world);
	TRY(render_view_make_imagery(view));
	TRY(make_render(view, view->watched, &view->render));
	TRY(render_sun_find(&world_facts(world)->light, world_resident(world)->meta, &view->sun));
	if (!view->watched)
		TRY(render_view_make_cameras(view));
	if (scene->view.pixel_error > 0)
		TRY(render_view_errors_create(world, &view->errors));
	if (world_resident(world)->was_deformed || scene->hosted) /* a host may make its view late */
		TRY(store_each_offset(resident_ground_reader(world_resident(world)->ground), world_resident(world)->level, deformed_key, view));
	return render_view_contact(view, NULL);
}

enum status render_view_create(struct world *world, bool watched, struct view **out)
{
	const struct scene *scene = world_scene(world);
	struct view *view = mem_calloc(1, sizeof *view);
	TRY_MEM(view, "the view");
	view->world = world;
	view->watched = watched;
	view->at_steps = !watched && (scene->view.images > 0 || scene->camera_count > 0);
	view->ranges.most = RANGES;
	view->bounds.extent = &world_resident(world)->meta->extent;
	view->selection = mem_alloc(1, sizeof *view->selection);
	view->now = mem_calloc(1, sizeof *view->now);
	view->missing = mem_calloc(VIEW_MISSING, sizeof *view->missing);
	view->exact = true;
	view->ahead = mem_calloc(VIEW_LOOKS, sizeof *view->ahead);
	render_view_find_room(view);
	resident_ground_forget_offsets(world_resident(world)->ground); /* they may be older than a view that is made late */
	enum status status = make(view);
	if (status != STATUS_OK) {
		render_view_destroy(view);
		return status;
	}
	world_watch(world);
	*out = view;
	return STATUS_OK;
}

void render_view_destroy(struct view *view)
{
	if (view == NULL)
		return;
	for (size_t i = 0; i < view->camera_count; i++)
		mem_free(view->cameras[i].ahead.imagery.keys);
	for (int i = 0; i < VIEW_LOOKS && view->ahead != NULL; i++)
		mem_free(view->ahead[i].imagery.keys);
	render_view_free_cameras(view);
	render_destroy(view->render);
	render_imagery_destroy(view->imagery);
	key_set_finish(&view->deformed);
	resident_bounds_finish(&view->bounds);
	key_set_finish(&view->expected);
	key_set_finish(&view->seen);
	key_cache_finish(&view->ranges);
	render_view_errors_destroy(view->errors);
	mem_free_all(view->drawn, view->added, view->selection, view->now, view->missing, view->ahead, view);
}

void render_view_figures(const struct view *view, struct render_view_figures *figures)
{
	const uint64_t frames = view->frames;
	*figures = (struct render_view_figures){
		.triangles = frames > 0 ? view->triangles / (double)frames : 0,
		.overdraw = view->overdraw_frames > 0 ? view->overdraw / (double)view->overdraw_frames : NAN,
		.frames = frames,
		.starved = view->starved,
		.coarsened = view->coarsened,
		.naps = view->naps,
		.nap_ms = view->nap_ms,
		.tiles = view->tiles,
	};
	if (view->imagery == NULL)
		return;
	struct page_stats stats;
	page_cache_stats(view->imagery->cache, &stats);
	figures->naps += stats.stalls;
	figures->nap_ms += stats.stall_ms;
}

/* --- a host's --- */

void render_view_look_from(struct view *view, const struct render_camera *camera)
{
	view->free = camera != NULL;
	if (camera == NULL)
		return;
	view->camera = *camera;
	/* Nobody will see the pictures of the scene's camera. */
	for (int i = 0; i < VIEW_LOOKS; i++)
		view->ahead[i].count = 0;
}

void render_view_reach_at_least(struct view *view, double metres)
{
	view->reach = fmax(view->reach, metres);
}

void render_view_show_layer(struct view *view, const struct render_layer *layer)
{
	render_show_layer(view->render, layer);
}

enum status render_view_resize(struct view *view, uint32_t width, uint32_t height)
{
	return render_resize(view->render, width, height);
}

enum status render_view_follow_bodies(struct view *view)
{
	if (view->bodies == world_body_count(view->world) || !world_scene(view->world)->hosted)
		return STATUS_OK;
	/* After a failure all is as before: what draws bodies uses the lists. */
	struct render *render;
	struct scene_object *drawn = view->drawn;
	int32_t *added = view->added;
	const size_t added_count = view->added_count, bodies = view->bodies;
	view->drawn = NULL;
	view->added = NULL;
	enum status status = make_render(view, view->watched, &render);
	if (status != STATUS_OK) {
		mem_free_all(view->drawn, view->added);
		view->drawn = drawn;
		view->added = added;
		view->added_count = added_count;
		view->bodies = bodies;
		return status;
	}
	render_destroy(view->render);
	view->render = render;
	mem_free_all(drawn, added);
	return STATUS_OK;
}

bool render_view_lacks(const struct view *view)
{
	return view->lacks;
}

uint64_t render_view_triangles(const struct view *view)
{
	return render_triangles(view->render);
}

void render_view_read_into(struct view *view, struct gpu_staging *staging)
{
	render_read_into(view->render, SCENE_IMAGE_COLOUR, staging);
}

enum status render_view_picture(struct view *view, uint8_t *pixels, float *depth)
{
	TRY(draw(view, true));
	take_overdraw(view);
	view->frames++;
	return render_read(view->render, pixels, depth);
}

/* --- what happened in the world --- */

enum status render_view_update(struct view *view)
{
	const struct world_happened *happened = world_happened(view->world);
	size_t touch = SIZE_MAX;
	if (happened->reach > 0)
		render_view_reach_at_least(view, happened->reach);
	for (size_t i = 0; i < happened->change_count; i++) {
		const struct world_change *change = &happened->changes[i];
		if (change->touch != touch) {
			touch = change->touch;
			TRY(render_view_contact(view, touch != SIZE_MAX ? &happened->touches[touch] : NULL));
		}
		TRY(render_view_deformed(view, change->tile));
	}
	if (touch != SIZE_MAX)
		TRY(render_view_contact(view, NULL));
	world_happened_clear(view->world);
	return STATUS_OK;
}

enum status render_view_prefetch(struct view *view)
{
	struct requests *asked = world_prefetch(view->world);
	resident_requests_clear(asked);
	TRY(render_view_update(view));
	return render_view_requests(view, asked);
}
