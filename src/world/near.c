/*
 * Which bodies are near a place: those that may be over the same ground as another one, and those below which no soil is laid.
 *
 * The table is made anew when bodies may have moved. A body is in all cells of a grid on which it may lie until the table is made anew. Bodies whose
 * places a probe gives are in a list beside it.
 */
#include <math.h>
#include <stdlib.h>

#include "world/internal.h"

#define FEW 16          /* bodies: so few need no grid */
#define CELLS_MOST 64   /* of a body; one that needs more is looked at each time */
#define CELL_LEAST 32   /* posts */

/* A body that is in a cell. */
struct near_cell {
	uint64_t key;
	size_t entry;
};

static enum status need_entries(struct near_table *near, size_t count)
{
	if (count <= near->room)
		return STATUS_OK;
	TRY(mem_resize(&near->entries, 2 * count, sizeof *near->entries, "bodies near each other"));
	TRY(mem_resize(&near->found, 2 * count, sizeof *near->found, "bodies near each other"));
	TRY(mem_resize(&near->kept, 2 * count, sizeof *near->kept, "bodies near each other"));
	TRY(mem_resize(&near->rests, 2 * count, sizeof *near->rests, "bodies near each other"));
	near->room = 2 * count;
	return STATUS_OK;
}

void world_near_free(struct near_table *near)
{
	mem_free_all(near->entries, near->found, near->kept, near->rests, near->beside, near->cells);
	*near = (struct near_table){.stale = true};
}

/* --- the bodies --- */

static struct post_rect shadow_of(const struct world *world, const struct deform_rest *rest)
{
	return soil_shadow(rest->shape, &rest->pose, &rest->pose, world->resident.spacing);
}

/* Returns where a body on a path is now. */
static struct deform_rest rest_of(const struct body *body)
{
	return (struct deform_rest){&body->object->shape, body->last, body->loaded_body, true};
}

static void add_path(const struct world *world, const struct body *body, struct near_entry *entry)
{
	entry->rest = rest_of(body);
	if (body->has_last && !body->elsewhere)
		entry->rect = shadow_of(world, &entry->rest);
}

/* Adds where bodies on paths come to in this step. */
static void add_events(const struct world *world, struct near_table *near)
{
	for (size_t i = 0; i < world->events.count; i++) {
		const struct event *event = &world->events.list[i];
		struct near_entry *entry = &near->entries[event->body];
		if (event->contact)
			entry->rect = post_rect_joined(entry->rect, soil_shadow(entry->rest.shape, &event->pose, &event->pose, world->resident.spacing));
	}
}

/* Adds a body of a host, at the end of this step. */
static enum status add_hosted(const struct world *world, const struct body *body, struct near_entry *entry)
{
	const struct scene_object *object = body->object;
	const struct body_hosted *host = &body->host;
	entry->rest.shape = &object->shape;
	TRY(world_attitude(&object->shape, object->name, host->has_next ? &host->next.pose : &host->now.pose, &entry->rest.pose));
	entry->rect = shadow_of(world, &entry->rest);
	return STATUS_OK;
}

/* Adds all bodies. Those of the scene have the entries of their numbers. An added one that is nowhere has none. Bodies of a host that are among the
 * first `count` of `numbers`, in rising order, have an empty place: it is given later. */
static enum status add_bodies(struct world *world, struct near_table *near, size_t count, const int32_t *numbers)
{
	size_t given = 0;
	for (size_t i = 0; i < world->body_count; i++) {
		const struct body *body = world->bodies[i];
		const bool hosted = world_is_set_down(body) && !body->elsewhere;
		if (i >= world->scene->object_count && !hosted)
			continue;
		struct near_entry *entry = &near->entries[near->count++];
		*entry = (struct near_entry){.body = i, .rect = {0, 0, 0, 0}};
		while (given < count && (size_t)numbers[given] < i)
			given++;
		if (body->kind == BODY_PATH)
			add_path(world, body, entry);
		else if (hosted && given < count && (size_t)numbers[given] == i)
			entry->rest.shape = &body->object->shape;
		else if (hosted)
			TRY(add_hosted(world, body, entry));
	}
	add_events(world, near);
	return STATUS_OK;
}

/* --- the grid --- */

static int by_key(const void *a, const void *b)
{
	const struct near_cell *p = a, *q = b;
	if (p->key != q->key)
		return p->key < q->key ? -1 : 1;
	return p->entry < q->entry ? -1 : p->entry > q->entry;
}

static struct post_rect cells_of(const struct near_table *near, struct post_rect rect)
{
	const int64_t side = near->side;
	const int64_t shift = (int64_t)1 << 30; /* a body may be beyond the world */
	return (struct post_rect){(rect.x0 + shift * side) / side, (rect.y0 + shift * side) / side, (rect.x1 - 1 + shift * side) / side + 1,
				  (rect.y1 - 1 + shift * side) / side + 1};
}

static uint64_t key_of(int64_t x, int64_t y)
{
	return (uint64_t)y << 32 | (uint64_t)x;
}

static enum status make_grid(struct near_table *near)
{
	int64_t widest = CELL_LEAST;
	size_t needed = 0;
	for (size_t i = 0; i < near->count; i++) {
		const struct post_rect shadow = near->entries[i].rect;
		const int64_t wide = shadow.x1 - shadow.x0, high = shadow.y1 - shadow.y0;
		near->entries[i].everywhere = false;
		if (post_rect_empty(shadow))
			continue;
		widest = wide > widest && wide < 1024 ? wide : widest;
		widest = high > widest && high < 1024 ? high : widest;
	}
	near->side = widest;
	near->cell_count = near->everywhere = 0;
	for (size_t i = 0; i < near->count; i++) {
		const struct post_rect cells = cells_of(near, near->entries[i].rect);
		if (!post_rect_empty(near->entries[i].rect))
			needed += cells.x1 - cells.x0 > CELLS_MOST || cells.y1 - cells.y0 > CELLS_MOST ? 0 : (size_t)((cells.x1 - cells.x0) * (cells.y1 - cells.y0));
	}
	TRY(mem_grow(&near->cells, &near->cell_room, needed, sizeof *near->cells, "bodies near each other"));
	for (size_t i = 0; i < near->count; i++) {
		struct near_entry *entry = &near->entries[i];
		if (post_rect_empty(entry->rect))
			continue;
		const struct post_rect cells = cells_of(near, entry->rect);
		entry->everywhere = cells.x1 - cells.x0 > CELLS_MOST || cells.y1 - cells.y0 > CELLS_MOST;
		near->everywhere += entry->everywhere;
		for (int64_t y = cells.y0; y < cells.y1 && !entry->everywhere; y++)
			for (int64_t x = cells.x0; x < cells.x1; x++)
				near->cells[near->cell_count++] = (struct near_cell){key_of(x, y), i};
	}
	if (near->cell_count > 1)
		qsort(near->cells, near->cell_count, sizeof *near->cells, by_key);
	return STATUS_OK;
}

/* Lists the bodies where they are. count, numbers: as of add_bodies. */
static enum status list(struct world *world, size_t count, const int32_t *numbers)
{
	struct near_table *near = &world->near;
	near->stale = true;
	TRY(need_entries(near, world->body_count + 1));
	near->count = near->moved = 0;
	return add_bodies(world, near, count, numbers);
}

static enum status end_list(struct near_table *near)
{
	enum status status;
	TRY_OR(done, near->count > FEW ? make_grid(near) : STATUS_OK);
done:
	near->stale = status != STATUS_OK;
	return status;
}

enum status world_near_make(struct world *world)
{
	TRY(list(world, 0, NULL));
	return end_list(&world->near);
}

static int by_body(const void *a, const void *b)
{
	const struct near_entry *p = a, *q = b;
	return p->body < q->body ? -1 : p->body > q->body;
}

/* Returns the entry of a body; NULL: it has none. */
static struct near_entry *entry_of(struct near_table *near, size_t body)
{
	return bsearch(&(struct near_entry){.body = body}, near->entries, near->count, sizeof *near->entries, by_body);
}

static void move(const struct world *world, struct near_entry *entry, const struct soil_pose *pose)
{
	entry->rest.pose = *pose;
	entry->rect = shadow_of(world, &entry->rest);
}

enum status world_near_begin(struct world *world, size_t count, const int32_t *numbers, const struct furrow_state *states)
{
	struct near_table *near = &world->near;
	/* Of one body alone the place does not matter to itself. */
	const bool most = count > 1 && 4 * count >= world->body_count;
	enum status status;
	TRY_OR(done, most ? list(world, count, numbers) : near->stale ? world_near_make(world) : STATUS_OK);
	for (size_t i = 0; i < count && count > 1; i++) {
		struct soil_pose pose;
		struct near_entry *entry = entry_of(near, (size_t)numbers[i]);
		if (entry == NULL || !world_is_set_down(world->bodies[numbers[i]]))
			continue;
		TRY_OR(done, world_state_check(entry->rest.shape, "a body", &states[i], &pose)); /* it was checked before */
		if (most) {
			move(world, entry, &pose);
			continue;
		}
		near->kept[near->moved++] = (struct near_kept){(size_t)(entry - near->entries), *entry};
		move(world, entry, &pose);
	}
	if (most)
		TRY_OR(done, end_list(near));
done:
	near->stale |= most;
	return status;
}

void world_near_end(struct world *world)
{
	struct near_table *near = &world->near;
	for (; near->moved > 0; near->moved--)
		near->entries[near->kept[near->moved - 1].at] = near->kept[near->moved - 1].entry;
}

/* --- finding --- */

/* Notes a body if it is over these posts. */
static void look(struct world *world, size_t at, struct post_rect rect)
{
	struct near_table *near = &world->near;
	struct near_entry *entry = &near->entries[at];
	if (entry->turn == near->turn || post_rect_empty(post_rect_intersect(entry->rect, rect)))
		return;
	entry->turn = near->turn;
	const struct body *body = world->bodies[entry->body];
	if (body->kind == BODY_PATH) { /* its path has gone on since the table was made */
		entry->rest = rest_of(body);
		if (!body->has_last || post_rect_empty(post_rect_intersect(shadow_of(world, &entry->rest), rect)))
			return;
	}
	near->found[near->found_count++] = *entry;
}

static size_t first_of(const struct near_table *near, uint64_t key)
{
	size_t low = 0, high = near->cell_count;
	while (low < high) {
		const size_t middle = low + (high - low) / 2;
		if (near->cells[middle].key < key)
			low = middle + 1;
		else
			high = middle;
	}
	return low;
}

void world_near_find(struct world *world, struct post_rect rect)
{
	struct near_table *near = &world->near;
	near->found_count = 0;
	near->turn++;
	if (post_rect_empty(rect) || near->count < 2)
		return;
	const struct post_rect cells = near->count > FEW ? cells_of(near, rect) : (struct post_rect){0, 0, 0, 0};
	const bool all = near->count <= FEW || (cells.x1 - cells.x0) * (cells.y1 - cells.y0) > (int64_t)near->count;
	for (size_t i = 0; i < near->count && (all || near->everywhere > 0); i++)
		if (all || near->entries[i].everywhere)
			look(world, i, rect);
	for (size_t i = 0; i < near->moved && !all; i++)
		look(world, near->kept[i].at, rect);
	for (int64_t y = cells.y0; y < cells.y1 && !all; y++)
		for (int64_t x = cells.x0; x < cells.x1; x++)
			for (size_t i = first_of(near, key_of(x, y)); i < near->cell_count && near->cells[i].key == key_of(x, y); i++)
				look(world, near->cells[i].entry, rect);
	if (near->found_count > 1)
		qsort(near->found, near->found_count, sizeof *near->found, by_body);
}

/* --- beside a contact --- */

#define STILL 1.0 /* s: under a kinematic model a body that moves less than a post in this time is at rest */

bool world_is_at_rest(const struct body *body, double time)
{
	if (body->kind != BODY_PATH)
		return !body->host.moving || time - body->host.touched > STILL;
	const int64_t samples = motion_track_samples(body->track);
	int64_t next = body->next < samples ? body->next : samples;
	while (next > 0 && motion_track_sample_time(body->track, next - 1) > time)
		next--;
	if (next == 0)
		return false;
	const double last = motion_track_sample_time(body->track, next - 1);
	return next == samples ? last < time : motion_track_sample_time(body->track, next) - last > STILL;
}

/* Tells whether a path has a stretch on which its body may be at rest: it goes less than a post in STILL. It may say so of one a little faster, too. */
static bool pauses(const struct scene_path *path, double spacing)
{
	if (!path->timed)
		return path->speed > 0 && path->speed * STILL < spacing;
	double way = 0;
	for (size_t i = 1, first = 0; i < path->count && !path->degrees; i++) {
		const struct scene_waypoint *from = &path->points[i - 1], *to = &path->points[i];
		const double step = hypot(to->x - from->x, to->y - from->y), time = to->t - from->t;
		if (time > STILL / 4 && step * STILL < spacing * time)
			return true;
		for (way += step; first < i && way >= spacing; first++)
			way -= hypot(path->points[first + 1].x - path->points[first].x, path->points[first + 1].y - path->points[first].y);
		if (to->t - path->points[first].t > STILL / 2)
			return true;
	}
	return path->degrees && path->count > 1;
}

bool world_has_rests(const struct world *world)
{
	const struct scene *scene = world->scene;
	const double end = (double)world_intervals_by(world, scene->end_time) * scene->interval;
	bool has = scene_moves_bodies(scene) || world->params.drops;
	for (size_t i = 0; i < scene->object_count && !has; i++) {
		const struct track *track = i < world->body_count ? world->bodies[i]->track : NULL;
		const int64_t samples = track != NULL ? motion_track_samples(track) : 0;
		has = samples > 0 && ((samples < INT64_MAX && motion_track_sample_time(track, samples - 1) < fmax(end, scene->end_time)) || pauses(&scene->objects[i].path, world->resident.spacing));
	}
	return has && deform_conserves(scene->model) && !deform_tells_forces(scene->model);
}

static enum status add_beside(struct world *world, const struct body *body, double time, struct post_rect rect)
{
	struct near_table *near = &world->near;
	const struct deform_rest rest = rest_of(body);
	if (!body->has_last || body->elsewhere || body->host.removed || !world_is_at_rest(body, time) || post_rect_empty(post_rect_intersect(shadow_of(world, &rest), rect)))
		return STATUS_OK;
	TRY(mem_grow(&near->beside, &near->beside_room, near->beside_count + 1, sizeof *near->beside, "bodies near each other"));
	near->beside[near->beside_count++] = rest;
	return STATUS_OK;
}

enum status world_near_beside(struct world *world, const struct event *event, struct post_rect rect, struct deform_contact *contact)
{
	const size_t own = event->body;
	struct near_table *near = &world->near;
	near->beside_count = 0;
	if (world->body_count == 0 || (world->body_count == 1 && own == 0))
		return STATUS_OK;
	/* The table has bodies of a host where this step moves them to. It has none that a window drops. */
	if (scene_moves_bodies(world->scene) || own == WORLD_DROPPED) {
		for (size_t i = 0; i < world->body_count; i++)
			if (i != own && world->bodies[i] != NULL)
				TRY(add_beside(world, world->bodies[i], event->time, rect));
	} else {
		TRY(near->stale ? world_near_make(world) : STATUS_OK);
		world_near_find(world, rect);
		for (size_t i = 0; i < near->found_count; i++)
			if (near->found[i].body != own)
				TRY(add_beside(world, world->bodies[near->found[i].body], event->time, rect));
	}
	contact->rests = near->beside;
	contact->rest_count = near->beside_count;
	return STATUS_OK;
}
