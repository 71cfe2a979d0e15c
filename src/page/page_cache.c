/*
 * The cache as a whole: creation, commits, figures.
 *
 * A commit starts only in page_cache_end_step and page_cache_flush, where every page is as a step left it. Dirty pages are read
 * back. With all waiting images, the record and the snapshot they are one commit (5). So a page that is evicted in the middle
 * of a step is never committed before the rest of that step.
 */
#include "page/page_internal.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#define COMMIT_REST 4 /* commits that follow each other by age take at most a fifth of the writer's time */

/* --- life --- */

static enum status start_threads(struct page_cache *cache)
{
	if (cache->params.io.commit != NULL)
		TRY(thread_start(&cache->writer, page_writer_body, cache, PAGE_WRITER_THREAD));
	for (uint32_t i = 0; i < cache->params.loaders; i++) {
		struct page_loader *loader = &cache->loaders[i];
		*loader = (struct page_loader){.cache = cache, .number = i};
		TRY(thread_start(&loader->thread, page_loader_body, loader, PAGE_LOADER_THREAD));
	}
	return STATUS_OK;
}

static enum status make_snapshot(struct page_cache *cache)
{
	TRY(page_host_make(cache, PAGE_SNAPSHOT_IMAGE));
	mutex_lock(&cache->mutex);
	cache->commit_snapshot = page_host_acquire_locked(cache, PAGE_SNAPSHOT_IMAGE, 0);
	mutex_unlock(&cache->mutex);
	return STATUS_OK;
}

enum status page_cache_create(const struct page_params *params, struct page_cache **out)
{
	assert(params->slots >= 1);
	struct page_cache *cache = mem_calloc(1, sizeof *cache);
	TRY_MEM(cache, "the page cache");
	cache->params = *params;
	cache->owner = pthread_self();
	cache->step = 1;
	mutex_init(&cache->mutex);
	condition_init(&cache->work);
	condition_init(&cache->done);
	enum status status;
	TRY_OR(failed, page_table_init(&cache->table, params));
	TRY_OR(failed, page_queue_init(&cache->queue, params));
	cache->loaders = mem_calloc(params->loaders > 0 ? params->loaders : 1, sizeof *cache->loaders);
	cache->commit_images = mem_calloc(params->queue_most, sizeof *cache->commit_images);
	cache->commit_record = mem_calloc(1, params->record_bytes);
	if (cache->loaders == NULL || cache->commit_images == NULL || cache->commit_record == NULL)
		TRY_OR(failed, fail_memory("the page cache"));
	for (uint32_t i = 0; i < page_load_images(params->loaders); i++)
		TRY_OR(failed, page_host_make(cache, PAGE_LOADED_IMAGE));
	if (params->executor.snapshot != NULL)
		TRY_OR(failed, make_snapshot(cache));
	TRY_OR(failed, start_threads(cache));
	*out = cache;
	return STATUS_OK;
failed:
	page_cache_destroy(cache);
	return status;
}

void page_cache_stop(struct page_cache *cache)
{
	mutex_lock(&cache->mutex);
	cache->stopping = true;
	condition_wake_all(&cache->work);
	mutex_unlock(&cache->mutex);
	thread_join(&cache->writer);
	for (uint32_t i = 0; cache->loaders != NULL && i < cache->params.loaders; i++)
		thread_join(&cache->loaders[i].thread);
}

void page_cache_adopt(struct page_cache *cache)
{
	if (cache != NULL)
		cache->owner = pthread_self();
}

void page_cache_destroy(struct page_cache *cache)
{
	if (cache == NULL)
		return;
	page_cache_stop(cache);
	mutex_lock(&cache->mutex);
	while (cache->table.flights.first != NULL)
		page_loads_abandon_locked(cache, cache->table.flights.first);
	/* The executor's memory waits for what it has begun, when it is destroyed. */
	for (struct page_host *host = cache->busy.first, *next; host != NULL; host = next) {
		next = host->busy_next;
		host->filling = false;
		page_host_release_locked(cache, host);
	}
	if (cache->commit_snapshot != NULL) {
		cache->commit_snapshot->place = PAGE_UNQUEUED;
		page_host_release_locked(cache, cache->commit_snapshot);
	}
	mutex_unlock(&cache->mutex);
	page_queue_finish(cache);
	page_table_finish(&cache->table);
	key_set_finish(&cache->touched);
	mem_free_all(cache->loaders, cache->commit_images, cache->commit_record);
	condition_finish(&cache->done);
	condition_finish(&cache->work);
	mutex_finish(&cache->mutex);
	mem_free(cache);
}

/* --- commits --- */

static enum status read_back_dirty(struct page_cache *cache)
{
	for (struct page *page = cache->table.resident.first; page != NULL; page = page->next)
		if (page->dirty)
			TRY(page_read_back(cache, page, false));
	return STATUS_OK;
}

/* After the read-backs, so that a wait for the first of them is not longer than it must be. */
static enum status take_snapshot(struct page_cache *cache)
{
	const struct page_executor *executor = &cache->params.executor;
	if (executor->snapshot == NULL)
		return STATUS_OK;
	const enum status status = executor->snapshot(executor->user, &cache->commit_snapshot->image);
	if (status != STATUS_OK)
		return page_executor_failed(cache, status);
	mutex_lock(&cache->mutex);
	page_busy_add_locked(cache, cache->commit_snapshot, true);
	mutex_unlock(&cache->mutex);
	return STATUS_OK;
}

enum status page_wait_for_commit_locked(struct page_cache *cache, bool stall)
{
	TRY(page_sticky_locked(cache));
	bool stalled = false;
	while (cache->commit != PAGE_COMMIT_NONE)
		TRY(stall ? page_stall_locked(cache, &stalled) : page_wait_locked(cache));
	return STATUS_OK;
}

static enum status wait_for_last_commit(struct page_cache *cache, bool stall)
{
	enum status status;
	mutex_lock(&cache->mutex);
	TRY_OR(unlock, page_wait_for_commit_locked(cache, stall));
	page_loads_abandon_late_locked(cache);
unlock:
	mutex_unlock(&cache->mutex);
	return status;
}

enum status page_start_commit(struct page_cache *cache, const void *record, bool stall)
{
	TRY(wait_for_last_commit(cache, stall));
	TRY(read_back_dirty(cache));
	if (cache->params.begin_commit != NULL)
		TRY(cache->params.begin_commit(cache->params.begin_commit_user));
	TRY(take_snapshot(cache));
	mutex_lock(&cache->mutex);
	page_queue_begin_commit_locked(cache);
	memcpy(cache->commit_record, record, cache->params.record_bytes);
	cache->dirty_since = 0;
	assert(page_cache_sane_locked(cache));
	condition_wake_all(&cache->work);
	mutex_unlock(&cache->mutex);
	return page_settle(cache);
}

/* Many changes or an old one start a commit. It waits for the commit in flight only at twice that number. So the number of
 * waiting changes is bounded, however fast the ground changes. */
bool page_commit_is_due_locked(const struct page_cache *cache)
{
	const struct page_params *params = &cache->params;
	uint32_t changed = cache->queue.waiting.count + cache->table.dirty;
	if (cache->commit != PAGE_COMMIT_NONE)
		return changed >= 2 * params->queue_soft;
	const double age = fmax(params->commit_age, COMMIT_REST * cache->commit_took);
	return changed >= params->queue_soft || (params->commit_age > 0 && cache->dirty_since > 0 && clock_seconds() - cache->dirty_since > age);
}

enum status page_cache_end_step(struct page_cache *cache, const void *record)
{
	assert(page_owner(cache));
	const enum status settled = page_settle(cache);
	mutex_lock(&cache->mutex);
	assert(page_cache_sane_locked(cache));
	cache->step++;
	cache->table.used = 0;
	const enum status status = settled != STATUS_OK ? settled : page_sticky_locked(cache);
	const bool due = !cache->params.commits_begun && !cache->held && page_commit_is_due_locked(cache);
	mutex_unlock(&cache->mutex);
	TRY(status);
	return due ? page_start_commit(cache, record, true) : STATUS_OK;
}

void page_cache_hold(struct page_cache *cache, bool held)
{
	assert(page_owner(cache));
	cache->held = held;
}

enum status page_cache_flush(struct page_cache *cache, const void *record)
{
	assert(page_owner(cache));
	TRY(page_start_commit(cache, record, false));
	mutex_lock(&cache->mutex);
	const enum status status = page_wait_for_commit_locked(cache, false);
	mutex_unlock(&cache->mutex);
	return status;
}

/* --- looking at it --- */

void page_cache_each_resident(struct page_cache *cache, page_resident_fn fn, void *user)
{
	assert(page_owner(cache));
	for (struct page *page = cache->table.resident.first; page != NULL; page = page->next)
		fn(user, page->key, page->slot, page->dirty);
}

void page_cache_stats(struct page_cache *cache, struct page_stats *stats)
{
	assert(page_owner(cache));
	mutex_lock(&cache->mutex);
	*stats = cache->stats;
	stats->touched = cache->touched.count;
	mutex_unlock(&cache->mutex);
}
