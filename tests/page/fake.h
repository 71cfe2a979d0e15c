/*
 * A fake store, io and executor for the page cache, with gates to hold its threads at.
 *
 * A page is a key and a version; the store has the committed version of each key, a slot has what
 * was uploaded or changed there, `model` has the newest. A coarse page (COARSE + i) shows the
 * versions of the FAMILY fine pages below it, as a coarser level shows the finer one: its load
 * takes them from the store, its upload overlays what is queued, then what is dirty in a slot.
 *
 * The executor is as late as `settle_after` says: until an image was asked about that often, a
 * read-back has only rubbish in it, and an upload's must not have changed.
 *
 * The fake has its own mutex. `model`, `pins` and the log belong to the owner thread.
 */
#ifndef FURROW_TESTS_PAGE_FAKE_H
#define FURROW_TESTS_PAGE_FAKE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>
#include <sched.h>

#include "page/page.h"

enum { FINE = 128, FAMILY = 4, COARSE = 1000, SLOTS_MOST = 128, LOG_MOST = 4096 };

struct content {
	uint64_t key, version;
	uint64_t family[FAMILY];
};

/* What the executor has begun with an image. */
struct fake_memory {
	enum page_image_kind kind;
	unsigned asks; /* until it is settled */
	bool busy, filling;
	struct content content; /* what the image will have, or must still have */
};

struct fake {
	struct mutex mutex;
	struct condition changed;
	uint64_t store[FINE];
	uint64_t record;  /* of the last commit */
	bool hold_commits;
	bool gives_up; /* a commit that is held ends when a rollback waits for it */
	uint64_t hold_load; /* key + 1 whose load waits; UINT64_MAX: every one */
	uint64_t fail_load;  /* key + 1 */
	uint64_t fail_loads; /* bit key % 64: loads of all such keys fail */
	unsigned fail_commits, loads_begun, commits_begun, yields;
	uint64_t loaded[LOG_MOST]; /* keys, in the order their loads began */
	const uint64_t (*snapshots)[FINE]; /* by record: what a commit must make of the store */
	bool commit_differs, queued_differs; /* what was handed over is not what it should be */

	pthread_t owner;
	struct page_cache *cache;
	uint64_t model[FINE];
	struct content slots[SLOTS_MOST];
	unsigned pins[SLOTS_MOST];
	uint64_t fail_upload;                 /* key + 1 */
	uint64_t fail_read_back;              /* key + 1; UINT64_MAX: every one */
	unsigned settle_after;                /* asks; 0: settled when begun */
	bool fail_settle, fail_snapshot;
	bool ends;                            /* the cache is being destroyed */
	unsigned images[PAGE_IMAGE_KINDS];    /* alive, by kind */
	uint64_t uploaded[LOG_MOST], read_back[LOG_MOST];
	unsigned uploads, read_backs;
};

/* --- io --- */

static inline enum status fake_load(void *user, unsigned loader, struct page_image *image,
				    const struct page_image *queued)
{
	struct fake *fake = user;
	struct content content = {.key = image->key};
	(void)loader;
	mutex_lock(&fake->mutex);
	fake->loaded[fake->loads_begun++ % LOG_MOST] = image->key;
	if (image->key < FINE)
		content.version = fake->store[image->key];
	else
		for (unsigned i = 0; i < FAMILY; i++)
			content.family[i] = fake->store[(image->key - COARSE) * FAMILY + i];
	condition_wake_all(&fake->changed);
	while (fake->hold_load == image->key + 1 || fake->hold_load == UINT64_MAX)
		condition_wait(&fake->changed, &fake->mutex);
	bool failing = fake->fail_load == image->key + 1 || (fake->fail_loads >> image->key % 64 & 1) != 0;
	fake->queued_differs |= queued != NULL && queued->key != image->key;
	unsigned yields = fake->yields != 0 ? fake->loads_begun % fake->yields : 0;
	mutex_unlock(&fake->mutex);
	while (yields-- > 0)
		sched_yield();
	if (failing)
		return fail_with(STATUS_INPUT, "tile %d: checksum; run furrow verify",
				 (int)image->key);
	if (queued != NULL)
		memcpy(&content, queued->bytes, sizeof content);
	memcpy(image->bytes, &content, sizeof content);
	image->flags = 7;
	image->overlays = image->key >= COARSE;
	return STATUS_OK;
}

static inline uint64_t fake_sum(const uint64_t versions[FINE])
{
	uint64_t sum = 0;
	for (unsigned key = 0; key < FINE; key++)
		sum += versions[key];
	return sum;
}

static inline enum status fake_commit(void *user, const struct page_image *const *images,
				      size_t count, const void *record, const struct page_image *snapshot)
{
	struct fake *fake = user;
	enum status status = STATUS_OK;
	mutex_lock(&fake->mutex);
	fake->commits_begun++;
	condition_wake_all(&fake->changed);
	while (fake->gives_up && fake->hold_commits && !page_cache_gives_up(fake->cache)) {
		mutex_unlock(&fake->mutex);
		nanosleep(&(struct timespec){0, 500000}, NULL);
		mutex_lock(&fake->mutex);
	}
	if (fake->gives_up && fake->hold_commits) {
		status = fail_with(STATUS_INTERRUPTED, "store: given up; commit again");
		goto unlock;
	}
	while (fake->hold_commits)
		condition_wait(&fake->changed, &fake->mutex);
	if (fake->fail_commits > 0) {
		fake->fail_commits--;
		status = fail_with(STATUS_FAILED, "store: disk is full; free some space");
		goto unlock;
	}
	for (size_t i = 0; i < count; i++) {
		const struct content *content = images[i]->bytes;
		fake->commit_differs |= content->key != images[i]->key ||
					content->version < fake->store[content->key];
		fake->store[content->key] = content->version;
	}
	memcpy(&fake->record, record, sizeof fake->record);
	if (snapshot != NULL)
		fake->commit_differs |= ((const struct content *)snapshot->bytes)->version != fake_sum(fake->store);
	if (fake->snapshots != NULL)
		fake->commit_differs |= memcmp(fake->store, fake->snapshots[fake->record],
					       sizeof fake->store) != 0;
unlock:
	mutex_unlock(&fake->mutex);
	return status;
}

/* --- executor --- */

struct fake_overlay {
	struct fake *fake;
	struct content *coarse;
};

static inline void fake_overlay_one(struct content *coarse, uint64_t key, uint64_t version)
{
	if (key < FINE && key / FAMILY == coarse->key - COARSE)
		coarse->family[key % FAMILY] = version;
}

static inline void fake_overlay_queued(void *user, const struct page_image *image)
{
	const struct fake_overlay *overlay = user;
	const struct content *content = image->bytes;
	fake_overlay_one(overlay->coarse, content->key, content->version);
}

static inline void fake_overlay_resident(void *user, uint64_t key, uint32_t slot, bool dirty)
{
	const struct fake_overlay *overlay = user;
	if (dirty)
		fake_overlay_one(overlay->coarse, key, overlay->fake->slots[slot].version);
}

static inline enum status fake_create(void *user, enum page_image_kind kind, struct page_image *image)
{
	struct fake *fake = user;
	struct fake_memory *memory = mem_calloc(1, sizeof *memory);
	image->bytes = mem_calloc(1, sizeof(struct content));
	if (memory == NULL || image->bytes == NULL) {
		mem_free(memory);
		mem_free(image->bytes);
		return fail_memory("an image");
	}
	memory->kind = kind;
	image->memory = memory;
	fake->images[kind]++;
	return STATUS_OK;
}

static inline void fake_destroy(void *user, struct page_image *image)
{
	struct fake *fake = user;
	struct fake_memory *memory = image->memory;
	fake->images[memory->kind]--;
	mem_free(image->bytes);
	mem_free(memory);
}

static inline void fake_begin(struct fake *fake, struct page_image *image, const struct content *content,
			      bool filling)
{
	struct fake_memory *memory = image->memory;
	assert_false(memory->busy);
	*memory = (struct fake_memory){memory->kind, fake->settle_after, true, filling, *content};
	if (filling)
		memset(image->bytes, 0xee, sizeof *content);
}

static inline enum status fake_settled(void *user, const struct page_image *image, bool *settled)
{
	struct fake *fake = user;
	struct fake_memory *memory = image->memory;
	assert_true(pthread_equal(fake->owner, pthread_self()));
	assert_true(memory->busy);
	if (fake->fail_settle)
		return fail_with(STATUS_NO_GL, "GL: the context is lost; restart");
	*settled = memory->asks == 0;
	memory->asks -= memory->asks > 0;
	if (!*settled)
		return STATUS_OK;
	if (memory->filling)
		memcpy(image->bytes, &memory->content, sizeof memory->content);
	assert_memory_equal(image->bytes, &memory->content, sizeof memory->content);
	memory->busy = false;
	return STATUS_OK;
}

/* Who still reads it finds no version of any page. */
static inline void fake_drop(void *user, struct page_image *image)
{
	const struct fake *fake = user;
	assert_true(!((const struct fake_memory *)image->memory)->busy || fake->ends);
	memset(image->bytes, 0xdd, sizeof(struct content));
}

static inline enum status fake_read_back(void *user, uint32_t slot, struct page_image *image)
{
	struct fake *fake = user;
	const struct content *here = &fake->slots[slot];
	assert_true(pthread_equal(fake->owner, pthread_self()));
	assert_int_equal(((struct fake_memory *)image->memory)->kind, PAGE_CHANGED_IMAGE);
	assert_int_equal(here->key, image->key);
	if (fake->fail_read_back == image->key + 1 || fake->fail_read_back == UINT64_MAX)
		return fail_with(STATUS_NO_GL, "GL: the context is lost; restart");
	fake->read_back[fake->read_backs++ % LOG_MOST] = image->key;
	fake_begin(fake, image, here, true);
	return STATUS_OK;
}

/* The sum of all versions, which must be that of what is committed with it. */
static inline enum status fake_snapshot(void *user, struct page_image *image)
{
	struct fake *fake = user;
	assert_true(pthread_equal(fake->owner, pthread_self()));
	assert_int_equal(((struct fake_memory *)image->memory)->kind, PAGE_SNAPSHOT_IMAGE);
	if (fake->fail_snapshot)
		return fail_with(STATUS_NO_GL, "GL: the context is lost; restart");
	fake_begin(fake, image, &(struct content){.version = fake_sum(fake->model)}, true);
	return STATUS_OK;
}

static inline enum status fake_upload(void *user, uint32_t slot, struct page_image *image)
{
	struct fake *fake = user;
	struct content *here = &fake->slots[slot];
	assert_true(pthread_equal(fake->owner, pthread_self()));
	assert_int_equal(((struct fake_memory *)image->memory)->kind, PAGE_LOADED_IMAGE);
	assert_int_equal(fake->pins[slot], 0);
	assert_int_equal(image->flags, 7);
	memcpy(here, image->bytes, sizeof *here);
	assert_int_equal(here->key, image->key);
	fake_begin(fake, image, here, false);
	if (fake->fail_upload == image->key + 1)
		return fail_with(STATUS_NO_GL, "GL: out of memory; lower cache.slots");
	fake->uploaded[fake->uploads++ % LOG_MOST] = image->key;
	if (here->key >= COARSE) {
		struct fake_overlay overlay = {fake, here};
		page_cache_each_queued(fake->cache, fake_overlay_queued, &overlay);
		page_cache_each_resident(fake->cache, fake_overlay_resident, &overlay);
	}
	return STATUS_OK;
}

/* --- life --- */

static inline struct page_params fake_params(struct fake *fake, uint32_t slots, uint32_t loaders)
{
	return (struct page_params){
		.slots = slots,
		.loaders = loaders,
		.queue_soft = 8,
		.queue_most = 64,
		.record_bytes = sizeof(uint64_t),
		.io = {fake, fake_load, fake_commit},
		.executor = {fake, fake_create, fake_destroy, fake_upload, fake_read_back, NULL, fake_settled, fake_drop},
	};
}

static inline void fake_init(struct fake *fake)
{
	memset(fake, 0, sizeof *fake);
	mutex_init(&fake->mutex);
	condition_init(&fake->changed);
	fake->owner = pthread_self();
	for (unsigned key = 0; key < FINE; key++)
		fake->store[key] = fake->model[key] = 100;
}

static inline void fake_start(struct fake *fake, const struct page_params *params)
{
	fake_init(fake);
	assert_int_equal(page_cache_create(params, &fake->cache), STATUS_OK);
}

static inline void fake_finish(struct fake *fake)
{
	fake->ends = true;
	page_cache_destroy(fake->cache);
	assert_int_equal(fake->images[PAGE_LOADED_IMAGE], 0);
	assert_int_equal(fake->images[PAGE_CHANGED_IMAGE], 0);
	assert_int_equal(fake->images[PAGE_SNAPSHOT_IMAGE], 0);
	assert_false(fake->commit_differs);
	assert_false(fake->queued_differs);
	condition_finish(&fake->changed);
	mutex_finish(&fake->mutex);
}

/* --- gates, from any thread --- */

static inline void fake_gate(struct fake *fake, uint64_t hold_load, bool hold_commits)
{
	mutex_lock(&fake->mutex);
	fake->hold_load = hold_load;
	fake->hold_commits = hold_commits;
	condition_wake_all(&fake->changed);
	mutex_unlock(&fake->mutex);
}

static inline void fake_await(struct fake *fake, unsigned loads, unsigned commits)
{
	mutex_lock(&fake->mutex);
	while (fake->loads_begun < loads || fake->commits_begun < commits)
		condition_wait(&fake->changed, &fake->mutex);
	mutex_unlock(&fake->mutex);
}

/* Opens all gates from another thread once so many loads and commits began. */
struct fake_opener {
	struct fake *fake;
	unsigned loads, commits;
	struct thread thread;
};

static inline void *fake_opener_body(void *argument)
{
	struct fake_opener *opener = argument;
	fake_await(opener->fake, opener->loads, opener->commits);
	fake_gate(opener->fake, 0, false);
	return NULL;
}

static inline void fake_open_later(struct fake_opener *opener, struct fake *fake, unsigned loads,
				   unsigned commits)
{
	*opener = (struct fake_opener){.fake = fake, .loads = loads, .commits = commits};
	enum status status = thread_start(&opener->thread, fake_opener_body, opener, "opener");
	assert_int_equal(status, STATUS_OK);
}

/* --- what a step does --- */

static inline struct page_stats fake_stats(struct fake *fake)
{
	struct page_stats stats;
	page_cache_stats(fake->cache, &stats);
	return stats;
}

static inline uint32_t fake_pin(struct fake *fake, uint64_t key)
{
	uint32_t slot = UINT32_MAX;
	assert_int_equal(page_cache_pin(fake->cache, key, &slot), STATUS_OK);
	assert_int_equal(fake->slots[slot].key, key);
	if (key < FINE)
		assert_int_equal(fake->slots[slot].version, fake->model[key]);
	fake->pins[slot]++;
	return slot;
}

static inline void fake_unpin(struct fake *fake, uint64_t key)
{
	uint32_t slot;
	assert_true(page_cache_peek(fake->cache, key, false, &slot));
	assert_true(fake->pins[slot]-- > 0);
	page_cache_unpin(fake->cache, key);
}

static inline void fake_visit(struct fake *fake, uint64_t key)
{
	fake_pin(fake, key);
	fake_unpin(fake, key);
}

/* Evicts everything: the slots are full of other pages then. */
static inline void fake_push_out(struct fake *fake, uint32_t slots, uint64_t first)
{
	for (uint32_t i = 0; i < slots; i++)
		fake_visit(fake, first + i);
}

static inline void fake_want(struct fake *fake, uint64_t key)
{
	page_cache_want(fake->cache, &key, 1);
}

/* Pins, changes and unpins a page. */
static inline void fake_change(struct fake *fake, uint64_t key)
{
	uint32_t slot = fake_pin(fake, key);
	fake->slots[slot].version = ++fake->model[key];
	page_cache_dirty(fake->cache, key);
	fake_unpin(fake, key);
}

static inline void fake_end_step(struct fake *fake, uint64_t record)
{
	assert_int_equal(page_cache_end_step(fake->cache, &record), STATUS_OK);
}

static inline void fake_flush(struct fake *fake, uint64_t record)
{
	assert_int_equal(page_cache_flush(fake->cache, &record), STATUS_OK);
	assert_int_equal(fake->record, record);
	assert_memory_equal(fake->store, fake->model, sizeof fake->store);
}

static inline bool fake_resident(struct fake *fake, uint64_t key)
{
	uint32_t slot;
	return page_cache_peek(fake->cache, key, false, &slot);
}

static inline uint64_t fake_stored(struct fake *fake, uint64_t key)
{
	mutex_lock(&fake->mutex);
	uint64_t version = fake->store[key];
	mutex_unlock(&fake->mutex);
	return version;
}

/* --- where the newest bits of every page are: in the store, in the queue, in a dirty slot --- */

static inline void fake_find_newest(void *user, const struct page_image *image)
{
	uint64_t *newest = user;
	newest[image->key] = ((const struct content *)image->bytes)->version;
}

static inline void fake_find_dirty(void *user, uint64_t key, uint32_t slot, bool dirty)
{
	struct fake_overlay *overlay = user;
	if (dirty)
		overlay->fake->model[key] -= overlay->fake->slots[slot].version;
}

/* Leaves the model useless. Read-backs must be settled. */
static inline void fake_check_nothing_is_lost(struct fake *fake)
{
	uint64_t newest[FINE];
	struct fake_overlay overlay = {fake, NULL};
	mutex_lock(&fake->mutex);
	memcpy(newest, fake->store, sizeof newest);
	mutex_unlock(&fake->mutex);
	page_cache_each_queued(fake->cache, fake_find_newest, newest);
	page_cache_each_resident(fake->cache, fake_find_dirty, &overlay); /* 0 for those it has */
	for (unsigned key = 0; key < FINE; key++)
		assert_true(fake->model[key] == 0 || fake->model[key] == newest[key]);
}

/* What page_cache_each_queued shows of one key: how often, and the last version. */
struct fake_seen {
	uint64_t key;
	unsigned count;
	uint64_t version;
};

static inline void fake_see(void *user, const struct page_image *image)
{
	struct fake_seen *seen = user;
	if (image->key != seen->key)
		return;
	seen->count++;
	seen->version = ((const struct content *)image->bytes)->version;
}

static inline struct fake_seen fake_queued(struct fake *fake, uint64_t key)
{
	struct fake_seen seen = {.key = key};
	page_cache_each_queued(fake->cache, fake_see, &seen);
	return seen;
}

#endif
