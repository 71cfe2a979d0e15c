/*
 * The contact of a kinematic model that the CPU computes. As on the GPU, tiles are pinned a window at a time, so a large body needs no more of them at
 * once. All windows are gathered before anything is computed.
 */
#include "world/internal.h"

static enum status gather(struct world *world, const struct deform_window *windows, size_t count, struct held_tiles *held)
{
	for (size_t i = 0; i < count; i++) {
		TRY(world_hold(world, windows[i].read, held));
		bearing_kinematic_gather(world->bearing, held->tiles, held->count);
		if (count > 1)
			world_release(world, held);
	}
	return STATUS_OK;
}

static enum status put(struct world *world, struct post_rect changed, const struct held_tiles *held)
{
	TRY(bearing_kinematic_scatter(world->bearing, changed, held->tiles, held->count));
	return world_mark(world, changed, held);
}

/* Writes what changed. held: the tiles of a single window are still pinned. The caller releases what is held after a failure. */
static enum status scatter(struct world *world, const struct deform_window *windows, size_t count, struct post_rect changed, struct held_tiles *held)
{
	if (count == 1)
		return put(world, changed, held);
	for (size_t i = 0; i < count; i++) {
		const struct post_rect part = post_rect_intersect(windows[i].write, changed);
		if (post_rect_empty(part))
			continue;
		TRY(world_hold(world, part, held));
		TRY(put(world, part, held));
		world_release(world, held);
	}
	return STATUS_OK;
}

/* event: NULL: the body leaves. *told: as bearing_kinematic_run tells. *changed: the posts that the contact may have changed. */
static enum status compute(struct world *world, const struct event *event, const struct deform_contact *contact, const struct bearing_area *area,
			   const struct deform_window *windows, size_t count, struct deform_forces *told, struct post_rect *changed)
{
	struct held_tiles held = {.count = 0};
	enum status status;
	if (event != NULL)
		TRY_OR(done, world_tell_contact(world, event, contact, windows, count));
	TRY_OR(done, bearing_kinematic_begin(world->bearing, contact, area));
	TRY_OR(done, gather(world, windows, count, &held));
	if (event != NULL)
		TRY_OR(done, bearing_kinematic_run(world->bearing, contact, area, count == 1 && windows[0].parts == 0, told, changed));
	else
		bearing_kinematic_leave(world->bearing, contact, changed);
	if (!post_rect_empty(*changed))
		TRY_OR(done, scatter(world, windows, count, *changed, &held));
done:
	world_release(world, &held);
	world_happened_relaxes(world);
	return status;
}

/* Finds the windows of a contact, and all that they read and write. */
static enum status windows_of(const struct world *world, const struct deform_contact *contact, struct deform_window *windows, size_t *count, struct bearing_area *area)
{
	*area = (struct bearing_area){{0, 0, 0, 0}, {0, 0, 0, 0}};
	TRY(deform_cut(&world->surface, contact, windows, count));
	for (size_t i = 0; i < *count; i++) {
		area->read = post_rect_joined(area->read, windows[i].read);
		area->write = post_rect_joined(area->write, windows[i].write);
	}
	return STATUS_OK;
}

enum status world_kinematic_leave(struct world *world, const struct deform_contact *rest)
{
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	struct bearing_area area;
	struct post_rect changed = {0, 0, 0, 0};
	size_t count;
	TRY(windows_of(world, rest, windows, &count, &area));
	return count > 0 ? compute(world, NULL, rest, &area, windows, count, NULL, &changed) : STATUS_OK;
}

enum status world_kinematic_contact(struct world *world, const struct event *event, struct deform_contact *contact)
{
	struct body *body = world_body_at(world, event->body);
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	struct bearing_area area;
	struct post_rect changed = {0, 0, 0, 0};
	struct deform_forces told = {.z = 0};
	size_t count;
	bool aloft = false;
	TRY(windows_of(world, contact, windows, &count, &area));
	TRY(world_is_aloft(world, event, contact, windows, count, &aloft));
	if (count > 0 && !aloft)
		world_forces_met(world->forces, event->body, event); /* rows tell where the body is */
	else
		world_forces_absent(world->forces, event->body, event);
	if (body->has_last && !bearing_covers(world->bearing, contact, &area, &body->last))
		TRY(world_let_go(world, body));
	const size_t due = deform_windows_computed(windows, count);
	world->counts.windows.due += due;
	if (count == 0 || aloft)
		return STATUS_OK;
	if (deform_conserves(world->scene->model))
		TRY(world_near_beside(world, event, area.read, contact));
	world->counts.windows.computed += due;
	TRY(compute(world, event, contact, &area, windows, count, &told, &changed));
	if (contact->load > 0)
		world_forces_felt(world->forces, event->body, event, &told);
	if (contact->load > 0 && contact->loaded_body == 0) /* nothing else keeps its height */
		contact->to.z = told.z;
	world_count_windows(body, contact, due);
	return STATUS_OK;
}
