/*
 * What pictures will need: the last one what it did not have, and those at a few times ahead.
 *
 * A look ahead is a selection that pretends nothing is resident: its wanted tiles are the whole
 * picture of that time, of a ground as divided as the objects will have left it. One is made a
 * frame, in rotation, and kept until it is replaced or its time has passed.
 *
 * Invariant: the last picture and the requests are together no more tiles than `room`. So what is
 * loaded ahead of time never pushes out what is on screen or what is needed sooner, and a view that
 * nothing moves in comes to rest.
 */
#include <string.h>

#include "render/view.h"

void view_keep_now(struct view *view)
{
	const struct terrain_selection *selection = view->selection;
	struct view_look *now = view->now;
	now->time = view->world->time;
	memcpy(now->keys, selection->wanted, selection->wanted_count * sizeof *now->keys);
	now->count = selection->wanted_count;
	for (size_t i = 0; i < selection->draw_count; i++)
		now->keys[now->count++] = tile_key(selection->draws[i].tile);
}

/* Where the objects will be by then the ground is divided: the step's requests tell. */
static enum status expect_tracks(struct view *view, double time)
{
	const struct requests *requests = look_ahead_requests(view->world->ahead);
	enum status status = STATUS_OK;
	for (size_t i = 0; i < requests->count && status == STATUS_OK; i++) {
		struct tile tile = tile_from_key(requests->requests[i].key);
		if (tile.level == view->world->level && requests->requests[i].time <= time)
			status = view_add_chain(view, &view->expected, tile);
	}
	return status;
}

enum status view_look_ahead(struct view *view)
{
	const struct scene *scene = view->world->scene;
	if (scene->prefetch <= 0 || scene->view.camera == SCENE_FIXED || view->free)
		return STATUS_OK;
	unsigned turn = view->turn++ % VIEW_LOOKS;
	struct view_look *look = &view->ahead[turn];
	struct render_camera camera;
	bool coarse = view->coarse;
	look->time = view->world->time + scene->prefetch * (turn + 1) / VIEW_LOOKS;
	view_place_camera(view, look->time, &camera);
	enum status status = expect_tracks(view, look->time);
	if (status == STATUS_OK)
		status = view_select(view, &camera, true);
	key_set_clear(&view->expected);
	view->coarse = coarse;
	if (status != STATUS_OK)
		return status;
	look->count = view->selection->wanted_count;
	memcpy(look->keys, view->selection->wanted, look->count * sizeof *look->keys);
	return STATUS_OK;
}

/* Soonest first; those whose time has passed are left out. */
static size_t order_ahead(const struct view *view, const struct view_look *order[VIEW_LOOKS])
{
	size_t count = 0;
	for (int i = 0; i < VIEW_LOOKS; i++) {
		const struct view_look *look = &view->ahead[i];
		if (look->time <= view->world->time)
			continue;
		size_t at = count++;
		for (; at > 0 && look->time < order[at - 1]->time; at--)
			order[at] = order[at - 1];
		order[at] = look;
	}
	return count;
}

/* The look's tiles that are not resident, as long as there is room for them. */
static enum status add_look(struct view *view, const struct view_look *look, double time, size_t room,
			    struct requests *requests)
{
	uint32_t slot;
	enum status status = STATUS_OK;
	for (size_t i = 0; i < look->count && view->seen.count < room && status == STATUS_OK; i++) {
		uint64_t key = look->keys[i];
		if (key_set_has(&view->seen, key))
			continue;
		status = key_set_add(&view->seen, key);
		if (status == STATUS_OK && !page_cache_peek(view->world->cache, key, false, &slot))
			status = requests_add(requests, key, time);
	}
	return status;
}

enum status view_requests(struct view *view, struct requests *requests)
{
	const struct view_look *order[VIEW_LOOKS];
	size_t count = order_ahead(view, order);
	key_set_clear(&view->seen);
	enum status status = add_look(view, view->now, view->world->time, SIZE_MAX, requests);
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		status = add_look(view, order[i], order[i]->time, view->room, requests);
	return status;
}
