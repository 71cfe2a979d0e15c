/*
 * Moves pages from one cache to another, of another process, between two steps.
 *
 * A page that leaves is as one that is evicted: its newest bits go from its slot to an image in the queue. But the image is given to the
 * caller, and no commit of this cache writes it. A page that comes is put into the queue, as if it had just been evicted. So a load finds
 * it there, and the next commit writes it.
 */
#include "page/page_internal.h"

#include <assert.h>

/* Begins to read the page back if it is dirty, and frees its slot. The next upload into the slot comes after that. */
static enum status leave_slot(struct page_cache *cache, uint64_t key)
{
	mutex_lock(&cache->mutex);
	struct page *page = page_table_find_locked(&cache->table, key);
	if (page != NULL && page->state != PAGE_RESIDENT) {
		if (!page->stale)
			page_loads_abandon_locked(cache, page);
		page = NULL;
	}
	mutex_unlock(&cache->mutex);
	if (page == NULL)
		return STATUS_OK;
	if (page->dirty)
		TRY(page_read_back(cache, page, false));
	mutex_lock(&cache->mutex);
	page_drop_locked(cache, page);
	mutex_unlock(&cache->mutex);
	return STATUS_OK;
}

static enum status give(struct page_cache *cache, uint64_t key, page_taken_fn fn, void *user)
{
	struct page_host *host;
	TRY(page_hold_newest(cache, key, &host));
	const enum status status = fn(user, key, host != NULL ? &host->image : NULL);
	if (host == NULL)
		return status;
	mutex_lock(&cache->mutex);
	page_host_release_locked(cache, host);
	if (status == STATUS_OK)
		page_queue_drop_waiting_one_locked(cache, key);
	mutex_unlock(&cache->mutex);
	return status;
}

enum status page_cache_take(struct page_cache *cache, const uint64_t *keys, size_t count, page_taken_fn fn, void *user)
{
	assert(page_owner(cache));
	for (size_t i = 0; i < count; i++)
		TRY(leave_slot(cache, keys[i]));
	for (size_t i = 0; i < count; i++)
		TRY(give(cache, keys[i], fn, user));
	return STATUS_OK;
}

enum status page_cache_put(struct page_cache *cache, uint64_t key, page_fill_fn fn, void *user)
{
	assert(page_owner(cache));
	struct page_host *host;
	mutex_lock(&cache->mutex);
	struct page *page = page_table_find_locked(&cache->table, key);
	assert(page == NULL || !page->dirty);
	if (page != NULL && page->state == PAGE_RESIDENT)
		page_drop_locked(cache, page);
	else if (page != NULL && !page->stale)
		page_loads_abandon_locked(cache, page);
	mutex_unlock(&cache->mutex);
	TRY(page_take_changed_image(cache, key, &host));
	enum status status;
	TRY_OR(failed, fn(user, &host->image));
	mutex_lock(&cache->mutex);
	page_queue_wait_locked(cache, host);
	if (cache->dirty_since == 0)
		cache->dirty_since = clock_seconds();
	mutex_unlock(&cache->mutex);
	return STATUS_OK;
failed:
	mutex_lock(&cache->mutex);
	page_host_release_locked(cache, host);
	mutex_unlock(&cache->mutex);
	return status;
}

/* --- commits that the owner begins --- */

bool page_cache_commit_due(struct page_cache *cache)
{
	mutex_lock(&cache->mutex);
	const bool due = page_commit_is_due_locked(cache);
	mutex_unlock(&cache->mutex);
	return due;
}

enum status page_cache_await_commit(struct page_cache *cache)
{
	assert(page_owner(cache));
	mutex_lock(&cache->mutex);
	enum status status = page_wait_for_commit_locked(cache, true);
	mutex_unlock(&cache->mutex);
	return status;
}

enum status page_cache_begin_commit(struct page_cache *cache, const void *record)
{
	assert(page_owner(cache));
	return page_start_commit(cache, record, true);
}
