/*
 * Loads: who wants what, the loader threads, and the loads that are on their way.
 *
 *     WANTED (urgent or prefetch, in order of asking) -> LOADING -> LOADED -> the owner installs it
 *
 * Loaders take what a pin waits for first. A load gets its image when it is taken, so that a pin
 * of many pages needs no more memory than one of a few. The flights are in the order they began,
 * so that the first one says which committed images must still be kept (6).
 */
#include "page/page_internal.h"

#include <assert.h>

void page_loads_want_locked(struct page_cache *cache, uint64_t key, bool urgent)
{
	struct page_table *table = &cache->table;
	struct page *page =
		page_table_add_locked(table, key, urgent ? &table->urgent : &table->prefetch);
	page->urgent = urgent;
	condition_wake_all(&cache->work);
}

void page_loads_make_urgent_locked(struct page_cache *cache, struct page *page)
{
	assert(page->state != PAGE_RESIDENT && !page->stale);
	if (page->state == PAGE_WANTED && !page->urgent) {
		page_list_remove(&cache->table.prefetch, page);
		page_list_append(&cache->table.urgent, page);
	}
	page->urgent = true;
}

static void drop_locked(struct page_cache *cache, struct page *page)
{
	struct page_host *host = page->host;
	page->host = NULL;
	page_table_forget_locked(&cache->table, page, &cache->table.flights);
	if (host != NULL)
		page_host_release_locked(cache, host);
	page_queue_release_kept_locked(cache);
	condition_wake_all(&cache->work); /* there is room for another flight */
}

void page_loads_abandon_locked(struct page_cache *cache, struct page *page)
{
	assert(page->state != PAGE_RESIDENT);
	struct page_table *table = &cache->table;
	if (page->state == PAGE_WANTED) {
		page_table_forget_locked(table, page,
					 page->urgent ? &table->urgent : &table->prefetch);
	} else if (page->state == PAGE_LOADED) {
		drop_locked(cache, page);
	} else {
		page->urgent = false;
		page->stale = true;
		page_queue_release_kept_locked(cache);
	}
}

void page_loads_abandon_late_locked(struct page_cache *cache)
{
	struct page_queue *queue = &cache->queue;
	struct page *next;
	if (queue->kept.last == NULL)
		return;
	uint64_t until = queue->kept.last->kept_until;
	for (struct page *page = cache->table.flights.first; page != NULL && page->begun <= until;
	     page = next) {
		next = page->next;
		if (!page->urgent)
			page_loads_abandon_locked(cache, page);
	}
}

void page_loads_land_locked(struct page_cache *cache, struct page *page, uint32_t slot)
{
	assert(page->state == PAGE_LOADED);
	if (slot == PAGE_NO_SLOT) {
		drop_locked(cache, page);
		return;
	}
	struct page_table *table = &cache->table;
	page_host_release_locked(cache, page->host);
	page->host = NULL;
	page_list_remove(&table->flights, page);
	page_list_append(&table->resident, page);
	page->state = PAGE_RESIDENT;
	page->urgent = false;
	page->slot = slot;
	page_queue_release_kept_locked(cache);
	condition_wake_all(&cache->work);
}

uint32_t page_loads_prefetching_locked(const struct page_cache *cache)
{
	uint32_t count = cache->table.prefetch.count;
	for (const struct page *page = cache->table.flights.first; page != NULL; page = page->next)
		count += !page->urgent && !page->stale;
	return count;
}

uint64_t page_loads_oldest_locked(const struct page_cache *cache)
{
	const struct page *page = cache->table.flights.first;
	while (page != NULL && page->stale)
		page = page->next;
	return page != NULL ? page->begun : UINT64_MAX;
}

/* --- the threads --- */

/* The next page to load, now LOADING; NULL if there is none or too many are on their way. */
static struct page *take_locked(struct page_cache *cache)
{
	struct page_table *table = &cache->table;
	struct page_list *list = table->urgent.first != NULL ? &table->urgent : &table->prefetch;
	struct page *page = list->first;
	if (page == NULL || table->flights.count >= PAGE_FLIGHTS_PER_LOADER * cache->params.loaders)
		return NULL; /* 9 */
	page_list_remove(list, page);
	page_list_append(&table->flights, page);
	page->state = PAGE_LOADING;
	page->begun = ++cache->load_clock;
	return page;
}

static struct page_host *load(struct page_loader *loader, uint64_t key, struct page_host *queued)
{
	struct page_cache *cache = loader->cache;
	struct page_host *host = page_host_acquire(cache, key);
	if (host == NULL)
		return NULL;
	const struct page_io *io = &cache->params.io;
	enum status status = io->load(io->user, loader->number, &host->image,
				      queued != NULL ? &queued->image : NULL);
	failure_capture(&host->failure, status);
	return host;
}

void *page_loader_body(void *argument)
{
	struct page_loader *loader = argument;
	struct page_cache *cache = loader->cache;
	mutex_lock(&cache->mutex);
	while (!cache->stopping) {
		struct page *page = take_locked(cache);
		if (page == NULL) {
			condition_wait(&cache->work, &cache->mutex);
			continue;
		}
		uint64_t key = page->key;
		struct page_host *queued = page_queue_newest_locked(&cache->queue, key);
		if (queued != NULL)
			queued->refs++;
		mutex_unlock(&cache->mutex);
		struct page_host *host = load(loader, key, queued);
		mutex_lock(&cache->mutex);
		if (queued != NULL)
			page_host_release_locked(cache, queued);
		assert(page->key == key && page->state == PAGE_LOADING); /* 7 */
		page->host = host;
		if (page->stale) {
			page->stale = false;
			drop_locked(cache, page);
		} else {
			page->state = PAGE_LOADED;
		}
		condition_wake_all(&cache->done);
	}
	mutex_unlock(&cache->mutex);
	return NULL;
}
