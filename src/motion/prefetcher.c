/*
 * Loads base tiles before a body or the camera needs them. This is the work of one thread, in looks.
 *
 * A look predicts which tiles will be needed. Walkers move along the tracks of bodies and the way of the camera, one for each,
 * beginning at the present time. The walker with the earliest time moves next. At each of its places it adds the tiles around it
 * to the list. Where an inset lies, these are tiles of all its levels, the finest first, and the steps are as small as those tiles ask
 * for. The look ends at its time limit, or when the list or the number of places is full. Then the tiles of the list are
 * loaded, those needed soonest first. The next look begins when an eighth of the predicted time has passed.
 *
 * Invariants:
 * - Only the thread uses the walkers and the list. `told`, `look_at`, `reach`, `ranges_done` and `stopping` are atomic. The
 * mutex guards `asleep` and the ranges. Nothing else changes.
 * - It sleeps only while told < look_at and no range is left to load. It writes look_at and then reads told. The caller writes
 * told and then reads look_at, and wakes it with the mutex held. So one of the two sees the other's value.
 * - The list is shorter than the ground holds. Its tiles that are already there are marked as used before any is loaded. So
 * none of them is evicted while the ground has a tile that the owner did not use since.
 */
#include "motion/prefetcher.h"

#include "motion/insets.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#define PREFETCHER_THREAD "furrow-ahead"
#define TILE_PARTS 16 /* a walker's places are a sixteenth of the finest tile's width apart */
#define PLACES_MAX 65536 /* most places in one look */
#define RANGES_ROOM 1024 /* most ranges that wait to be loaded */

struct walker {
	const struct track *track; /* NULL: the camera's */
	int64_t past;              /* the last path sample whose time has passed */
	int64_t sample, last;      /* path sample where the walker is; the last one of the track */
	double time;               /* of the walker, s; INFINITY: it is at the end of its track */
	int level;                 /* finest level that may have tiles on the way to the next place */
	int before;                /* the same, on the way from the last place */
};

struct prefetcher {
	struct prefetcher_params params;
	const struct extent *extent;
	struct store_reader *reader;
	struct inset_areas insets;
	struct walker *walkers;
	size_t walker_count;
	struct tile *list;    /* soonest needed first */
	uint32_t listed;
	struct thread thread;
	struct mutex mutex;
	struct condition changed; /* the thread sleeps on it, and motion_prefetcher_wait waits on it */
	/* guarded by the mutex: */
	bool asleep;
	struct ground_range_key ranges[RANGES_ROOM];
	size_t range_next, range_count; /* index of the next range to load, and their number */
	_Atomic uint64_t ranges_done;
	/* s. told: the present time, from the caller. look_at: time at which the next look begins. reach: how far ahead a look goes */
	_Atomic double told, look_at, reach;
	atomic_bool stopping;
};

/* --- a look --- */

static bool add_tile(struct prefetcher *prefetcher, struct tile tile)
{
	for (uint32_t i = prefetcher->listed; i-- > 0;)
		if (tile_equal(prefetcher->list[i], tile))
			return true;
	if (prefetcher->listed == prefetcher->params.tiles)
		return false;
	prefetcher->list[prefetcher->listed++] = tile;
	return true;
}

/* Returns the distance between two places where tiles of `level` lie, in posts of level 0. */
static double step_of(const struct prefetcher *prefetcher, int level)
{
	return ldexp(prefetcher->extent->cells, level) / TILE_PARTS;
}

/* Adds the tiles of a level within `reach` of (px, py), in posts of level 0. Returns false if the list is full. */
static bool add_level(struct prefetcher *prefetcher, int level, double px, double py, double reach)
{
	const struct extent *extent = prefetcher->extent;
	double x0 = fmax(px - reach, 0), x1 = fmin(px + reach, (double)(extent->width - 1));
	double y0 = fmax(py - reach, 0), y1 = fmin(py + reach, (double)(extent->height - 1));
	if (x0 > x1 || y0 > y1)
		return true; /* outside */
	struct tile first = resident_ground_tile_of(extent, level, x0, y0), last = resident_ground_tile_of(extent, level, x1, y1);
	bool room = true;
	for (uint32_t ty = first.y; ty <= last.y; ty++)
		for (uint32_t tx = first.x; tx <= last.x; tx++) {
			const struct tile tile = {level, tx, ty};
			bool stored;
			/* What cannot be read is left to the ground's owner. */
			if (resident_ground_stored(prefetcher->params.ground, prefetcher->reader, tile, &stored) == STATUS_OK && stored)
				room = room && add_tile(prefetcher, tile);
		}
	return room;
}

/* Adds the tiles within half the distance to the places before and after, so that successive places miss no tile. On a way where a level
 * may have no tiles none of them is looked for. Returns false if the list is full. */
static bool add_place(struct prefetcher *prefetcher, const struct walker *walker, double x, double y)
{
	bool room = true;
	/* The owner reads the finest level first. */
	for (int level = walker->level < walker->before ? walker->level : walker->before; level <= 0 && room; level++) {
		double after = walker->level <= level ? step_of(prefetcher, walker->level) : 0;
		double before = walker->before <= level ? step_of(prefetcher, walker->before) : 0;
		room = add_level(prefetcher, level, x / prefetcher->extent->spacing, y / prefetcher->extent->spacing, 0.5 * fmax(after, before));
	}
	return room;
}

/* Returns the points where a walker needs the ground: one of its track, at most two of the camera. */
static size_t places_of(const struct prefetcher *prefetcher, const struct walker *walker, double places[2][2])
{
	if (walker->track == NULL)
		return prefetcher->params.camera(prefetcher->params.user, walker->time, places);
	struct track_point point;
	motion_track_sample(walker->track, walker->sample, &point);
	places[0][0] = point.x;
	places[0][1] = point.y;
	return 1;
}

static bool add_walker(struct prefetcher *prefetcher, const struct walker *walker)
{
	double places[2][2];
	size_t count = places_of(prefetcher, walker, places);
	bool room = true;
	for (size_t i = 0; i < count; i++)
		room = room && add_place(prefetcher, walker, places[i][0], places[i][1]);
	return room;
}

/* Finds out how large the walker's next step may be: a large one must not pass over an inset. */
static void look_around(const struct prefetcher *prefetcher, struct walker *walker)
{
	double places[2][2], spacing = prefetcher->extent->spacing;
	walker->before = walker->level;
	walker->level = 0;
	if (prefetcher->insets.count == 0)
		return;
	size_t count = places_of(prefetcher, walker, places);
	for (size_t i = 0; i < count; i++) {
		int level = motion_insets_level(&prefetcher->insets, places[i][0] / spacing, places[i][1] / spacing, step_of(prefetcher, 0));
		walker->level = level < walker->level ? level : walker->level;
	}
}

static int64_t next_sample(const struct prefetcher *prefetcher, const struct walker *walker)
{
	double stride = floor(step_of(prefetcher, walker->level) * prefetcher->extent->spacing / prefetcher->params.post);
	int64_t samples = stride > 1 ? (int64_t)stride : 1;
	return walker->last - walker->sample > samples ? walker->sample + samples : walker->last;
}

static void begin(struct prefetcher *prefetcher, struct walker *walker, double now)
{
	walker->time = now;
	walker->sample = walker->past;
	look_around(prefetcher, walker);
	walker->before = walker->level;
	if (walker->track == NULL)
		return;
	for (int64_t next; (next = next_sample(prefetcher, walker)) != walker->sample && !atomic_load(&prefetcher->stopping);) {
		if (motion_track_sample_time(walker->track, next) > now)
			break;
		walker->sample = next;
		look_around(prefetcher, walker);
	}
	walker->past = walker->sample;
	walker->time = motion_track_sample_time(walker->track, walker->sample);
}

static void go_on(const struct prefetcher *prefetcher, struct walker *walker)
{
	const struct prefetcher_params *params = &prefetcher->params;
	if (walker->track == NULL) {
		double step = step_of(prefetcher, walker->level) * prefetcher->extent->spacing / params->camera_speed;
		walker->time += fmin(fmax(step, params->prefetch / 1024), params->prefetch / 16);
	} else {
		int64_t next = next_sample(prefetcher, walker);
		walker->time = next == walker->sample ? (double)INFINITY : motion_track_sample_time(walker->track, next);
		walker->sample = next;
	}
	if (walker->time < (double)INFINITY)
		look_around(prefetcher, walker);
}

/* Lists the tiles that will be needed from `now` on, s. Returns the time until which the list has all of them. */
static double look(struct prefetcher *prefetcher, double now)
{
	double until = fmin(now + atomic_load(&prefetcher->reach), prefetcher->params.end);
	prefetcher->listed = 0;
	for (size_t i = 0; i < prefetcher->walker_count; i++)
		begin(prefetcher, &prefetcher->walkers[i], now);
	for (uint32_t places = 0;; places++) {
		struct walker *soonest = &prefetcher->walkers[0];
		for (size_t i = 1; i < prefetcher->walker_count; i++)
			if (prefetcher->walkers[i].time < soonest->time)
				soonest = &prefetcher->walkers[i];
		if (soonest->time > until)
			return soonest->time < (double)INFINITY ? until : (double)INFINITY;
		if (places == PLACES_MAX || !add_walker(prefetcher, soonest))
			return soonest->time;
		go_on(prefetcher, soonest);
	}
}

/* Loads the next range. Returns false if none is left. */
static bool bring_range(struct prefetcher *prefetcher)
{
	struct ground_range_key key;
	mutex_lock(&prefetcher->mutex);
	bool any = prefetcher->range_next < prefetcher->range_count;
	if (any)
		key = prefetcher->ranges[prefetcher->range_next++];
	mutex_unlock(&prefetcher->mutex);
	if (!any)
		return false;
	/* On failure the range stays missing. The ground's owner will read it again and report the failure. */
	enum status status = resident_ground_warm_range(prefetcher->params.ground, prefetcher->reader, &key);
	(void)status;
	atomic_fetch_add(&prefetcher->ranges_done, 1);
	return true;
}

/* Loads the tiles of the list into the ground. If a tile cannot be read, it stays missing, and the ground's owner will report it. */
static void bring(struct prefetcher *prefetcher)
{
	for (uint32_t i = prefetcher->listed; i-- > 0;)
		resident_ground_touch(prefetcher->params.ground, prefetcher->list[i]);
	for (uint32_t i = 0; i < prefetcher->listed && !atomic_load(&prefetcher->stopping); i++) {
		enum status status = resident_ground_warm(prefetcher->params.ground, prefetcher->reader, prefetcher->list[i]);
		(void)status;
		bring_range(prefetcher);
	}
}

static void *body(void *argument)
{
	struct prefetcher *prefetcher = argument;
	thread_background();
	while (!atomic_load(&prefetcher->stopping)) {
		double now = atomic_load(&prefetcher->told), until = look(prefetcher, now);
		bring(prefetcher);
		double ahead = fmax(now + (until - now) / 8, nextafter(now, INFINITY));
		mutex_lock(&prefetcher->mutex);
		atomic_store(&prefetcher->look_at, until < prefetcher->params.end ? ahead : (double)INFINITY);
		while (atomic_load(&prefetcher->told) < atomic_load(&prefetcher->look_at) && !atomic_load(&prefetcher->stopping)) {
			if (prefetcher->range_next < prefetcher->range_count) {
				mutex_unlock(&prefetcher->mutex);
				bring_range(prefetcher);
				mutex_lock(&prefetcher->mutex);
				continue;
			}
			prefetcher->asleep = true;
			condition_wake_all(&prefetcher->changed);
			condition_wait(&prefetcher->changed, &prefetcher->mutex);
			prefetcher->asleep = false;
		}
		atomic_store(&prefetcher->look_at, (double)INFINITY); /* it is awake, so no caller needs to wake it */
		mutex_unlock(&prefetcher->mutex);
	}
	return NULL;
}

/* --- life --- */

static void mount_walkers(struct prefetcher *prefetcher)
{
	const struct prefetcher_params *params = &prefetcher->params;
	prefetcher->walker_count = params->count + (params->camera != NULL);
	for (size_t i = 0; i < params->count; i++)
		prefetcher->walkers[i] = (struct walker){.track = params->tracks[i], .last = motion_track_samples(params->tracks[i]) - 1};
}

void motion_prefetcher_plan(double prefetch, size_t count, struct plan *plan)
{
	if (prefetch > 0 && count > 0)
		plan_add(plan, &(struct plan_line){.kind = PLAN_THREAD, .effect = scene_effect_row(EFFECT_PREFETCH)->name,
						   .object = -1, .amount = 1}, PREFETCHER_THREAD);
}

enum status motion_prefetcher_create(const struct prefetcher_params *params, struct prefetcher **out)
{
	assert(params->count >= 1 && params->prefetch > 0);
	struct prefetcher *prefetcher = mem_calloc(1, sizeof *prefetcher);
	if (prefetcher == NULL)
		return fail_memory("the prefetcher");
	prefetcher->params = *params;
	prefetcher->extent = &store_meta(params->store)->extent;
	mutex_init(&prefetcher->mutex);
	condition_init(&prefetcher->changed);
	atomic_init(&prefetcher->told, 0);
	atomic_init(&prefetcher->reach, params->prefetch);
	atomic_init(&prefetcher->look_at, (double)INFINITY);
	atomic_init(&prefetcher->stopping, false);
	atomic_init(&prefetcher->ranges_done, 0);
	prefetcher->walkers = mem_calloc(params->count + 1, sizeof *prefetcher->walkers);
	prefetcher->list = mem_alloc(params->tiles, sizeof *prefetcher->list);
	enum status status = prefetcher->walkers != NULL && prefetcher->list != NULL ? STATUS_OK : fail_memory("the prefetcher");
	if (status == STATUS_OK)
		mount_walkers(prefetcher);
	if (status == STATUS_OK)
		status = motion_insets_init(params->store, &prefetcher->insets);
	if (status == STATUS_OK)
		status = store_reader_create(params->store, &prefetcher->reader);
	if (status == STATUS_OK)
		status = thread_start(&prefetcher->thread, body, prefetcher, PREFETCHER_THREAD);
	if (status != STATUS_OK) {
		motion_prefetcher_destroy(prefetcher);
		return status;
	}
	*out = prefetcher;
	return STATUS_OK;
}

static void wake(struct prefetcher *prefetcher)
{
	mutex_lock(&prefetcher->mutex);
	condition_wake_all(&prefetcher->changed);
	mutex_unlock(&prefetcher->mutex);
}

void motion_prefetcher_destroy(struct prefetcher *prefetcher)
{
	if (prefetcher == NULL)
		return;
	atomic_store(&prefetcher->stopping, true);
	wake(prefetcher);
	thread_join(&prefetcher->thread);
	store_reader_destroy(prefetcher->reader);
	mem_free(prefetcher->list);
	mem_free(prefetcher->walkers);
	motion_insets_finish(&prefetcher->insets);
	condition_finish(&prefetcher->changed);
	mutex_finish(&prefetcher->mutex);
	mem_free(prefetcher);
}

void motion_prefetcher_reach(struct prefetcher *prefetcher, double seconds)
{
	atomic_store(&prefetcher->reach, seconds);
}

void motion_prefetcher_ranges(struct prefetcher *prefetcher, const struct ground_range_key *keys, size_t count)
{
	mutex_lock(&prefetcher->mutex);
	prefetcher->range_next = 0;
	prefetcher->range_count = count < RANGES_ROOM ? count : RANGES_ROOM;
	memcpy(prefetcher->ranges, keys, prefetcher->range_count * sizeof *keys);
	condition_wake_all(&prefetcher->changed);
	mutex_unlock(&prefetcher->mutex);
}

uint64_t motion_prefetcher_ranges_done(struct prefetcher *prefetcher)
{
	return atomic_load(&prefetcher->ranges_done);
}

void motion_prefetcher_tell(struct prefetcher *prefetcher, double time)
{
	atomic_store(&prefetcher->told, time);
	if (time >= atomic_load(&prefetcher->look_at))
		wake(prefetcher);
}

void motion_prefetcher_wait(struct prefetcher *prefetcher)
{
	mutex_lock(&prefetcher->mutex);
	while (!prefetcher->asleep || prefetcher->range_next < prefetcher->range_count ||
	       atomic_load(&prefetcher->told) >= atomic_load(&prefetcher->look_at))
		condition_wait(&prefetcher->changed, &prefetcher->mutex);
	mutex_unlock(&prefetcher->mutex);
}
