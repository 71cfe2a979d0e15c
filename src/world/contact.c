/* The deformation at one path sample: pins the tiles that its windows touch, computes, scatters, and marks them dirty. */
#include <math.h>
#include <string.h>

#include "world/internal.h"

/* Pins the tiles of held->keys. newest: they are to be read as this step has them, so this rank must have them. */
static enum status pin(struct world *world, struct held_tiles *held, bool newest)
{
	uint32_t slots[WORLD_TILES_MOST];
	for (size_t i = 0; i < held->count && world->ranks != NULL && newest; i++)
		if (!world->ranks->has(world->ranks->user, held->keys[i])) {
			held->count = 0;
			return fail_with(STATUS_FAILED, "ranks: a step reads ground of another rank; report this");
		}
	enum status status = page_cache_pin_all(world->resident.cache, held->keys, held->count, slots);
	if (status != STATUS_OK) {
		held->count = 0;
		return status;
	}
	for (size_t i = 0; i < held->count; i++) {
		held->tiles[i].slot = slots[i];
		TRY_OR(failed, world_see(world, &held->tiles[i]));
	}
	return STATUS_OK;
failed:
	world_release(world, held);
	return status;
}

static void add_tile(struct held_tiles *held, struct tile tile)
{
	held->tiles[held->count].tile = tile;
	held->keys[held->count++] = tile_key(tile);
}

size_t world_tiles_in(const struct world *world, struct post_rect rect)
{
	struct tile first, last;
	if (!tile_range_of(&world->resident.meta->extent, world->resident.level, rect, &first, &last))
		return 0;
	return (size_t)(last.x - first.x + 1) * (last.y - first.y + 1);
}

enum status world_hold_tile(struct world *world, struct tile tile, struct held_tiles *held)
{
	held->count = 0;
	add_tile(held, tile);
	return pin(world, held, true);
}

static enum status hold(struct world *world, struct post_rect rect, struct held_tiles *held, bool newest)
{
	const struct extent *extent = &world->resident.meta->extent;
	struct tile first, last;
	held->count = 0;
	if (!tile_range_of(extent, world->resident.level, rect, &first, &last))
		return STATUS_OK;
	size_t needed = (size_t)(last.x - first.x + 1) * (last.y - first.y + 1);
	if (needed > WORLD_TILES_MOST) /* world_budget_check finds this before the drive, but for a body whose bounding sphere needs too many windows */
		return fail_with(STATUS_INPUT, "a body: it touches %zu tiles of %u cells at once, and %d is the most; import with larger tiles (--tile)", needed,
				 extent->cells, WORLD_TILES_MOST);
	if (needed > 4 && !world->counts.windows.told) {
		note("tiles of %u cells are smaller than an object's window: it touches %zu of them at once, not four",
		     extent->cells, needed);
		world->counts.windows.told = true;
	}
	if (needed > world->counts.windows.tiles_most)
		world->counts.windows.tiles_most = needed;
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x; x++)
			add_tile(held, (struct tile){world->resident.level, x, y});
	return pin(world, held, newest);
}

enum status world_hold(struct world *world, struct post_rect rect, struct held_tiles *held)
{
	return hold(world, rect, held, true);
}

enum status world_hold_own(struct world *world, struct post_rect rect, struct held_tiles *held)
{
	return hold(world, rect, held, false);
}

void world_release(struct world *world, struct held_tiles *held)
{
	for (size_t i = 0; i < held->count; i++)
		page_cache_unpin(world->resident.cache, held->keys[i]);
	held->count = 0;
}

enum status world_mark(struct world *world, struct post_rect rect, const struct held_tiles *held)
{
	resident_newest_changed(world->resident.newest);
	for (size_t i = 0; i < held->count; i++) {
		struct tile tile = held->tiles[i].tile;
		if (post_rect_empty(post_rect_intersect(rect, tile_post_rect(&world->resident.meta->extent, tile))))
			continue;
		page_cache_dirty(world->resident.cache, held->keys[i]);
		if (world->ranks != NULL)
			TRY(world->ranks->changes(world->ranks->user, held->keys[i]));
		TRY(world_changed(world, tile, post_rect_intersect(rect, tile_post_rect(&world->resident.meta->extent, tile))));
		if (world->resident.pyramid != NULL)
			TRY(resident_pyramid_changed(world->resident.pyramid, tile, rect));
		TRY(world_happened_change(world, tile));
	}
	return STATUS_OK;
}

static enum status scatter(struct world *world, const struct deform_window *window, uint32_t layer,
			   const struct held_tiles *held)
{
	TRY(deform_scatter(world->deform, window, layer, held->tiles, held->count));
	TRY(world_mark(world, window->write, held));
	return deform_wake_swept(world->deform, window, layer);
}

/* Computes how far a belt ran between two path samples: with slip s it is the way along the body's own x axis / (1 - s). */
static void run(const struct scene_object *object, struct deform_contact *contact)
{
	const struct soil_pose *to = &contact->to, *from = &contact->from;
	const double way[3] = {lattice_offset_metres(to->x - from->x), lattice_offset_metres(to->y - from->y), lattice_offset_metres(to->z - from->z)};
	double axes[3][3], along = 0;
	soil_axes(to->yaw, to->pitch, to->roll, 0, axes);
	for (int k = 0; k < 3; k++)
		along += way[k] * axes[0][k];
	if (object->path.attitude[0] != 0)
		along = sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
	contact->turned = along / (1 - object->slip);
	contact->to.turn = contact->from.turn + contact->turned;
}

/* Computes how far a wheel turned between two path samples. With slip s it is way / (r (1 - s)). The contact has no duration:
 * nothing damps a body that follows a path. */
static void roll(const struct body *body, struct deform_contact *contact)
{
	const struct scene_object *object = body->object;
	if (object->shape.belt) {
		run(object, contact);
		return;
	}
	if (object->shape.kind != SOIL_WHEEL)
		return;
	double along = scene_slip_way(object, lattice_offset_metres(contact->to.x - contact->from.x), lattice_offset_metres(contact->to.y - contact->from.y), contact->to.yaw);
	/* A wheel that follows the ground rolls along its slope, which is longer than the way in plan. If the path gives the heights
	 * instead, a change of height need not be a slope. */
	const double level = hypot(lattice_offset_metres(contact->to.x - contact->from.x), lattice_offset_metres(contact->to.y - contact->from.y));
	const double rise = !object->path.has_z || object->load > 0 ? lattice_offset_metres(contact->to.z - contact->from.z) : 0;
	if (level > 0)
		along *= hypot(level, rise) / level;
	contact->turned = along / (soil_shape_rolling(&object->shape) * (1 - object->slip));
	contact->to.turn = remainder(contact->from.turn + contact->turned, 2 * M_PI);
}

enum status world_tell_contact(struct world *world, const struct event *event, const struct deform_contact *contact,
			       const struct deform_window *windows, size_t count)
{
	if (!world->happened.watched || count == 0)
		return STATUS_OK;
	struct contact_area told = {
		.lowest = contact->load > 0 ? INT64_MIN : world_lowest(contact),
		.changed = windows[0].write,
		.read = windows[0].read,
	};
	for (size_t i = 1; i < count; i++) {
		told.changed = post_rect_around(told.changed, windows[i].write);
		told.read = post_rect_around(told.read, windows[i].read);
	}
	return world_happened_touch(world, event, &told);
}

void world_count_windows(struct body *body, const struct deform_contact *contact, size_t computed)
{
	body->windows += computed;
	body->windows_moved += deform_is_contact_only(contact) ? 0 : computed;
}

static struct deform_contact contact_of(const struct world *world, const struct body *body, const struct event *event)
{
	struct deform_contact contact = {
		.shape = &body->object->shape,
		.interface = body->object->interface,
		.from = body->has_last ? body->last : event->pose,
		.to = event->pose,
		.trend = body->trend,
		.load = body->object->load > 0 ? body->object->load + world_carried_load(world, body) : 0,
		.carried = body->carried,
		.loaded_body = body->loaded_body,
	};
	if (world_is_hosted(body)) {
		contact.hosted = true;
		if (event->seconds > 0) {
			memcpy(contact.linear, body->host.now.linear, sizeof contact.linear);
			memcpy(contact.angular, body->host.now.angular, sizeof contact.angular);
			contact.runs = contact.shape->belt ? body->host.belt.speed : 0;
		}
		contact.stamped = event->stamped;
		contact.seconds = event->seconds;
		contact.turned = event->turned;
		memcpy(contact.rotated, event->rotated, sizeof contact.rotated);
	} else {
		contact.seconds = event->seconds;
		contact.to.turn = contact.from.turn = body->last.turn;
		if (body->has_last)
			roll(body, &contact);
	}
	if (world_keeps_marks(world->scene)) {
		contact.now = world_marks_at(world, event->time).now;
		contact.torn = world_torn(world, &contact);
	}
	return contact;
}

/* A contact with soil that bears. It waits for others of this time: world_meetings_flush computes it. */
static enum status bearing_contact_at(struct world *world, const struct event *event, const struct deform_contact *contact, bool feels)
{
	struct body *body = world_body_at(world, event->body);
	struct bearing_area area;
	TRY(bearing_area(world->bearing, contact, &area));
	if (!feels && body->has_last && !bearing_covers(world->bearing, contact, &area, &body->last))
		TRY(world_let_go(world, body));
	if (post_rect_empty(area.write)) {
		world_forces_absent(world->forces, event->body, event);
		return STATUS_OK;
	}
	return world_meetings_add(world, event, contact, &area, feels);
}

enum status world_feel(struct world *world, const struct event *event)
{
	const struct deform_contact contact = contact_of(world, world_body_at(world, event->body), event);
	return bearing_contact_at(world, event, &contact, true);
}

/* Computes the only window of a contact in fixed regions. */
static enum status compute_fixed(struct world *world, struct body *body, const struct deform_contact *contact, const struct deform_window *window)
{
	struct held_tiles held;
	size_t regions = 0;
	enum status status;
	TRY(world_hold(world, window->read, &held));
	TRY_OR(done, deform_fixed(world->deform, contact, window, held.tiles, held.count, &regions));
	TRY_OR(done, world_mark(world, window->write, &held));
	body->regions += regions;
	body->regions_moved += deform_is_contact_only(contact) ? 0 : regions;
done:
	world_release(world, &held);
	return status;
}

/* Computes a window, and writes it if it is the only one. */
static enum status compute_window(struct world *world, const struct deform_contact *contact, const struct deform_window *window, uint32_t layer, bool only)
{
	struct held_tiles held;
	enum status status;
	TRY(world_hold(world, window->read, &held));
	TRY_OR(done, deform_compute(world->deform, contact, window, layer, held.tiles, held.count));
	if (only)
		TRY_OR(done, scatter(world, window, layer, &held));
done:
	world_release(world, &held);
	return status;
}

static enum status write_window(struct world *world, const struct deform_window *window, uint32_t layer)
{
	struct held_tiles held;
	TRY(world_hold(world, window->write, &held));
	const enum status status = scatter(world, window, layer, &held);
	world_release(world, &held);
	return status;
}

static enum status compute_each(struct world *world, struct body *body, const struct deform_contact *contact, const struct deform_window *windows, size_t count)
{
	for (size_t i = 0; i < count; i++)
		TRY(compute_window(world, contact, &windows[i], (uint32_t)i, count == 1));
	world_count_windows(body, contact, deform_windows_computed(windows, count));
	/* Several windows read the ground as it was before any of them changed it. */
	for (size_t i = 0; count > 1 && i < count; i++)
		TRY(write_window(world, &windows[i], (uint32_t)i));
	return STATUS_OK;
}

static enum status compute_windows(struct world *world, const struct event *event, const struct deform_contact *contact,
				   const struct deform_window *windows, size_t count)
{
	struct body *body = world_body_at(world, event->body);
	TRY(world_tell_contact(world, event, contact, windows, count));
	if (deform_is_fixed(world->deform, windows, count))
		return compute_fixed(world, body, contact, &windows[0]);
	return compute_each(world, body, contact, windows, count);
}

enum status world_contact_leave(struct world *world, struct body *body, const struct deform_contact *rest)
{
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count = 0;
	TRY(deform_windows(world->deform, rest, windows, &count));
	const enum status status = compute_each(world, body, rest, windows, count);
	world_happened_relaxes(world);
	return status;
}

/* Computes windows at once. */
static enum status compute_alone(struct world *world, const struct event *event, const struct deform_contact *contact,
				 const struct deform_window *windows, size_t count)
{
	const enum status status = compute_windows(world, event, contact, windows, count);
	world_happened_relaxes(world);
	return status;
}

/* Finds the bodies at rest over the posts of a contact. */
static enum status find_beside(struct world *world, const struct event *event, const struct deform_window *windows, size_t count, struct deform_contact *contact)
{
	struct post_rect read = windows[0].read;
	for (size_t i = 1; i < count; i++)
		read = post_rect_joined(read, windows[i].read);
	TRY(world_near_beside(world, event, read, contact));
	return contact->rest_count > 0 ? deform_need_roofs(world->deform) : STATUS_OK;
}

/* A contact that the GPU computes. */
static enum status deform_contact_at(struct world *world, const struct event *event, struct deform_contact *contact, bool waits)
{
	struct body *body = world_body_at(world, event->body);
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count = 0;
	bool aloft = false, waiting = false;
	TRY(deform_windows(world->deform, contact, windows, &count));
	/* Whether a body is above the ground depends on the contacts before. */
	if (waits && event->sinkage < 0)
		TRY(world_batches_flush(world));
	TRY(world_is_aloft(world, event, contact, windows, count, &aloft));
	if (count > 0 && !aloft)
		world_forces_met(world->forces, event->body, event);
	else
		world_forces_absent(world->forces, event->body, event);
	/* The ground under its last pose is free now. If the object jumped or turned, the contact may not cover it; then make
	 * it active. */
	if (body->has_last && !deform_covers(world->deform, contact, &body->last))
		TRY(world_let_go(world, body));
	const size_t due = deform_windows_computed(windows, count);
	world->counts.windows.due += due;
	world->counts.windows.computed += aloft ? 0 : due;
	count = aloft ? 0 : count;
	if (count > 0 && deform_conserves(world->scene->model))
		TRY(find_beside(world, event, windows, count, contact));
	if (waits && count > 0)
		TRY(world_batches_take(world, event, contact, windows, count, &waiting));
	return waiting ? STATUS_OK : compute_alone(world, event, contact, windows, count);
}

static enum status contact_at(struct world *world, const struct event *event, bool waits)
{
	struct body *body = world_body_at(world, event->body);
	struct deform_contact contact = contact_of(world, body, event);
	enum status status = STATUS_OK;
	if (body->elsewhere) /* of a vehicle: what the host knows of it goes on */
		status = STATUS_OK;
	else if (world->bearing == NULL)
		status = deform_contact_at(world, event, &contact, waits && world->batches != NULL);
	else
		status = world_feels(world) ? bearing_contact_at(world, event, &contact, false) : world_kinematic_contact(world, event, &contact);
	if (world_feels(world))
		body->trend = bearing_trend_after(world->bearing, &contact);
	body->has_last = true;
	body->last = contact.to;
	body->host.moving = !deform_is_contact_only(&contact);
	body->host.touched = event->time;
	return status;
}

enum status world_contact(struct world *world, const struct event *event)
{
	return contact_at(world, event, false);
}

enum status world_contact_or_wait(struct world *world, const struct event *event)
{
	return contact_at(world, event, true);
}
