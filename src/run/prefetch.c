/*
 * Loading ahead: the tiles that the objects' paths will touch within `prefetch` seconds, and what the
 * picture lacks.
 *
 * Each object has a lookout that goes along its path before it, station by station, and notes the
 * tiles of the very windows the object will have there: since when and until when each is needed. A
 * tile stays noted until the object has left it. A drive that runs faster than real time looks ahead as
 * much farther, so that loads have `prefetch` seconds by the clock too. Invariants: (1) an object's tiles
 * are in the order in which they are first needed; (2) what is loaded ahead never decides what comes out,
 * only when.
 */
#include <math.h>
#include <time.h>

#include "run/internal.h"

#define RECENT 16 /* tiles looked through for one that is still in use */

struct ahead_tile {
	uint64_t key;
	double from, until; /* simulated seconds */
};

struct lookout {
	int64_t station; /* the next it goes to */
	struct deform_pose last;
	struct ahead_tile *tiles;
	size_t count, room;
};

struct prefetch {
	struct drive *drive;
	struct lookout *lookouts; /* one an object */
	const uint64_t *keys;     /* of drive->wishes, in order */
	size_t key_count;
	size_t passed;            /* tiles forgotten since they were ordered */
};

enum status prefetch_create(struct drive *drive, struct prefetch **out)
{
	struct prefetch *prefetch = mem_calloc(1, sizeof *prefetch);
	if (prefetch == NULL)
		return fail_memory("loading ahead");
	prefetch->drive = drive;
	prefetch->lookouts = mem_calloc(drive->scene->object_count, sizeof *prefetch->lookouts);
	if (prefetch->lookouts == NULL) {
		mem_free(prefetch);
		return fail_memory("loading ahead");
	}
	for (size_t i = 0; i < drive->scene->object_count; i++)
		prefetch->lookouts[i].station = drive->riders[i].next;
	*out = prefetch;
	return STATUS_OK;
}

void prefetch_destroy(struct prefetch *prefetch)
{
	if (prefetch == NULL)
		return;
	for (size_t i = 0; i < prefetch->drive->scene->object_count; i++)
		mem_free(prefetch->lookouts[i].tiles);
	mem_free(prefetch->lookouts);
	mem_free(prefetch);
}

/* --- along a path --- */

static enum status note_tile(struct lookout *lookout, uint64_t key, double time)
{
	for (size_t i = lookout->count; i > 0 && i + RECENT > lookout->count; i--)
		if (lookout->tiles[i - 1].key == key) {
			lookout->tiles[i - 1].until = time;
			return STATUS_OK;
		}
	if (lookout->count == lookout->room) {
		size_t room = lookout->room != 0 ? 2 * lookout->room : 32;
		struct ahead_tile *tiles = mem_realloc(lookout->tiles, room, sizeof *tiles);
		if (tiles == NULL)
			return fail_memory("loading ahead");
		lookout->tiles = tiles;
		lookout->room = room;
	}
	lookout->tiles[lookout->count++] = (struct ahead_tile){key, time, time};
	return STATUS_OK;
}

static enum status note_station(struct prefetch *prefetch, struct lookout *lookout, const struct rider *rider)
{
	const struct drive *drive = prefetch->drive;
	const struct world *world = &drive->meta->world;
	struct track_point point;
	track_station(rider->track, lookout->station, &point);
	struct deform_sweep sweep = {
		.shape = &rider->object->shape,
		.from = lookout->last,
		.to = {.x = point.qx, .y = point.qy, .yaw = point.yaw, .pitch = point.pitch, .roll = point.roll},
	};
	if (lookout->station == 0 || lookout->count == 0)
		sweep.from = sweep.to;
	lookout->last = sweep.to;
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count = 0;
	enum status status = deform_windows(drive->deform, &sweep, windows, &count);
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		struct tile first, last;
		if (!tile_range_of(world, drive->level, windows[i].read, &first, &last))
			continue;
		for (uint32_t y = first.y; y <= last.y && status == STATUS_OK; y++)
			for (uint32_t x = first.x; x <= last.x && status == STATUS_OK; x++)
				status = note_tile(lookout, tile_key((struct tile){drive->level, x, y}), point.time);
	}
	return status;
}

/* Forgets what the object has left; returns how many. */
static size_t forget_passed(struct lookout *lookout, double now)
{
	size_t kept = 0, count = lookout->count;
	if (count == 0 || lookout->tiles[0].until >= now)
		return 0;
	for (size_t i = 0; i < count; i++)
		if (lookout->tiles[i].until >= now)
			lookout->tiles[kept++] = lookout->tiles[i];
	lookout->count = kept;
	return count - kept;
}

/* Simulated seconds. */
static double reach(const struct drive *drive)
{
	const double settled = 0.05; /* s: before, the pace says little */
	if (drive->began <= 0) /* before the first step */
		return drive->scene->prefetch;
	double pace = (drive->time - drive->resumed_time) / fmax(clock_seconds() - drive->began, settled);
	return drive->scene->prefetch * fmax(pace, 1);
}

/* On along the path until then; and no further once `most` tiles are noted. True in *news if one is new. */
static enum status go_on(struct prefetch *prefetch, struct lookout *lookout, const struct rider *rider, double until,
			 size_t most, bool *news)
{
	size_t before = lookout->count;
	enum status status = STATUS_OK;
	while (status == STATUS_OK && lookout->count < most && lookout->station < track_stations(rider->track) &&
	       track_station_time(rider->track, lookout->station) <= until) {
		status = note_station(prefetch, lookout, rider);
		lookout->station++;
	}
	*news |= lookout->count != before;
	return status;
}

/* *changed: there is something new, or enough was left behind. */
static enum status look_ahead(struct prefetch *prefetch, bool *changed)
{
	const struct drive *drive = prefetch->drive;
	double ahead = reach(drive), until = fmin(drive->time + ahead, drive->scene->end_time);
	if (drive->scout != NULL)
		scout_reach(drive->scout, ahead);
	enum status status = STATUS_OK;
	for (size_t i = 0; i < drive->scene->object_count; i++) {
		struct lookout *lookout = &prefetch->lookouts[i];
		const struct rider *rider = &drive->riders[i];
		if (status == STATUS_OK)
			status = go_on(prefetch, lookout, rider, drive->time, SIZE_MAX, changed);
		prefetch->passed += forget_passed(lookout, drive->time);
		/* More than a slot each is never loaded ahead, however far it looks. */
		if (status == STATUS_OK)
			status = go_on(prefetch, lookout, rider, until, drive->scene->slots, changed);
	}
	*changed |= prefetch->passed * 8 > prefetch->key_count;
	return status;
}

/* --- wishes --- */

static enum status gather(struct prefetch *prefetch)
{
	struct drive *drive = prefetch->drive;
	enum status status = STATUS_OK;
	wishes_clear(&drive->wishes);
	for (size_t i = 0; i < drive->scene->object_count; i++) {
		const struct lookout *lookout = &prefetch->lookouts[i];
		for (size_t k = 0; k < lookout->count && status == STATUS_OK; k++)
			status = wishes_add(&drive->wishes, lookout->tiles[k].key, lookout->tiles[k].from);
	}
	if (status == STATUS_OK && drive->view != NULL)
		status = view_wishes(drive->view, &drive->wishes);
	prefetch->passed = 0;
	prefetch->key_count = wishes_order(&drive->wishes, &prefetch->keys);
	return status;
}

enum status prefetch_step(struct prefetch *prefetch)
{
	struct drive *drive = prefetch->drive;
	if (drive->scene->prefetch <= 0 && drive->view == NULL)
		return STATUS_OK; /* nobody wishes for anything */
	bool changed = drive->view != NULL || prefetch->keys == NULL;
	enum status status = STATUS_OK;
	if (drive->scene->prefetch > 0)
		status = look_ahead(prefetch, &changed);
	if (status == STATUS_OK && changed)
		status = gather(prefetch);
	if (status == STATUS_OK && (changed || page_cache_wishes(drive->cache) != PAGE_WISHES_HERE))
		page_cache_want(drive->cache, prefetch->keys, prefetch->key_count);
	return status;
}

enum status prefetch_first(struct prefetch *prefetch)
{
	struct drive *drive = prefetch->drive;
	const volatile sig_atomic_t *stop = drive->params->stop;
	const struct timespec nap = {0, 50000};
	enum status status = prefetch_step(prefetch);
	while (status == STATUS_OK && page_cache_wishes(drive->cache) == PAGE_WISHES_COMING &&
	       (stop == NULL || !*stop)) {
		nanosleep(&nap, NULL);
		status = page_cache_poll(drive->cache);
	}
	return status;
}
