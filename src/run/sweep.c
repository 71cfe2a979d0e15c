/* One station's deformation: pin the tiles its windows touch, compute, scatter, mark dirty. */
#include <assert.h>
#include <math.h>

#include "run/internal.h"

enum status drive_hold(struct drive *drive, struct post_rect rect, struct held_tiles *held)
{
	const struct world *world = &drive->meta->world;
	struct tile first, last;
	held->count = 0;
	if (!tile_range_of(world, drive->level, rect, &first, &last))
		return STATUS_OK;
	size_t needed = (size_t)(last.x - first.x + 1) * (last.y - first.y + 1);
	assert(needed <= BUDGET_WINDOW_TILES); /* budget_check */
	if (needed > 4 && !drive->told_tiles) {
		note("tiles of %u cells are smaller than an object's window: it touches %zu of them at once, not four",
		     world->cells, needed);
		drive->told_tiles = true;
	}
	if (needed > drive->passes_most)
		drive->passes_most = needed;
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x; x++) {
			struct tile tile = {drive->level, x, y};
			held->tiles[held->count].tile = tile;
			held->keys[held->count++] = tile_key(tile);
		}
	uint32_t slots[BUDGET_WINDOW_TILES];
	enum status status = page_cache_pin_all(drive->cache, held->keys, held->count, slots);
	if (status != STATUS_OK) {
		held->count = 0;
		return status;
	}
	for (size_t i = 0; i < held->count && status == STATUS_OK; i++) {
		held->tiles[i].slot = slots[i];
		status = drive_see(drive, &held->tiles[i]);
	}
	if (status != STATUS_OK)
		drive_release(drive, held);
	return status;
}

void drive_release(struct drive *drive, struct held_tiles *held)
{
	for (size_t i = 0; i < held->count; i++)
		page_cache_unpin(drive->cache, held->keys[i]);
	held->count = 0;
}

enum status drive_mark(struct drive *drive, struct post_rect rect, const struct held_tiles *held)
{
	enum status status = STATUS_OK;
	newest_changed(drive->newest);
	for (size_t i = 0; i < held->count && status == STATUS_OK; i++) {
		struct tile tile = held->tiles[i].tile;
		if (post_rect_empty(post_rect_intersect(rect, tile_post_rect(&drive->meta->world, tile))))
			continue;
		page_cache_dirty(drive->cache, held->keys[i]);
		if (drive->pyramid != NULL)
			status = pyramid_changed(drive->pyramid, tile, rect);
		if (status == STATUS_OK && drive->view != NULL)
			status = view_deformed(drive->view, tile);
	}
	return status;
}

static enum status scatter(struct drive *drive, const struct deform_window *window, uint32_t layer,
			   const struct held_tiles *held)
{
	enum status status = deform_scatter(drive->deform, window, layer, held->tiles, held->count);
	if (status == STATUS_OK)
		status = drive_mark(drive, window->write, held);
	return status == STATUS_OK ? deform_wake_swept(drive->deform, window, layer) : status;
}

/* How it rolled from one station to the next: by its slip s, as far as way / (r (1 - s)). */
static void roll(const struct rider *rider, const struct event *event, struct deform_sweep *sweep)
{
	const struct scene_object *object = rider->object;
	sweep->seconds = event->seconds;
	if (object->shape.kind != DEFORM_WHEEL)
		return;
	double along = lattice_offset_metres(sweep->to.x - sweep->from.x) * cos(sweep->to.yaw) +
		       lattice_offset_metres(sweep->to.y - sweep->from.y) * sin(sweep->to.yaw);
	sweep->turned = along / (object->shape.radius * (1 - object->slip));
	sweep->to.turn = remainder(sweep->from.turn + sweep->turned, 2 * M_PI);
}

/* The least that holds both. */
static struct post_rect around(struct post_rect a, struct post_rect b)
{
	return (struct post_rect){a.x0 < b.x0 ? a.x0 : b.x0, a.y0 < b.y0 ? a.y0 : b.y0, a.x1 > b.x1 ? a.x1 : b.x1,
				  a.y1 > b.y1 ? a.y1 : b.y1};
}

static enum status tell_view(const struct drive *drive, const struct event *event, const struct deform_sweep *sweep,
			     const struct deform_window *windows, size_t count)
{
	struct view_sweep told = {
		.lowest = sweep->load > 0 ? INT64_MIN : drive_lowest(sweep),
		.changed = windows[0].write,
		.read = windows[0].read,
	};
	for (size_t i = 1; i < count; i++) {
		told.changed = around(told.changed, windows[i].write);
		told.read = around(told.read, windows[i].read);
	}
	return view_pressed(drive->view, event, &told);
}

enum status drive_sweep(struct drive *drive, const struct event *event, bool last)
{
	struct rider *rider = &drive->riders[event->rider];
	struct deform_sweep sweep = {
		.shape = &rider->object->shape,
		.from = rider->in_contact ? rider->last : event->pose,
		.to = event->pose,
		.load = rider->object->load,
		.carrier = rider->carrier,
	};
	sweep.to.turn = sweep.from.turn = rider->last.turn;
	if (rider->in_contact)
		roll(rider, event, &sweep);
	/* Where it stood is not known here, and need not be: it presses as it stands now. */
	if (sweep.load > 0)
		sweep.from.z = sweep.to.z;
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count = 0;
	enum status status = deform_windows(drive->deform, &sweep, windows, &count);
	struct held_tiles held = {.count = 0};
	bool aloft = false;
	if (status == STATUS_OK)
		status = drive_is_aloft(drive, event, &sweep, windows, count, &aloft);
	if (status == STATUS_OK && count > 0 && !aloft)
		sweep.tag = forces_ask(drive->forces, event->rider, event, last);
	else
		forces_absent(drive->forces, event->rider, event);
	/* What it stood on is free: where the sweep does not look, if it has jumped or turned, somebody else must. */
	if (status == STATUS_OK && rider->in_contact && !deform_covers(drive->deform, &sweep, &rider->last))
		status = drive_let_go(drive, rider);
	drive->windows_due += count;
	count = aloft ? 0 : count;
	drive->windows += count;
	if (status == STATUS_OK && drive->view != NULL && count > 0)
		status = tell_view(drive, event, &sweep, windows, count);
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		status = drive_hold(drive, windows[i].read, &held);
		if (status == STATUS_OK)
			status = deform_compute(drive->deform, &sweep, &windows[i], (uint32_t)i, held.tiles, held.count);
		rider->windows += status == STATUS_OK;
		rider->windows_moved += status == STATUS_OK && !deform_is_contact_only(&sweep);
		if (status == STATUS_OK && count == 1)
			status = scatter(drive, &windows[0], 0, &held);
		drive_release(drive, &held);
	}
	/* Several windows read the ground as it was before any of them changed it. */
	for (size_t i = 0; count > 1 && i < count && status == STATUS_OK; i++) {
		status = drive_hold(drive, windows[i].write, &held);
		if (status == STATUS_OK)
			status = scatter(drive, &windows[i], (uint32_t)i, &held);
		drive_release(drive, &held);
	}
	rider->in_contact = true;
	rider->last = sweep.to;
	if (status == STATUS_OK && drive->view != NULL && count > 0)
		status = view_pressed(drive->view, NULL, NULL);
	return status;
}
