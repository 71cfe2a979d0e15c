/*
 * Finds the newest version of a page, wherever it is, for queries between two steps. It changes nothing that decides which page
 * goes or stays.
 */
#include "page/page_internal.h"

#include <assert.h>

enum status page_hold_newest(struct page_cache *cache, uint64_t key, struct page_host **host)
{
	enum status status = STATUS_OK;
	mutex_lock(&cache->mutex);
	/* An image that is being filled is in busy, so there is something to wait for. */
	while ((*host = page_queue_newest_locked(&cache->queue, key)) != NULL && (*host)->filling)
		TRY_OR(unlock, page_wait_locked(cache));
	if (*host != NULL)
		(*host)->refs++;
unlock:
	mutex_unlock(&cache->mutex);
	return status;
}

enum status page_cache_newest(struct page_cache *cache, uint64_t key, page_image_fn fn, void *user, enum page_newest *newest,
			      uint32_t *slot)
{
	assert(page_owner(cache));
	struct page_host *host;
	mutex_lock(&cache->mutex);
	const struct page *page = page_table_find_locked(&cache->table, key);
	const bool dirty = page != NULL && page->dirty;
	if (dirty)
		*slot = page->slot;
	mutex_unlock(&cache->mutex);
	*newest = PAGE_NEWEST_SLOT;
	if (dirty)
		return STATUS_OK;
	TRY(page_hold_newest(cache, key, &host));
	*newest = host != NULL ? PAGE_NEWEST_QUEUED : PAGE_NEWEST_STORED;
	if (host == NULL)
		return STATUS_OK;
	fn(user, &host->image);
	mutex_lock(&cache->mutex);
	page_host_release_locked(cache, host);
	mutex_unlock(&cache->mutex);
	return STATUS_OK;
}

void page_cache_each_changed(struct page_cache *cache, page_key_fn fn, void *user)
{
	assert(page_owner(cache));
	mutex_lock(&cache->mutex);
	for (const struct page *page = cache->table.resident.first; page != NULL; page = page->next)
		if (page->dirty)
			fn(user, page->key);
	const struct page_host_list *lists[] = {&cache->queue.committing, &cache->queue.waiting};
	for (int i = 0; i < 2; i++)
		for (const struct page_host *host = lists[i]->first; host != NULL; host = host->next)
			fn(user, host->image.key);
	mutex_unlock(&cache->mutex);
}
