/*
 * A look: walkers, one a track and one for the camera, go on from the present in turn, whoever is soonest, and list
 * the tiles around where they stand until the time, the list or the number of places is used up. Then the tiles of
 * the list are brought, soonest first. It looks again when an eighth of what it saw has passed.
 *
 * Invariants:
 * 1. The walkers and the list are the thread's own; `told`, `look_at`, `reach` and `stopping` are atomic; but for
 *    `asleep` the rest does not change.
 * 2. It sleeps only while told < look_at. It writes look_at and then reads told, who tells writes told and then
 *    reads look_at, and wakes it with the mutex held: one of the two sees the other.
 * 3. The list is shorter than the ground holds, and what is there of it is marked as used before anything is
 *    brought: nothing of it is evicted while there is something else that the owner did not use since.
 */
#include "run/scout.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>

#define SCOUT_THREAD "furrow-scout"
#define TILE_PARTS 16 /* places a tile's width */
#define PLACES_MAX 65536 /* in one look */

struct walker {
	const struct track *track; /* NULL: the camera's */
	int64_t past;              /* the last of its stations that is not ahead */
	int64_t station, last;
	int64_t stride;            /* stations from place to place */
	double time;               /* of `station`, or the camera's; INFINITY: at the end */
};

struct scout {
	struct scout_params params;
	const struct world *world;
	struct store_reader *reader;
	struct walker *walkers;
	size_t walker_count;
	double camera_stride; /* s */
	struct tile *list;    /* soonest needed first */
	uint32_t listed;
	struct thread thread;
	struct mutex mutex;
	struct condition changed; /* of what the sleeping and the waiting go by */
	bool asleep;              /* guarded by the mutex */
	_Atomic double told, look_at, reach; /* s; reach: how far ahead */
	atomic_bool stopping;
};

/* --- a look --- */

static bool add_tile(struct scout *scout, struct tile tile)
{
	for (uint32_t i = scout->listed; i-- > 0;)
		if (tile_equal(scout->list[i], tile))
			return true;
	if (scout->listed == scout->params.tiles)
		return false;
	scout->list[scout->listed++] = tile;
	return true;
}

/* Every tile between here and half-way to the neighbouring places; false if the list is full. */
static bool add_place(struct scout *scout, double x, double y)
{
	const struct world *world = scout->world;
	double reach = 0.5 * world->cells / TILE_PARTS, px = x / world->spacing, py = y / world->spacing;
	double x0 = fmax(px - reach, 0), x1 = fmin(px + reach, (double)(world->width - 1));
	double y0 = fmax(py - reach, 0), y1 = fmin(py + reach, (double)(world->height - 1));
	if (x0 > x1 || y0 > y1)
		return true; /* outside */
	struct tile first = ground_tile(world, x0, y0), last = ground_tile(world, x1, y1);
	bool room = true;
	for (uint32_t ty = first.y; ty <= last.y; ty++)
		for (uint32_t tx = first.x; tx <= last.x; tx++)
			room = room && add_tile(scout, (struct tile){0, tx, ty});
	return room;
}

static bool add_walker(struct scout *scout, const struct walker *walker)
{
	if (walker->track != NULL) {
		struct track_point point;
		track_station(walker->track, walker->station, &point);
		return add_place(scout, point.x, point.y);
	}
	double places[2][2];
	size_t count = scout->params.camera(scout->params.user, walker->time, places);
	bool room = true;
	for (size_t i = 0; i < count; i++)
		room = room && add_place(scout, places[i][0], places[i][1]);
	return room;
}

static int64_t next_station(const struct walker *walker, int64_t from)
{
	return walker->last - from > walker->stride ? from + walker->stride : walker->last;
}

static void begin(struct scout *scout, struct walker *walker, double now)
{
	if (walker->track == NULL) {
		walker->time = now;
		return;
	}
	for (int64_t next; (next = next_station(walker, walker->past)) != walker->past; walker->past = next)
		if (track_station_time(walker->track, next) > now || atomic_load(&scout->stopping))
			break;
	walker->station = walker->past;
	walker->time = track_station_time(walker->track, walker->station);
}

static void go_on(const struct scout *scout, struct walker *walker)
{
	if (walker->track == NULL) {
		walker->time += scout->camera_stride;
		return;
	}
	int64_t next = next_station(walker, walker->station);
	walker->time = next == walker->station ? INFINITY : track_station_time(walker->track, next);
	walker->station = next;
}

/* Lists what is needed from `now` on; returns until when that is all. */
static double look(struct scout *scout, double now)
{
	double until = fmin(now + atomic_load(&scout->reach), scout->params.end);
	scout->listed = 0;
	for (size_t i = 0; i < scout->walker_count; i++)
		begin(scout, &scout->walkers[i], now);
	for (uint32_t places = 0;; places++) {
		struct walker *soonest = &scout->walkers[0];
		for (size_t i = 1; i < scout->walker_count; i++)
			if (scout->walkers[i].time < soonest->time)
				soonest = &scout->walkers[i];
		if (soonest->time > until)
			return soonest->time < (double)INFINITY ? until : (double)INFINITY;
		if (places == PLACES_MAX || !add_walker(scout, soonest))
			return soonest->time;
		go_on(scout, soonest);
	}
}

/* The list's tiles into the ground; what cannot be read is left to its owner, who must tell of it. */
static void bring(struct scout *scout)
{
	for (uint32_t i = scout->listed; i-- > 0;)
		ground_touch(scout->params.ground, scout->list[i]);
	for (uint32_t i = 0; i < scout->listed && !atomic_load(&scout->stopping); i++) {
		enum status status = ground_warm(scout->params.ground, scout->reader, scout->list[i]);
		(void)status;
	}
}

static void *body(void *argument)
{
	struct scout *scout = argument;
	thread_background();
	while (!atomic_load(&scout->stopping)) {
		double now = atomic_load(&scout->told), until = look(scout, now);
		bring(scout);
		double ahead = fmax(now + (until - now) / 8, nextafter(now, INFINITY));
		mutex_lock(&scout->mutex);
		atomic_store(&scout->look_at, until < scout->params.end ? ahead : (double)INFINITY);
		while (atomic_load(&scout->told) < atomic_load(&scout->look_at) && !atomic_load(&scout->stopping)) {
			scout->asleep = true;
			condition_wake_all(&scout->changed);
			condition_wait(&scout->changed, &scout->mutex);
		}
		scout->asleep = false;
		atomic_store(&scout->look_at, (double)INFINITY); /* nobody need wake it now */
		mutex_unlock(&scout->mutex);
	}
	return NULL;
}

/* --- life --- */

static void mount_walkers(struct scout *scout)
{
	const struct scout_params *params = &scout->params;
	double side = scout->world->cells * scout->world->spacing;
	scout->walker_count = params->count + (params->camera != NULL);
	for (size_t i = 0; i < params->count; i++) {
		const struct track *track = params->tracks[i];
		double stride = floor(side / TILE_PARTS / params->post);
		scout->walkers[i] = (struct walker){
			.track = track,
			.last = track_stations(track) - 1,
			.stride = stride > 1 ? (int64_t)stride : 1,
		};
	}
	scout->camera_stride =
		fmin(fmax(side / TILE_PARTS / params->camera_speed, params->prefetch / 1024), params->prefetch / 16);
}

void scout_plan(double prefetch, size_t count, struct plan *plan)
{
	if (prefetch > 0 && count > 0)
		plan_add(plan, &(struct plan_line){.kind = PLAN_THREAD, .effect = scene_effect_row(EFFECT_PREFETCH)->name,
						   .object = -1, .amount = 1}, SCOUT_THREAD);
}

enum status scout_create(const struct scout_params *params, struct scout **out)
{
	assert(params->count >= 1 && params->prefetch > 0);
	struct scout *scout = mem_calloc(1, sizeof *scout);
	if (scout == NULL)
		return fail_memory("the scout");
	scout->params = *params;
	scout->world = &store_meta(params->store)->world;
	mutex_init(&scout->mutex);
	condition_init(&scout->changed);
	atomic_init(&scout->told, 0);
	atomic_init(&scout->reach, params->prefetch);
	atomic_init(&scout->look_at, (double)INFINITY);
	atomic_init(&scout->stopping, false);
	scout->walkers = mem_calloc(params->count + 1, sizeof *scout->walkers);
	scout->list = mem_alloc(params->tiles, sizeof *scout->list);
	enum status status = scout->walkers != NULL && scout->list != NULL ? STATUS_OK : fail_memory("the scout");
	if (status == STATUS_OK)
		mount_walkers(scout);
	if (status == STATUS_OK)
		status = store_reader_create(params->store, &scout->reader);
	if (status == STATUS_OK)
		status = thread_start(&scout->thread, body, scout, SCOUT_THREAD);
	if (status != STATUS_OK) {
		scout_destroy(scout);
		return status;
	}
	*out = scout;
	return STATUS_OK;
}

static void wake(struct scout *scout)
{
	mutex_lock(&scout->mutex);
	condition_wake_all(&scout->changed);
	mutex_unlock(&scout->mutex);
}

void scout_destroy(struct scout *scout)
{
	if (scout == NULL)
		return;
	atomic_store(&scout->stopping, true);
	wake(scout);
	thread_join(&scout->thread);
	store_reader_destroy(scout->reader);
	mem_free(scout->list);
	mem_free(scout->walkers);
	condition_finish(&scout->changed);
	mutex_finish(&scout->mutex);
	mem_free(scout);
}

void scout_reach(struct scout *scout, double seconds)
{
	atomic_store(&scout->reach, seconds);
}

void scout_tell(struct scout *scout, double time)
{
	atomic_store(&scout->told, time);
	if (time >= atomic_load(&scout->look_at))
		wake(scout);
}

void scout_wait(struct scout *scout)
{
	mutex_lock(&scout->mutex);
	while (!scout->asleep || atomic_load(&scout->told) >= atomic_load(&scout->look_at))
		condition_wait(&scout->changed, &scout->mutex);
	mutex_unlock(&scout->mutex);
}
