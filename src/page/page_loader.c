/*
 * Loads: the pages that are wanted, the loader threads, and the running loads.
 *
 *     WANTED (urgent, in order of asking, or requested) -> LOADING -> LOADED -> the owner makes it resident
 *
 * Loaders first take pages that a pin waits for. They take none whose newest version is still being read back (10). A load gets
 * its image when it is taken. So a pin of many pages needs no more memory than a pin of a few. The flights are in the order in
 * which they began. So the first one tells which committed images must still be kept (6). Without loaders the owner loads the
 * pages that its own pin waits for.
 */
#include "page/page_internal.h"

#include <assert.h>

uint32_t page_load_images(uint32_t loaders)
{
	return PAGE_FLIGHTS_PER_LOADER * (loaders > 0 ? loaders : 1);
}

struct page *page_loads_want_locked(struct page_cache *cache, uint64_t key, bool urgent)
{
	struct page_table *table = &cache->table;
	struct page *page =
		page_table_add_locked(table, key, urgent ? &table->urgent : &table->requested);
	page->urgent = urgent;
	condition_wake_all(&cache->work);
	return page;
}

void page_loads_make_urgent_locked(struct page_cache *cache, struct page *page)
{
	assert(page->state != PAGE_RESIDENT && !page->stale);
	if (page->state == PAGE_WANTED && !page->urgent) {
		page_list_remove(&cache->table.requested, page);
		page_list_append(&cache->table.urgent, page);
		condition_wake_all(&cache->work); /* for requests there may be no room now */
	}
	page->urgent = true;
}

static void drop_locked(struct page_cache *cache, struct page *page)
{
	struct page_host *host = page->host;
	page->host = NULL;
	page_table_forget_locked(&cache->table, page, &cache->table.flights);
	page_host_release_locked(cache, host);
	page_queue_release_kept_locked(cache);
	condition_wake_all(&cache->work); /* there is room for another flight */
}

void page_loads_abandon_locked(struct page_cache *cache, struct page *page)
{
	assert(page->state != PAGE_RESIDENT);
	struct page_table *table = &cache->table;
	cache->requests_kept = cache->requests_kept && !page_requested(cache, page);
	if (page->state == PAGE_WANTED) {
		page_table_forget_locked(table, page,
					 page->urgent ? &table->urgent : &table->requested);
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
		if (page->urgent || page->stale)
			continue;
		page_loads_abandon_locked(cache, page);
		cache->stats.cancelled++;
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

uint32_t page_loads_ahead_locked(const struct page_cache *cache)
{
	uint32_t count = 0;
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

/* Returns the first page of the list whose newest version can be read now. */
static struct page *first_readable_locked(const struct page_cache *cache, const struct page_list *list)
{
	struct page *page = list->first;
	for (; page != NULL; page = page->next) {
		const struct page_host *queued = page_queue_newest_locked(&cache->queue, page->key);
		if (queued == NULL || !queued->filling)
			return page;
	}
	return NULL;
}

/* Takes the next page to load: sets it to LOADING and gives it an image. Returns NULL if there is none now. */
static struct page *take_locked(struct page_cache *cache)
{
	struct page_table *table = &cache->table;
	uint32_t most = page_load_images(cache->params.loaders);
	if (cache->queue.unused[PAGE_LOADED_IMAGE] == NULL || table->flights.count >= most)
		return NULL; /* 9 */
	struct page_list *list = &table->urgent;
	struct page *page = first_readable_locked(cache, list);
	if (page == NULL && page_loads_ahead_locked(cache) < PAGE_REQUESTS_PER_LOADER * cache->params.loaders) {
		list = &table->requested;
		page = first_readable_locked(cache, list);
		cache->stats.prefetched += page != NULL;
	}
	if (page == NULL)
		return NULL;
	page_list_remove(list, page);
	page_list_append(&table->flights, page);
	page->state = PAGE_LOADING;
	page->begun = ++cache->load_clock;
	page->host = page_host_acquire_locked(cache, PAGE_LOADED_IMAGE, page->key);
	return page;
}

bool page_load_next_locked(struct page_cache *cache, unsigned loader)
{
	const struct page_io *io = &cache->params.io;
	struct page *page = take_locked(cache);
	if (page == NULL)
		return false;
	struct page_host *host = page->host;
	struct page_host *queued = page_queue_newest_locked(&cache->queue, page->key);
	if (queued != NULL)
		queued->refs++;
	mutex_unlock(&cache->mutex);
	enum status status =
		io->load(io->user, loader, &host->image, queued != NULL ? &queued->image : NULL);
	failure_capture(&host->failure, status);
	mutex_lock(&cache->mutex);
	if (queued != NULL)
		page_host_release_locked(cache, queued);
	assert(page->host == host && page->state == PAGE_LOADING); /* 7 */
	if (page->stale) {
		page->stale = false;
		drop_locked(cache, page);
	} else {
		page->state = PAGE_LOADED;
	}
	condition_wake_all(&cache->done);
	return true;
}

void *page_loader_body(void *argument)
{
	struct page_loader *loader = argument;
	struct page_cache *cache = loader->cache;
	thread_background();
	mutex_lock(&cache->mutex);
	while (!cache->stopping)
		if (!page_load_next_locked(cache, loader->number))
			condition_wait(&cache->work, &cache->mutex);
	mutex_unlock(&cache->mutex);
	return NULL;
}
