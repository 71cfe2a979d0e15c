/*
 * The owner's work list: uploads, and the read-backs that make room for them.
 *
 *     LOADED -> take a slot (free, or of the least recently used page that may go) -> upload
 *
 * A dirty page goes to the queue before its slot is given away, and only once it is read back does
 * it count as clean: whatever fails on the way, its newest bits are still in its slot or already
 * wait. The executor is called without the mutex (8).
 */
#include "page/page_internal.h"

#include <assert.h>

enum status page_read_back(struct page_cache *cache, struct page *page)
{
	assert(page->state == PAGE_RESIDENT && page->dirty); /* 3 */
	const struct page_executor *executor = &cache->params.executor;
	struct page_host *host = page_host_acquire(cache, page->key);
	if (host == NULL)
		return fail_memory("reading a page back");
	enum status status =
		executor->execute(executor->user, PAGE_READ_BACK, page->slot, &host->image);
	mutex_lock(&cache->mutex);
	if (status == STATUS_OK) {
		page_queue_wait_locked(cache, host);
		page->dirty = false;
	} else {
		failure_capture(&cache->failure, status);
		page_host_release_locked(cache, host);
	}
	mutex_unlock(&cache->mutex);
	return status;
}

/* A prefetch takes nothing from the step that runs. */
static struct page *find_victim(const struct page_cache *cache, bool prefetch)
{
	struct page *page = cache->table.resident.first;
	while (page != NULL && (page->pins > 0 || (prefetch && page->pinned_in == cache->step)))
		page = page->next;
	return page;
}

bool page_prefetch_has_slot(const struct page_cache *cache)
{
	return cache->table.free_count > 0 || find_victim(cache, true) != NULL;
}

/* Room in the queue for one more version of `key`, waiting for the commit in flight if that gives
 * it. A prefetch does not wait: `*room` is false then. */
static enum status make_room(struct page_cache *cache, uint64_t key, bool prefetch, bool *room)
{
	struct page_queue *queue = &cache->queue;
	uint32_t hard = cache->params.queue_hard;
	mutex_lock(&cache->mutex);
	if (queue->waiting.count + queue->committing.count + queue->kept.count >= hard)
		page_loads_abandon_late_locked(cache);
	*room = page_queue_find_locked(queue, key, PAGE_WAITING) != NULL;
	while (!*room && !prefetch && cache->epoch_in_flight &&
	       queue->waiting.count + queue->committing.count >= hard)
		condition_wait(&cache->done, &cache->mutex);
	*room = *room || queue->waiting.count + queue->committing.count < hard;
	enum status status = page_sticky_locked(cache);
	if (status == STATUS_OK && !*room && !prefetch)
		status = fail_with(STATUS_FAILED,
				   "page cache: the queue is full, %u changed pages wait for the "
				   "step's end; raise cache.slots",
				   queue->waiting.count);
	mutex_unlock(&cache->mutex);
	return status;
}

/* A slot for a page; PAGE_NO_SLOT without failure only for a prefetch that finds none. */
static enum status take_slot(struct page_cache *cache, bool prefetch, uint32_t *slot)
{
	struct page_table *table = &cache->table;
	mutex_lock(&cache->mutex);
	*slot = table->free_count > 0 ? table->free_slots[--table->free_count] : PAGE_NO_SLOT;
	mutex_unlock(&cache->mutex);
	if (*slot != PAGE_NO_SLOT)
		return STATUS_OK;
	struct page *page = find_victim(cache, prefetch);
	assert(page != NULL || prefetch); /* page_cache_pin_all counted the slots */
	if (page == NULL)
		return STATUS_OK;
	if (page->dirty) {
		bool room;
		enum status status = make_room(cache, page->key, prefetch, &room);
		if (status == STATUS_OK && !room)
			return STATUS_OK;
		if (status == STATUS_OK)
			status = page_read_back(cache, page);
		if (status != STATUS_OK)
			return status;
	}
	mutex_lock(&cache->mutex);
	*slot = page->slot;
	page_table_forget_locked(table, page, &table->resident);
	cache->stats.evictions++;
	mutex_unlock(&cache->mutex);
	return STATUS_OK;
}

enum status page_install(struct page_cache *cache, struct page *page)
{
	assert(page->state == PAGE_LOADED);
	const struct page_executor *executor = &cache->params.executor;
	struct page_host *host = page->host;
	uint32_t slot = PAGE_NO_SLOT;
	enum status loaded = STATUS_OK, status = STATUS_OK;
	mutex_lock(&cache->mutex);
	bool prefetch = !page->urgent;
	page->urgent = true; /* making room must not abandon it now */
	mutex_unlock(&cache->mutex);
	if (host == NULL)
		loaded = fail_memory("loading a page");
	else if (host->failure.status != STATUS_OK)
		loaded = failure_restore(&host->failure);
	else
		status = take_slot(cache, prefetch, &slot);
	bool uploaded = false;
	if (slot != PAGE_NO_SLOT) {
		status = executor->execute(executor->user, PAGE_UPLOAD, slot, &host->image);
		uploaded = status == STATUS_OK;
	}
	mutex_lock(&cache->mutex);
	if (slot != PAGE_NO_SLOT && !uploaded)
		cache->table.free_slots[cache->table.free_count++] = slot;
	page_loads_land_locked(cache, page, uploaded ? slot : PAGE_NO_SLOT);
	mutex_unlock(&cache->mutex);
	return loaded != STATUS_OK && !prefetch ? loaded : status;
}
