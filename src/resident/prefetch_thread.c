/*
 * Loads base tiles before bodies or the camera need them. This is the work of one thread of a prefetcher, in looks.
 *
 * A look predicts which tiles will be needed. Walkers move along the paths of bodies and the way of the camera, one for each,
 * beginning at the present time. The walker with the earliest time moves next. At each of its places it adds the tiles around it
 * to the list. Where an inset lies, these are tiles of all its levels, the finest first, and the steps are as small as those tiles ask
 * for. The look ends at its time limit, or when the list or the number of places is full. Then the tiles of the list are
 * loaded, those needed soonest first. The next look begins when an eighth of the predicted time has passed.
 *
 * Invariants:
 * - Only the thread uses the walkers and the list. `told`, `look_at`, `reach`, `ranges_done` and `stopping` are atomic. The
 * mutex guards `asleep`, the ranges and `told_list`. Nothing else changes.
 * - It sleeps only while told < look_at and no range is left to load. It writes look_at and then reads told. The caller writes
 * told and then reads look_at, and wakes it with the mutex held. So one of the two sees the other's value.
 * - The lists of all threads together are shorter than the ground holds. Tiles of all lists that are already there are marked as used
 * before any is loaded. So none of them is evicted while the ground has a tile that no list has. For this each thread keeps a copy of its
 * last list, `told_list`, which the others read.
 * - The walkers form a heap: none is before its parent in time; at equal times the one with the lower number comes first.
 */
#include "resident/prefetch_thread.h"

#include "base/key_set.h"
#include <assert.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#define TILE_PARTS 16 /* a walker's places are a sixteenth of the finest tile's width apart */
#define PLACES_MAX 65536 /* most places in one look */
#define RANGES_ROOM 1024 /* most ranges that wait to be loaded */

struct walker {
	struct look_ahead_path path; /* `sample` is NULL: the camera's */
	const _Atomic bool *elsewhere; /* while it is true the walker does not move; NULL: it always does */
	int64_t past;              /* the last path sample whose time has passed */
	int64_t sample;            /* path sample where the walker is */
	double time;               /* of the walker, s; INFINITY: it is at the end of its path */
	int level;                 /* finest level that may have tiles on the way to the next place */
	int before;                /* the same, on the way from the last place */
};

struct prefetch_thread {
	struct look_ahead_params params;
	const struct extent *extent;
	struct store_reader *reader;
	const struct inset_areas *insets;
	struct prefetch_thread *const *all; /* all threads of the prefetcher */
	size_t all_count;
	struct walker *walkers;
	size_t walker_count;
	uint32_t *heap;       /* numbers of walkers */
	struct tile *list;    /* soonest needed first */
	uint32_t listed;
	struct key_set keys;  /* of the list's tiles; it has room for all */
	struct thread thread;
	struct mutex mutex;
	struct condition changed; /* the thread sleeps on it, and resident_prefetch_thread_wait waits on it */
	/* guarded by the mutex: */
	bool asleep;
	struct tile *told_list;
	uint32_t told_count;
	struct ground_range_key ranges[RANGES_ROOM];
	size_t range_next, range_count; /* index of the next range to load, and their number */
	_Atomic uint64_t ranges_done;
	/* s. told: the present time, from the caller. look_at: time at which the next look begins. reach: how far ahead a look goes */
	_Atomic double told, look_at, reach;
	atomic_bool stopping;
};

/* --- a look --- */

static bool add_tile(struct prefetch_thread *ahead, struct tile tile)
{
	if (key_set_has(&ahead->keys, tile_key(tile)))
		return true;
	if (ahead->listed == ahead->params.tiles)
		return false;
	key_set_put(&ahead->keys, tile_key(tile));
	ahead->list[ahead->listed++] = tile;
	return true;
}

/* Returns the distance between two places where tiles of `level` lie, in posts of level 0. */
static double step_of(const struct prefetch_thread *ahead, int level)
{
	return ldexp(ahead->extent->cells, level) / TILE_PARTS;
}

/* Adds the tiles of a level within `reach` of (px, py), in posts of level 0. Returns false if the list is full. */
static bool add_level(struct prefetch_thread *ahead, int level, double px, double py, double reach)
{
	const struct extent *extent = ahead->extent;
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
			if (resident_ground_stored(ahead->params.ground, ahead->reader, tile, &stored) == STATUS_OK && stored)
				room = room && add_tile(ahead, tile);
		}
	return room;
}

/* Adds the tiles within half the distance to the places before and after, so that successive places miss no tile. On a way where a level
 * may have no tiles none of them is looked for. Returns false if the list is full. */
static bool add_place(struct prefetch_thread *ahead, const struct walker *walker, double x, double y)
{
	bool room = true;
	/* The owner reads the finest level first. */
	for (int level = walker->level < walker->before ? walker->level : walker->before; level <= 0 && room; level++) {
		double after = walker->level <= level ? step_of(ahead, walker->level) : 0;
		double before = walker->before <= level ? step_of(ahead, walker->before) : 0;
		room = add_level(ahead, level, x / ahead->extent->spacing, y / ahead->extent->spacing, 0.5 * fmax(after, before));
	}
	return room;
}

static bool is_camera(const struct walker *walker)
{
	return walker->path.sample == NULL;
}

static double time_at(const struct walker *walker, int64_t index)
{
	return walker->path.time(walker->path.user, index);
}

/* Returns the points where a walker needs the ground: one of its path, at most two of the camera. */
static size_t places_of(const struct prefetch_thread *ahead, const struct walker *walker, double places[2][2])
{
	if (is_camera(walker))
		return ahead->params.camera(ahead->params.camera_user, walker->time, places);
	struct look_ahead_sample sample;
	walker->path.sample(walker->path.user, walker->sample, &sample);
	places[0][0] = sample.x;
	places[0][1] = sample.y;
	return 1;
}

static bool add_walker(struct prefetch_thread *ahead, const struct walker *walker)
{
	double places[2][2];
	size_t count = places_of(ahead, walker, places);
	bool room = true;
	for (size_t i = 0; i < count; i++)
		room = room && add_place(ahead, walker, places[i][0], places[i][1]);
	return room;
}

/* Finds out how large the walker's next step may be: a large one must not pass over an inset. */
static void look_around(const struct prefetch_thread *ahead, struct walker *walker)
{
	double places[2][2], spacing = ahead->extent->spacing;
	walker->before = walker->level;
	walker->level = 0;
	if (ahead->insets->count == 0)
		return;
	size_t count = places_of(ahead, walker, places);
	for (size_t i = 0; i < count; i++) {
		int level = resident_inset_areas_level(ahead->insets, places[i][0] / spacing, places[i][1] / spacing, step_of(ahead, 0));
		walker->level = level < walker->level ? level : walker->level;
	}
}

static int64_t next_sample(const struct prefetch_thread *ahead, const struct walker *walker)
{
	double stride = floor(step_of(ahead, walker->level) * ahead->extent->spacing / ahead->params.spacing);
	int64_t samples = stride > 1 ? (int64_t)stride : 1;
	const int64_t last = walker->path.samples - 1;
	return last - walker->sample > samples ? walker->sample + samples : last;
}

static void begin(struct prefetch_thread *ahead, struct walker *walker, double now)
{
	walker->time = now;
	walker->sample = walker->past;
	if (walker->elsewhere != NULL && atomic_load(walker->elsewhere)) {
		walker->time = INFINITY;
		return;
	}
	look_around(ahead, walker);
	walker->before = walker->level;
	if (is_camera(walker))
		return;
	for (int64_t next; (next = next_sample(ahead, walker)) != walker->sample && !atomic_load(&ahead->stopping);) {
		if (time_at(walker, next) > now)
			break;
		walker->sample = next;
		look_around(ahead, walker);
	}
	walker->past = walker->sample;
	walker->time = time_at(walker, walker->sample);
}

static void go_on(const struct prefetch_thread *ahead, struct walker *walker)
{
	const struct look_ahead_params *params = &ahead->params;
	if (is_camera(walker)) {
		double step = step_of(ahead, walker->level) * ahead->extent->spacing / params->camera_speed;
		walker->time += fmin(fmax(step, params->prefetch / 1024), params->prefetch / 16);
	} else {
		int64_t next = next_sample(ahead, walker);
		walker->time = next == walker->sample ? (double)INFINITY : time_at(walker, next);
		walker->sample = next;
	}
	if (walker->time < (double)INFINITY)
		look_around(ahead, walker);
}

static bool is_before(const struct prefetch_thread *ahead, uint32_t a, uint32_t b)
{
	const double first = ahead->walkers[a].time, second = ahead->walkers[b].time;
	return first != second ? first < second : a < b;
}

/* Moves the walker at this place of the heap down, until none below it is before it. */
static void sift(struct prefetch_thread *ahead, size_t place)
{
	const uint32_t walker = ahead->heap[place];
	for (size_t child; (child = 2 * place + 1) < ahead->walker_count; place = child) {
		if (child + 1 < ahead->walker_count && is_before(ahead, ahead->heap[child + 1], ahead->heap[child]))
			child++;
		if (!is_before(ahead, ahead->heap[child], walker))
			break;
		ahead->heap[place] = ahead->heap[child];
	}
	ahead->heap[place] = walker;
}

/* Lists the tiles that will be needed from `now` on, s. Returns the time until which the list has all of them. */
static double look(struct prefetch_thread *ahead, double now)
{
	double until = fmin(now + atomic_load(&ahead->reach), ahead->params.end);
	ahead->listed = 0;
	key_set_clear(&ahead->keys);
	for (size_t i = 0; i < ahead->walker_count; i++)
		begin(ahead, &ahead->walkers[i], now);
	for (size_t i = ahead->walker_count / 2; i-- > 0;)
		sift(ahead, i);
	for (uint32_t places = 0;; places++) {
		struct walker *soonest = &ahead->walkers[ahead->heap[0]];
		if (soonest->time > until)
			return soonest->time < (double)INFINITY ? until : (double)INFINITY;
		if (places == PLACES_MAX || !add_walker(ahead, soonest))
			return soonest->time;
		go_on(ahead, soonest);
		sift(ahead, 0);
	}
}

/* Loads the next range. Returns false if none is left. */
static bool bring_range(struct prefetch_thread *ahead)
{
	struct ground_range_key key;
	mutex_lock(&ahead->mutex);
	bool any = ahead->range_next < ahead->range_count;
	if (any)
		key = ahead->ranges[ahead->range_next++];
	mutex_unlock(&ahead->mutex);
	if (!any)
		return false;
	/* On failure the range stays missing. The ground's owner will read it again and report the failure. */
	enum status status = resident_ground_warm_range(ahead->params.ground, ahead->reader, &key);
	(void)status;
	atomic_fetch_add(&ahead->ranges_done, 1);
	return true;
}

/* Copies the list for other threads. */
static void tell_list(struct prefetch_thread *ahead)
{
	mutex_lock(&ahead->mutex);
	ahead->told_count = ahead->listed;
	memcpy(ahead->told_list, ahead->list, ahead->listed * sizeof *ahead->list);
	mutex_unlock(&ahead->mutex);
}

/* Marks the tiles of the thread's last list as used, those needed soonest last. */
static void touch_list(struct prefetch_thread *ahead)
{
	mutex_lock(&ahead->mutex);
	for (uint32_t i = ahead->told_count; i-- > 0;)
		resident_ground_touch(ahead->params.ground, ahead->told_list[i]);
	mutex_unlock(&ahead->mutex);
}

/* Loads the tiles of the list into the ground. If a tile cannot be read, it stays missing, and the ground's owner will report it. */
static void bring(struct prefetch_thread *ahead)
{
	tell_list(ahead);
	for (size_t k = 0; k < ahead->all_count; k++)
		if (ahead->all[k] != ahead)
			touch_list(ahead->all[k]);
	touch_list(ahead);
	for (uint32_t i = 0; i < ahead->listed && !atomic_load(&ahead->stopping); i++) {
		enum status status = resident_ground_warm(ahead->params.ground, ahead->reader, ahead->list[i]);
		(void)status;
		bring_range(ahead);
	}
}

static void *body(void *argument)
{
	struct prefetch_thread *ahead = argument;
	thread_background();
	while (!atomic_load(&ahead->stopping)) {
		double now = atomic_load(&ahead->told), until = look(ahead, now);
		bring(ahead);
		double next = fmax(now + (until - now) / 8, nextafter(now, INFINITY));
		mutex_lock(&ahead->mutex);
		atomic_store(&ahead->look_at, until < ahead->params.end ? next : (double)INFINITY);
		while (atomic_load(&ahead->told) < atomic_load(&ahead->look_at) && !atomic_load(&ahead->stopping)) {
			if (ahead->range_next < ahead->range_count) {
				mutex_unlock(&ahead->mutex);
				bring_range(ahead);
				mutex_lock(&ahead->mutex);
				continue;
			}
			ahead->asleep = true;
			condition_wake_all(&ahead->changed);
			condition_wait(&ahead->changed, &ahead->mutex);
			ahead->asleep = false;
		}
		atomic_store(&ahead->look_at, (double)INFINITY); /* it is awake, so no caller needs to wake it */
		mutex_unlock(&ahead->mutex);
	}
	return NULL;
}

/* --- life --- */

static void wake(struct prefetch_thread *ahead)
{
	mutex_lock(&ahead->mutex);
	condition_wake_all(&ahead->changed);
	mutex_unlock(&ahead->mutex);
}

static void mount_walkers(struct prefetch_thread *ahead)
{
	const struct look_ahead_params *params = &ahead->params;
	ahead->walker_count = params->count + (params->camera != NULL);
	for (size_t i = 0; i < params->count; i++)
		ahead->walkers[i] = (struct walker){.path = params->bodies[i].path, .elsewhere = params->bodies[i].elsewhere};
	for (size_t i = 0; i < ahead->walker_count; i++)
		ahead->heap[i] = (uint32_t)i;
	ahead->params.bodies = NULL; /* the caller's */
}

enum status resident_prefetch_thread_create(const struct look_ahead_params *params, const struct inset_areas *insets, struct prefetch_thread **out)
{
	assert(params->count >= 1 && params->prefetch > 0);
	struct prefetch_thread *ahead = mem_calloc(1, sizeof *ahead);
	TRY_MEM(ahead, "the prefetcher");
	ahead->params = *params;
	ahead->insets = insets;
	ahead->extent = &store_meta(params->store)->extent;
	mutex_init(&ahead->mutex);
	condition_init(&ahead->changed);
	atomic_init(&ahead->told, 0);
	atomic_init(&ahead->reach, params->prefetch);
	atomic_init(&ahead->look_at, (double)INFINITY);
	atomic_init(&ahead->stopping, false);
	atomic_init(&ahead->ranges_done, 0);
	ahead->walkers = mem_calloc(params->count + 1, sizeof *ahead->walkers);
	ahead->heap = mem_calloc(params->count + 1, sizeof *ahead->heap);
	ahead->list = mem_alloc(params->tiles, sizeof *ahead->list);
	ahead->told_list = mem_alloc(params->tiles, sizeof *ahead->told_list);
	const bool made = ahead->walkers != NULL && ahead->heap != NULL && ahead->list != NULL && ahead->told_list != NULL;
	enum status status;
	TRY_OR(failed, made ? STATUS_OK : fail_memory("the prefetcher"));
	TRY_OR(failed, key_set_reserve(&ahead->keys, params->tiles));
	mount_walkers(ahead);
	TRY_OR(failed, store_reader_create(params->store, &ahead->reader));
	*out = ahead;
	return STATUS_OK;
failed:
	resident_prefetch_thread_destroy(ahead);
	return status;
}

enum status resident_prefetch_thread_start(struct prefetch_thread *ahead, struct prefetch_thread *const *all, size_t count)
{
	ahead->all = all;
	ahead->all_count = count;
	return thread_start(&ahead->thread, body, ahead, PREFETCH_THREAD);
}

void resident_prefetch_thread_stop(struct prefetch_thread *ahead)
{
	atomic_store(&ahead->stopping, true);
	wake(ahead);
	thread_join(&ahead->thread);
}

void resident_prefetch_thread_destroy(struct prefetch_thread *ahead)
{
	if (ahead == NULL)
		return;
	store_reader_destroy(ahead->reader);
	mem_free_all(ahead->list, ahead->told_list, ahead->walkers);
	key_set_finish(&ahead->keys);
	mem_free(ahead->heap);
	condition_finish(&ahead->changed);
	mutex_finish(&ahead->mutex);
	mem_free(ahead);
}

void resident_prefetch_thread_reach(struct prefetch_thread *ahead, double seconds)
{
	atomic_store(&ahead->reach, seconds);
}

void resident_prefetch_thread_ranges(struct prefetch_thread *ahead, const struct ground_range_key *keys, size_t count)
{
	mutex_lock(&ahead->mutex);
	ahead->range_next = 0;
	ahead->range_count = count < RANGES_ROOM ? count : RANGES_ROOM;
	memcpy(ahead->ranges, keys, ahead->range_count * sizeof *keys);
	condition_wake_all(&ahead->changed);
	mutex_unlock(&ahead->mutex);
}

uint64_t resident_prefetch_thread_ranges_done(struct prefetch_thread *ahead)
{
	return atomic_load(&ahead->ranges_done);
}

void resident_prefetch_thread_tell(struct prefetch_thread *ahead, double time)
{
	atomic_store(&ahead->told, time);
	if (time >= atomic_load(&ahead->look_at))
		wake(ahead);
}

void resident_prefetch_thread_wait(struct prefetch_thread *ahead)
{
	mutex_lock(&ahead->mutex);
	while (!ahead->asleep || ahead->range_next < ahead->range_count ||
	       atomic_load(&ahead->told) >= atomic_load(&ahead->look_at))
		condition_wait(&ahead->changed, &ahead->mutex);
	mutex_unlock(&ahead->mutex);
}
