/*
 * What pictures will need: tiles that the last picture did not have, and tiles of pictures at a few times ahead. If only some steps
 * have pictures, these are the times of the next ones.
 *
 * A look ahead is a selection as if no tile were resident. So its wanted tiles are the whole picture of that time. The ground is
 * as finely divided as the objects will have left it. Each frame or step makes one look, in turn. It is kept until it is replaced, or its
 * time has passed.
 *
 * Invariant: the tiles of the last picture and of the requests are together no more than `room`. So tiles that are loaded ahead never
 * push out tiles that are on screen or needed sooner. If nothing moves, the view stops loading.
 */
#include <math.h>
#include <string.h>

#include "render/view.h"

void render_view_keep_now(struct view *view)
{
	const struct render_selection *selection = view->selection;
	struct view_look *now = view->now;
	now->time = world_time(view->world);
	memcpy(now->keys, selection->wanted, selection->wanted_count * sizeof *now->keys);
	now->count = selection->wanted_count;
	for (size_t i = 0; i < selection->draw_count; i++)
		now->keys[now->count++] = tile_key(selection->draws[i].tile);
}

/* Adds the tiles where objects will be by then. The step's requests name them. */
static enum status expect_tracks(struct view *view, double time)
{
	const struct requests *requests = resident_look_ahead_requests(world_look_ahead(view->world));
	for (size_t i = 0; i < requests->count; i++) {
		struct tile tile = tile_from_key(requests->requests[i].key);
		if (tile.level == world_resident(view->world)->level && requests->requests[i].time <= time)
			TRY(render_view_add_chain(view, &view->expected, tile));
	}
	return STATUS_OK;
}

/* Returns the time of the n-th picture from now, n from 0, in simulated seconds. INFINITY: the drive ends before. */
static double picture_time(const struct world *world, int64_t n)
{
	int64_t every = world_scene(world)->view.images;
	if (every == 0)
		return INFINITY;
	int64_t step = (world_steps_done(world) / every + 1 + n) * every;
	return step <= world_step_count(world) ? world_step_time(world_scene(world), step) : INFINITY;
}

/* Returns the time of the picture that turn 0 to VIEW_LOOKS - 1 looks at; INFINITY: there is none to look at. More pictures
 * within `prefetch` seconds than there are turns share them. Otherwise each of the next ones has its turn, as far ahead as
 * bodies load ahead. */
static double choose_picture(const struct world *world, unsigned turn)
{
	const struct scene *scene = world_scene(world);
	if (scene->view.images == 0)
		return INFINITY;
	double steps = fmin(floor((world_time(world) + world_facts(world)->limits.prefetch) / scene->time_step + 1e-9), (double)world_step_count(world));
	int64_t within = (int64_t)steps / scene->view.images - world_steps_done(world) / scene->view.images;
	if (within > VIEW_LOOKS)
		return picture_time(world, within * (turn + 1) / VIEW_LOOKS - 1);
	double time = picture_time(world, turn);
	return time <= world_time(world) + resident_look_ahead_reach(world_look_ahead(world), world_time(world)) ? time : INFINITY;
}

/* Returns the look that was made at this time, or NULL. */
static struct view_look *find_look(struct view *view, double time)
{
	for (int i = 0; i < VIEW_LOOKS; i++)
		if (view->ahead[i].time == time)
			return &view->ahead[i];
	return NULL;
}

/* Returns the look whose time is the earliest: it has passed, or is the first to pass. */
static struct view_look *earliest_look(struct view *view)
{
	struct view_look *earliest = &view->ahead[0];
	for (int i = 1; i < VIEW_LOOKS; i++)
		if (view->ahead[i].time < earliest->time)
			earliest = &view->ahead[i];
	return earliest;
}

/* Chooses the time to look at now, and the look that is made anew for it. Returns false if there is nothing to look at. A picture
 * is looked at once, and again whenever half of the time until it has passed, since the bodies' ways are known better then. It is also
 * looked at again when ranges arrive that the look lacked. */
static bool choose_time(struct view *view, struct view_look **look, double *time)
{
	const struct world *world = view->world;
	for (int i = 0; i < VIEW_LOOKS; i++) {
		unsigned turn = view->turn++ % VIEW_LOOKS;
		*look = &view->ahead[turn];
		*time = world_time(world) + world_facts(world)->limits.prefetch * (turn + 1) / VIEW_LOOKS;
		if (!view->at_steps)
			return true;
		*time = choose_picture(world, turn);
		if (isinf(*time))
			continue;
		*look = find_look(view, *time);
		bool come = *look != NULL && (*look)->guessed && (*look)->done != resident_look_ahead_ranges_done(world_look_ahead(world));
		if (*look != NULL && !come && *time - world_time(world) > (*time - (*look)->made) / 2)
			continue;
		if (*look == NULL)
			*look = earliest_look(view);
		return true;
	}
	return false;
}

enum status render_view_look(struct view *view, const struct render_camera *camera, double time, struct view_look *look)
{
	bool coarse = view->coarse;
	uint64_t done = resident_look_ahead_ranges_done(world_look_ahead(view->world));
	look->time = time;
	look->made = world_time(view->world);
	enum status status;
	TRY_OR(done, expect_tracks(view, time));
	TRY_OR(done, render_view_select(view, camera, true));
	look->count = view->selection->wanted_count;
	memcpy(look->keys, view->selection->wanted, look->count * sizeof *look->keys);
	TRY_OR(done, render_view_look_imagery(view, camera, look));
done:
	look->guessed = view->guessed;
	look->done = done;
	key_set_clear(&view->expected);
	view->coarse = coarse;
	return status;
}

enum status render_view_look_ahead(struct view *view)
{
	const struct scene *scene = world_scene(view->world);
	if (world_facts(view->world)->limits.prefetch > 0 && view->camera_count > 0)
		TRY(render_view_look_camera(view));
	if (world_facts(view->world)->limits.prefetch <= 0 || view->free || (scene->view.aim.kind == SCENE_FIXED && !view->at_steps))
		return STATUS_OK;
	struct view_look *look;
	struct render_camera camera;
	double time;
	if (!choose_time(view, &look, &time))
		return STATUS_OK;
	view->exact = !resident_look_ahead_brings_ranges(world_look_ahead(view->world));
	render_view_place_camera(view, time, &camera);
	enum status status = render_view_look(view, &camera, time, look);
	view->exact = true;
	return status;
}

size_t render_view_order_ahead(const struct view *view, const struct view_look *order[VIEW_LOOKS + SCENE_CAMERAS])
{
	size_t count = 0;
	for (size_t i = 0; i < VIEW_LOOKS + view->camera_count; i++) {
		const struct view_look *look = i < VIEW_LOOKS ? &view->ahead[i] : &view->cameras[i - VIEW_LOOKS].ahead;
		if (look->time <= world_time(view->world))
			continue;
		size_t at = count++;
		for (; at > 0 && look->time < order[at - 1]->time; at--)
			order[at] = order[at - 1];
		order[at] = look;
	}
	return count;
}

/* Requests the look's tiles that are not resident, as long as there is room for them. */
static enum status add_look(struct view *view, const struct view_look *look, double time, size_t room,
			    struct requests *requests)
{
	uint32_t slot;
	for (size_t i = 0; i < look->count && view->seen.count < room; i++) {
		uint64_t key = look->keys[i];
		if (key_set_has(&view->seen, key))
			continue;
		TRY(key_set_add(&view->seen, key));
		if (!page_cache_peek(world_resident(view->world)->cache, key, false, &slot))
			TRY(resident_requests_add(requests, key, time));
	}
	return STATUS_OK;
}

enum status render_view_requests(struct view *view, struct requests *requests)
{
	const struct view_look *order[VIEW_LOOKS + SCENE_CAMERAS];
	size_t count = render_view_order_ahead(view, order);
	key_set_clear(&view->seen);
	TRY(add_look(view, view->now, world_time(view->world), SIZE_MAX, requests));
	for (size_t i = 0; i < count; i++)
		TRY(add_look(view, order[i], order[i]->time, view->room, requests));
	return STATUS_OK;
}
