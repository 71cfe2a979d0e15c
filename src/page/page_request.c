/*
 * Prefetch requests: which pages are loaded ahead, in which order, and which pages stay for them.
 *
 * A new list replaces the one before. It is served from its front, as far as there are slots that this step has not used. So a
 * requested page always finds a page that may go. Requests never evict each other, or a page that is being drawn. A page that
 * is no longer requested is given up, in whatever state it is.
 */
#include "page/page_internal.h"

#include <assert.h>

void page_use_locked(struct page_cache *cache, struct page *page)
{
	struct page_table *table = &cache->table;
	table->used += page->used_in != cache->step;
	page->used_in = cache->step;
	page_list_remove(&table->resident, page);
	page_list_append(&table->resident, page);
}

bool page_requested(const struct page_cache *cache, const struct page *page)
{
	return page->requested_in == cache->request_list && page->requested_in > 0;
}

/* Puts the page at its place in the list; false if it cannot, since a stale load of it is running. */
static bool request_locked(struct page_cache *cache, uint64_t key, size_t at)
{
	struct page_table *table = &cache->table;
	struct page *page = page_table_find_locked(table, key);
	if (page != NULL && page->stale)
		return false;
	if (page == NULL) {
		page = page_loads_want_locked(cache, key, false);
	} else if (page->state == PAGE_WANTED) {
		page_list_remove(&table->requested, page);
		page_list_append(&table->requested, page);
	}
	page->requested_in = cache->request_list;
	page->requested_at = at;
	return true;
}

static void cancel_locked(struct page_cache *cache)
{
	struct page_table *table = &cache->table;
	struct page *next;
	/* Pages that are requested again went behind the others. */
	while (table->requested.first != NULL && !page_requested(cache, table->requested.first)) {
		page_loads_abandon_locked(cache, table->requested.first);
		cache->stats.cancelled++;
	}
	for (struct page *page = table->flights.first; page != NULL; page = next) {
		next = page->next;
		if (page->urgent || page->stale || page_requested(cache, page))
			continue;
		page_loads_abandon_locked(cache, page);
		cache->stats.cancelled++;
	}
}

void page_cache_want(struct page_cache *cache, const uint64_t *keys, size_t count)
{
	assert(page_owner(cache));
	if (cache->params.loaders == 0)
		return; /* nobody loads ahead */
	mutex_lock(&cache->mutex);
	assert(cache->table.urgent.count == 0);
	uint32_t room = cache->params.slots - cache->table.used;
	cache->request_list++;
	cache->requests_kept = true;
	for (size_t i = 0; i < count; i++) {
		const struct page *page = page_table_find_locked(&cache->table, keys[i]);
		bool used = page != NULL && page->state == PAGE_RESIDENT && page->used_in == cache->step;
		if (!used && room == 0) {
			cache->requests_kept = false;
			break;
		}
		room -= !used;
		if (!request_locked(cache, keys[i], i))
			cache->requests_kept = false;
	}
	cancel_locked(cache);
	assert(page_cache_sane_locked(cache));
	mutex_unlock(&cache->mutex);
}

enum page_request_state page_cache_request_state(struct page_cache *cache)
{
	assert(page_owner(cache));
	mutex_lock(&cache->mutex);
	bool coming = cache->table.requested.count > 0 || page_loads_ahead_locked(cache) > 0;
	bool here = cache->requests_kept || cache->params.loaders == 0;
	mutex_unlock(&cache->mutex);
	return coming ? PAGE_REQUESTS_COMING : here ? PAGE_REQUESTS_HERE : PAGE_REQUESTS_SHORT;
}
