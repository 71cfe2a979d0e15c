/*
 * The page table: finds a page by key. It has the lists of pages, and the free slots.
 *
 * Nothing here allocates after page_table_init, since it makes as many pages as can be known at once. That is one for each
 * slot, the pages of one pin, the running loads (9), and one prefetch request for each slot. While one list of requests
 * replaces another, the requests of the old list count too.
 */
#include "page/page_internal.h"

#include <assert.h>

static size_t pages_most(const struct page_params *params)
{
	const size_t pinned = params->slots < PAGE_PIN_MOST ? params->slots : PAGE_PIN_MOST;
	return 3 * (size_t)params->slots + pinned + page_load_images(params->loaders);
}

enum status page_table_init(struct page_table *table, const struct page_params *params)
{
	size_t most = pages_most(params), buckets = 64;
	while (buckets < 2 * most)
		buckets *= 2;
	table->buckets = mem_calloc(buckets, sizeof *table->buckets);
	table->pages = mem_calloc(most, sizeof *table->pages);
	table->free_slots = mem_calloc(params->slots, sizeof *table->free_slots);
	TRY_MEM(table->buckets != NULL && table->pages != NULL && table->free_slots != NULL, "the page table");
	table->mask = buckets - 1;
	for (size_t i = most; i-- > 0;) {
		table->pages[i].hash_next = table->unused;
		table->unused = &table->pages[i];
	}
	while (table->free_count < params->slots) {
		table->free_slots[table->free_count] = params->slots - 1 - table->free_count;
		table->free_count++;
	}
	return STATUS_OK;
}

void page_table_finish(struct page_table *table)
{
	mem_free_all(table->buckets, table->pages, table->free_slots);
}

struct page *page_table_find_locked(const struct page_table *table, uint64_t key)
{
	struct page *page = table->buckets[key_hash(key) & table->mask];
	while (page != NULL && page->key != key)
		page = page->hash_next;
	return page;
}

struct page *page_table_add_locked(struct page_table *table, uint64_t key, struct page_list *list)
{
	assert(page_table_find_locked(table, key) == NULL);
	struct page *page = table->unused;
	assert(page != NULL); /* 9 */
	table->unused = page->hash_next;
	struct page **bucket = &table->buckets[key_hash(key) & table->mask];
	*page = (struct page){.key = key, .slot = PAGE_NO_SLOT, .hash_next = *bucket};
	*bucket = page;
	page_list_append(list, page);
	return page;
}

void page_table_forget_locked(struct page_table *table, struct page *page, struct page_list *list)
{
	assert(page->pins == 0 && !page->dirty && page->host == NULL); /* 3 */
	page_list_remove(list, page);
	struct page **at = &table->buckets[key_hash(page->key) & table->mask];
	while (*at != page)
		at = &(*at)->hash_next;
	*at = page->hash_next;
	page->hash_next = table->unused;
	table->unused = page;
}

void page_list_append(struct page_list *list, struct page *page)
{
	page->prev = list->last;
	page->next = NULL;
	*(list->last != NULL ? &list->last->next : &list->first) = page;
	list->last = page;
	list->count++;
}

void page_list_remove(struct page_list *list, struct page *page)
{
	*(page->prev != NULL ? &page->prev->next : &list->first) = page->next;
	*(page->next != NULL ? &page->next->prev : &list->last) = page->prev;
	page->prev = page->next = NULL;
	list->count--;
}

static bool list_sane_locked(const struct page_table *table, const struct page_list *list)
{
	uint32_t count = 0;
	const struct page *before = NULL;
	for (const struct page *page = list->first; page != NULL;
	     before = page, page = page->next) {
		bool resident = page->state == PAGE_RESIDENT;
		bool flying = page->state == PAGE_LOADING || page->state == PAGE_LOADED;
		if (page->prev != before || page_table_find_locked(table, page->key) != page)
			return false;
		if ((list == &table->resident) != resident || (list == &table->flights) != flying)
			return false; /* 1 */
		if ((page->slot != PAGE_NO_SLOT) != resident)
			return false; /* 2 */
		if (!resident && (page->pins > 0 || page->dirty))
			return false; /* 3 */
		if (page->stale && (page->state != PAGE_LOADING || page->urgent))
			return false; /* 7 */
		if (flying && before != NULL && before->begun >= page->begun)
			return false;
		count++;
	}
	return count == list->count && list->last == before;
}

static bool queue_sane_locked(const struct page_cache *cache)
{
	const struct page_queue *queue = &cache->queue;
	const struct page_host_list *lists[] = {&queue->kept, &queue->committing, &queue->waiting};
	for (int i = 0; i < 3; i++) {
		enum page_image_place place = (enum page_image_place)(PAGE_KEPT + i);
		for (const struct page_host *host = lists[i]->first; host != NULL;
		     host = host->next)
			if (host->place != place || host->refs == 0 ||
			    page_queue_find_locked(queue, host->image.key, place) != host)
				return false; /* 4 */
	}
	uint64_t oldest = page_loads_oldest_locked(cache);
	if (queue->kept.first != NULL && queue->kept.first->kept_until < oldest)
		return false; /* 6 */
	return cache->commit != PAGE_COMMIT_NONE || queue->committing.count == 0; /* 5 */
}

bool page_cache_sane_locked(const struct page_cache *cache)
{
	const struct page_table *table = &cache->table;
	uint32_t pinned = 0, dirty = 0, used = 0;
	for (const struct page *page = table->resident.first; page != NULL; page = page->next) {
		pinned += page->pins > 0;
		dirty += page->dirty;
		used += page->used_in == cache->step;
	}
	return pinned == table->pinned && dirty == table->dirty && used == table->used &&
	       table->resident.count + table->free_count <= cache->params.slots && /* 2 */
	       table->flights.count <= page_load_images(cache->params.loaders) && /* 9 */
	       page_loads_ahead_locked(cache) <=
		       PAGE_REQUESTS_PER_LOADER * cache->params.loaders && /* 9 */
	       cache->queue.made[PAGE_CHANGED_IMAGE] <= cache->params.queue_most &&
	       list_sane_locked(table, &table->resident) &&
	       list_sane_locked(table, &table->urgent) &&
	       list_sane_locked(table, &table->requested) &&
	       list_sane_locked(table, &table->flights) && queue_sane_locked(cache);
}
