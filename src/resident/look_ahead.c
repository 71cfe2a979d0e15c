/*
 * The look-ahead loads three things: pages that paths will touch within `prefetch` seconds, pages that pictures lack, and base
 * tiles for bodies (prefetcher.c).
 *
 * Each body has a watch that goes along its path before it, sample by sample. The watch notes the tiles of the windows that the
 * body will have there, and from when until when each tile is needed. A tile stays noted until the body has left it. A world
 * that runs faster than real time looks ahead by the same factor farther. So loads have `prefetch` seconds by the clock too.
 *
 * Invariants:
 * - A body's tiles are in the order in which they are first needed.
 * - What is loaded ahead never decides a result, only how long a step waits.
 */
#include <math.h>
#include <time.h>

#include "deform/deform.h"
#include "resident/prefetcher.h"

#define RECENT 16 /* tiles searched for one that is still in use */

struct ahead_tile {
	uint64_t key;
	double from, until; /* simulated seconds */
};

struct watch {
	struct look_ahead_body body;
	int64_t sample; /* the next it goes to */
	struct soil_pose last;
	struct ahead_tile *tiles;
	size_t count, room;
	bool away;                     /* the body was elsewhere in the last step */
};

struct look_ahead {
	struct look_ahead_params params;
	struct look_ahead_pages pages;
	struct prefetcher *prefetcher; /* NULL: nothing is prefetched, or no body has a path */
	struct watch *watches;         /* params.count */
	struct requests requests;
	const uint64_t *keys;          /* of the requests, in order */
	size_t key_count;
	size_t passed;                 /* tiles forgotten since they were sorted */
	double began;                  /* s, by the clock: the first step; 0: not yet */
	double began_time;             /* s, simulated */
};

enum status resident_look_ahead_create(const struct look_ahead_params *params, struct look_ahead **out)
{
	struct look_ahead *ahead = mem_calloc(1, sizeof *ahead);
	TRY_MEM(ahead, "the look-ahead");
	ahead->params = *params;
	ahead->watches = mem_calloc(params->count, sizeof *ahead->watches);
	ahead->params.bodies = NULL; /* the caller's */
	enum status status;
	TRY_OR(failed, ahead->watches != NULL || params->count == 0 ? STATUS_OK : fail_memory("the look-ahead"));
	for (size_t i = 0; i < params->count; i++)
		ahead->watches[i] = (struct watch){.body = params->bodies[i], .sample = params->bodies[i].next};
	if (params->prefetch > 0 && params->count > 0)
		TRY_OR(failed, resident_prefetcher_create(params, &ahead->prefetcher));
	*out = ahead;
	return STATUS_OK;
failed:
	resident_look_ahead_destroy(ahead);
	return status;
}

void resident_look_ahead_stop(struct look_ahead *ahead)
{
	if (ahead == NULL)
		return;
	resident_prefetcher_destroy(ahead->prefetcher);
	ahead->prefetcher = NULL;
}

void resident_look_ahead_destroy(struct look_ahead *ahead)
{
	if (ahead == NULL)
		return;
	resident_look_ahead_stop(ahead);
	for (size_t i = 0; ahead->watches != NULL && i < ahead->params.count; i++)
		mem_free(ahead->watches[i].tiles);
	mem_free(ahead->watches);
	resident_requests_finish(&ahead->requests);
	mem_free(ahead);
}

void resident_look_ahead_serve(struct look_ahead *ahead, const struct look_ahead_pages *pages)
{
	ahead->pages = *pages;
}

void resident_look_ahead_begin(struct look_ahead *ahead, double time)
{
	ahead->began = clock_seconds();
	ahead->began_time = time;
}

void resident_look_ahead_rewind(struct look_ahead *ahead, const int64_t *next, double time)
{
	for (size_t i = 0; i < ahead->params.count; i++) {
		ahead->watches[i].count = 0;
		ahead->watches[i].sample = next[i];
	}
	ahead->keys = NULL;
	ahead->key_count = ahead->passed = 0;
	resident_look_ahead_begin(ahead, time);
	resident_look_ahead_tell(ahead, time);
}

const struct requests *resident_look_ahead_requests(const struct look_ahead *ahead)
{
	static const struct requests none;
	return ahead != NULL ? &ahead->requests : &none;
}

bool resident_look_ahead_brings_ranges(const struct look_ahead *ahead)
{
	return ahead != NULL && ahead->prefetcher != NULL;
}

void resident_look_ahead_ranges(struct look_ahead *ahead, const struct ground_range_key *keys, size_t count)
{
	if (ahead->prefetcher != NULL)
		resident_prefetcher_ranges(ahead->prefetcher, keys, count);
}

uint64_t resident_look_ahead_ranges_done(const struct look_ahead *ahead)
{
	return resident_look_ahead_brings_ranges(ahead) ? resident_prefetcher_ranges_done(ahead->prefetcher) : 0;
}

void resident_look_ahead_tell(struct look_ahead *ahead, double time)
{
	if (ahead->prefetcher != NULL)
		resident_prefetcher_tell(ahead->prefetcher, time);
}

/* --- along a path --- */

static enum status note_tile(struct watch *watch, uint64_t key, double time)
{
	for (size_t i = watch->count; i > 0 && i + RECENT > watch->count; i--)
		if (watch->tiles[i - 1].key == key) {
			watch->tiles[i - 1].until = time;
			return STATUS_OK;
		}
	TRY(mem_grow(&watch->tiles, &watch->room, watch->count + 1, sizeof *watch->tiles, "loading ahead"));
	watch->tiles[watch->count++] = (struct ahead_tile){key, time, time};
	return STATUS_OK;
}

static enum status note_sample(const struct look_ahead *ahead, struct watch *watch)
{
	const struct look_ahead_pages *pages = &ahead->pages;
	struct look_ahead_sample sample;
	watch->body.path.sample(watch->body.path.user, watch->sample, &sample);
	struct deform_contact contact = {.shape = watch->body.shape, .from = watch->last, .to = sample.pose};
	if (watch->sample == 0 || watch->count == 0)
		contact.from = contact.to;
	watch->last = contact.to;
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count = 0;
	TRY(deform_cut(pages->surface, &contact, windows, &count));
	for (size_t i = 0; i < count; i++) {
		struct tile first, last;
		if (!tile_range_of(pages->extent, pages->level, windows[i].read, &first, &last))
			continue;
		for (uint32_t y = first.y; y <= last.y; y++)
			for (uint32_t x = first.x; x <= last.x; x++)
				TRY(note_tile(watch, tile_key((struct tile){pages->level, x, y}), sample.time));
	}
	return STATUS_OK;
}

/* Forgets the tiles that the object has left; returns how many. */
static size_t forget_passed(struct watch *watch, double now)
{
	size_t kept = 0, count = watch->count;
	if (count == 0 || watch->tiles[0].until >= now)
		return 0;
	for (size_t i = 0; i < count; i++)
		if (watch->tiles[i].until >= now)
			watch->tiles[kept++] = watch->tiles[i];
	watch->count = kept;
	return count - kept;
}

double resident_look_ahead_reach(const struct look_ahead *ahead, double time)
{
	const double settled = 0.05; /* s: before this the pace is not known well */
	if (ahead->began <= 0)
		return ahead->params.prefetch;
	double pace = (time - ahead->began_time) / fmax(clock_seconds() - ahead->began, settled);
	return ahead->params.prefetch * fmax(pace, 1);
}

/* Goes on along the path until then, and stops when `most` tiles are noted. Sets *news if one is new. */
static enum status go_on(const struct look_ahead *ahead, struct watch *watch, double until, size_t most, bool *news)
{
	const struct look_ahead_path *path = &watch->body.path;
	const size_t before = watch->count;
	while (watch->count < most && watch->sample < path->samples && path->time(path->user, watch->sample) <= until) {
		TRY(note_sample(ahead, watch));
		watch->sample++;
	}
	*news |= watch->count != before;
	return STATUS_OK;
}

/* Goes to the first path sample that is not made yet. */
static void come_back(struct watch *watch, double time)
{
	const struct look_ahead_path *path = &watch->body.path;
	while (watch->sample < path->samples && path->time(path->user, watch->sample) <= time)
		watch->sample++;
	watch->away = false;
}

/* `*changed`: there are new tiles, or enough were left behind. */
static enum status look(struct look_ahead *ahead, double time, bool *changed)
{
	double far = resident_look_ahead_reach(ahead, time), until = fmin(time + far, ahead->params.end);
	if (ahead->prefetcher != NULL)
		resident_prefetcher_reach(ahead->prefetcher, far);
	for (size_t i = 0; i < ahead->params.count; i++) {
		struct watch *watch = &ahead->watches[i];
		if (watch->body.elsewhere != NULL && *watch->body.elsewhere) {
			*changed |= watch->count > 0;
			watch->count = 0;
			watch->away = true;
			continue;
		}
		if (watch->away)
			come_back(watch, time);
		TRY(go_on(ahead, watch, time, SIZE_MAX, changed));
		ahead->passed += forget_passed(watch, time);
		/* Never loads ahead more than there are slots, however far it looks. */
		TRY(go_on(ahead, watch, until, ahead->pages.slots, changed));
	}
	*changed |= ahead->passed * 8 > ahead->key_count;
	return STATUS_OK;
}

/* --- requests --- */

static enum status gather(struct look_ahead *ahead)
{
	/* After a failure there are no keys, and the next step gathers again. */
	ahead->keys = NULL;
	ahead->key_count = ahead->passed = 0;
	resident_requests_clear(&ahead->requests);
	for (size_t i = 0; i < ahead->params.count; i++) {
		const struct watch *watch = &ahead->watches[i];
		for (size_t k = 0; k < watch->count; k++)
			TRY(resident_requests_add(&ahead->requests, watch->tiles[k].key, watch->tiles[k].from));
	}
	if (ahead->pages.requests != NULL)
		TRY(ahead->pages.requests(ahead->pages.user, &ahead->requests));
	ahead->key_count = resident_requests_order(&ahead->requests, &ahead->keys);
	return STATUS_OK;
}

enum status resident_look_ahead_step(struct look_ahead *ahead, double time)
{
	bool asked = ahead->pages.requests != NULL, changed = asked || ahead->keys == NULL;
	if (ahead->params.prefetch <= 0 && !asked)
		return STATUS_OK; /* nobody requests anything */
	if (ahead->params.prefetch > 0)
		TRY(look(ahead, time, &changed));
	if (changed)
		TRY(gather(ahead));
	if (changed || page_cache_request_state(ahead->pages.cache) != PAGE_REQUESTS_HERE)
		page_cache_want(ahead->pages.cache, ahead->keys, ahead->key_count);
	return STATUS_OK;
}

enum status resident_look_ahead_first(struct look_ahead *ahead, double time, const volatile sig_atomic_t *stop)
{
	const struct timespec nap = {0, 50000};
	TRY(resident_look_ahead_step(ahead, time));
	while (page_cache_request_state(ahead->pages.cache) == PAGE_REQUESTS_COMING && (stop == NULL || !*stop)) {
		nanosleep(&nap, NULL);
		TRY(page_cache_poll(ahead->pages.cache));
	}
	if (ahead->prefetcher != NULL) {
		resident_prefetcher_tell(ahead->prefetcher, time);
		resident_prefetcher_wait(ahead->prefetcher);
	}
	return STATUS_OK;
}
